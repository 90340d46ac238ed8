// SPDX-License-Identifier: BSD-3-Clause
#include "core/types/registry.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdio>

#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

struct Staged {
  Provided what;
  const void* descriptor;
};

/// What registrar calls write into during one registration.
struct Staging {
  std::vector<Staged> entries;
  std::vector<std::string> defects;

  void defect(const std::string& name, const std::string& text) {
    defects.push_back((name.empty() ? std::string("a type without a name") : name) + ": " + text);
  }
};

bool isLegalName(const char* name) {
  if (name == nullptr || *name == '\0') return false;
  std::size_t length = 0;
  for (const char* c = name; *c != '\0'; ++c, ++length) {
    if (static_cast<unsigned char>(*c) <= ' ' || *c == 0x7f || *c == '#') return false;
  }
  return length < 128;
}

constexpr int kMaximumDim = 1 << 16;

bool isDim(int dim) { return dim > 0 && dim <= kMaximumDim; }
bool isDimOrDynamic(int dim) { return isDim(dim) || dim == GRAFT_DYNAMIC; }

/// `smallest`: the type's size in the oldest minor version that is taken.
template <class Type>
bool checkHeader(Staging& staging, const Type* type, const char* name,
                 std::size_t smallest = sizeof(Type)) {
  if (!isLegalName(name)) {
    staging.defect("", "the name is empty, too long, or has blanks or control bytes");
    return false;
  }
  if (type->struct_size < smallest || type->struct_size > sizeof(Type)) {
    staging.defect(name, "struct_size is " + std::to_string(type->struct_size) + ", expected " +
                             std::to_string(sizeof(Type)));
    return false;
  }
  if (type->doc == nullptr || *type->doc == '\0') staging.defect(name, "doc is empty");
  return true;
}

void stageVertex(void* host, const graft_vertex_type* type) {
  auto& staging = *static_cast<Staging*>(host);
  if (!checkHeader(staging, type, type->tag)) return;
  if (!isDim(type->ambient_dim)) staging.defect(type->tag, "ambient_dim must be positive");
  if (!isDim(type->tangent_dim)) staging.defect(type->tag, "tangent_dim must be positive");
  if (!type->identity || !type->normalize || !type->plus || !type->minus) {
    staging.defect(type->tag, "a callback is null");
  }
  if (const graft_vertex_relaxation* relaxation = type->relaxation) {
    bool good = relaxation->struct_size == sizeof *relaxation && relaxation->relax != nullptr &&
                relaxation->restore != nullptr;
    for (int stage = 0; stage < GRAFT_RELAXATION_STAGES; ++stage) {
      good = good && relaxation->rows[stage] >= 0 && relaxation->rows[stage] <= 64 &&
             relaxation->columns[stage] >= 0 && relaxation->columns[stage] <= 64 &&
             (relaxation->rows[stage] > 0) == (relaxation->columns[stage] > 0);
    }
    if (!good) staging.defect(type->tag, "the relaxation is not complete");
  }
  staging.entries.push_back({{Kind::kVertex, type->tag}, type});
}

void stageEdge(void* host, const graft_edge_type* type) {
  auto& staging = *static_cast<Staging*>(host);
  if (!checkHeader(staging, type, type->tag)) return;
  const auto require = [&](bool ok, const char* text) {
    if (!ok) staging.defect(type->tag, text);
  };
  const bool dynamic = type->arity == GRAFT_DYNAMIC;
  require(dynamic || (type->arity > 0 && type->arity <= 4096), "arity must be positive or dynamic");
  require(isDimOrDynamic(type->error_dim), "error_dim must be positive or dynamic");
  require(type->measurement_dim >= GRAFT_DYNAMIC && type->measurement_dim <= kMaximumDim,
          "measurement_dim must not be negative");
  require(type->association_dim >= 0 && type->association_dim <= kMaximumDim,
          "association_dim must not be negative");
  require((type->association_dim > 0) == (type->associate != nullptr),
          "association_dim and associate() go together");
  require((type->flags & GRAFT_EDGE_HAS_ALTERNATIVES) == 0 || type->associate != nullptr,
          "only types with associate() have alternatives");
  require(dynamic == (type->shape != nullptr), "shape() goes with dynamic arity");
  require(dynamic || (type->error_dim > 0 && type->measurement_dim >= 0),
          "only types of dynamic arity have dynamic dimensions");
  require(type->slot_types != nullptr && type->slot_types[0] != nullptr, "slot_types is null");
  require(dynamic ? type->dynamic_slots > 0 && type->dynamic_slots <= 64 : type->dynamic_slots == 0,
          "dynamic_slots must be positive for dynamic arity, else 0");
  if (const graft_edge_relaxation* relaxation = type->relaxation) {
    require(!dynamic, "only types of fixed arity have a relaxation");
    require(relaxation->struct_size == sizeof *relaxation && relaxation->equations != nullptr,
            "the relaxation is not complete");
  }
  require(type->resource_count >= 0 && type->resource_count <= 64,
          "resource_count must be 0 to 64");
  require(type->resource_count == 0 || type->resource_types != nullptr, "resource_types is null");
  require(type->evaluate != nullptr && type->normalize != nullptr, "a callback is null");
  staging.entries.push_back({{Kind::kEdge, type->tag}, type});
}

void stageResource(void* host, const graft_resource_type* type) {
  auto& staging = *static_cast<Staging*>(host);
  if (!checkHeader(staging, type, type->tag)) return;
  if (!type->load || !type->destroy) staging.defect(type->tag, "a callback is null");
  staging.entries.push_back({{Kind::kResource, type->tag}, type});
}

void stageKernel(void* host, const graft_kernel_type* type) {
  auto& staging = *static_cast<Staging*>(host);
  if (!checkHeader(staging, type, type->name)) return;
  if (!type->evaluate) staging.defect(type->name, "a callback is null");
  staging.entries.push_back({{Kind::kKernel, type->name}, type});
}

void stageSolver(void* host, const graft_solver_type* type) {
  auto& staging = *static_cast<Staging*>(host);
  constexpr std::size_t kFirst = offsetof(graft_solver_type, factor_bytes);
  if (!checkHeader(staging, type, type->name, kFirst)) return;
  if (!type->create || !type->destroy || !type->analyze || !type->factorize || !type->solve) {
    staging.defect(type->name, "a callback is null");
  }
  staging.entries.push_back({{Kind::kSolver, type->name}, type});
}

void stageLoader(void* host, const graft_loader_type* type) {
  auto& staging = *static_cast<Staging*>(host);
  if (!checkHeader(staging, type, type->name)) return;
  if (!type->recognizes || !type->load) staging.defect(type->name, "a callback is null");
  staging.entries.push_back({{Kind::kLoader, type->name}, type});
}

void stageGuess(void* host, const graft_guess_type* type) {
  auto& staging = *static_cast<Staging*>(host);
  if (!checkHeader(staging, type, type->name)) return;
  if (!type->guess) staging.defect(type->name, "a callback is null");
  for (const char* reserved : {"auto", "file", "spanning-tree", "chordal"}) {
    if (std::string(type->name) == reserved) staging.defect(type->name, "the name is built in");
  }
  staging.entries.push_back({{Kind::kGuess, type->name}, type});
}

}  // namespace

const char* kindName(Kind kind) {
  switch (kind) {
    case Kind::kVertex:
      return "vertex type";
    case Kind::kEdge:
      return "edge type";
    case Kind::kResource:
      return "resource type";
    case Kind::kKernel:
      return "robust kernel";
    case Kind::kSolver:
      return "linear solver";
    case Kind::kLoader:
      return "file loader";
    case Kind::kGuess:
      return "initial guess";
  }
  return "type";
}

const PluginRecord& Registry::registerPlugin(const std::string& name, const std::string& file,
                                             const std::string& version, const std::string& license,
                                             graft_register_function entry) {
  const auto fail = [&](const std::string& text) -> void {
    throw Error(ExitCode::kPlugin, {file, 0, 0}, text);
  };
  Staging staging;
  graft_registrar registrar = {};
  registrar.struct_size = sizeof registrar;
  registrar.host = &staging;
  registrar.add_vertex_type = &stageVertex;
  registrar.add_edge_type = &stageEdge;
  registrar.add_resource_type = &stageResource;
  registrar.add_kernel_type = &stageKernel;
  registrar.add_solver_type = &stageSolver;
  registrar.add_loader_type = &stageLoader;
  registrar.add_guess_type = &stageGuess;
  graft_message message = {};
  if (entry(&registrar, &message) != GRAFT_OK) {
    fail("the plugin's registration failed: " + std::string(message.text));
  }
  if (!staging.defects.empty()) fail("invalid type: " + staging.defects.front());
  std::map<Provided, Entry> merged = entries_;
  PluginRecord record{name, file, version, license, {}};
  for (const Staged& staged : staging.entries) {
    const auto [position, added] =
        merged.insert({staged.what, Entry{staged.descriptor, plugins_.size()}});
    if (!added) {
      const std::size_t owner = position->second.plugin;
      fail(std::string(kindName(staged.what.kind)) + " " + staged.what.name +
           " is provided already by " +
           (owner < plugins_.size() ? plugins_[owner].file : std::string("the same plugin")));
    }
    record.provides.push_back(staged.what);
  }
  std::sort(record.provides.begin(), record.provides.end());
  entries_ = std::move(merged);
  plugins_.push_back(std::move(record));
  return plugins_.back();
}

const void* Registry::find(Kind kind, const std::string& name) {
  const Provided wanted{kind, name};
  auto position = entries_.find(wanted);
  if (position == entries_.end() && resolver_ && resolver_(wanted)) {
    position = entries_.find(wanted);
  }
  return position == entries_.end() ? nullptr : position->second.descriptor;
}

const graft_vertex_type* Registry::vertex(const std::string& tag) {
  return static_cast<const graft_vertex_type*>(find(Kind::kVertex, tag));
}
const graft_edge_type* Registry::edge(const std::string& tag) {
  return static_cast<const graft_edge_type*>(find(Kind::kEdge, tag));
}
const graft_resource_type* Registry::resource(const std::string& tag) {
  return static_cast<const graft_resource_type*>(find(Kind::kResource, tag));
}
const graft_kernel_type* Registry::kernel(const std::string& name) {
  return static_cast<const graft_kernel_type*>(find(Kind::kKernel, name));
}
const graft_solver_type* Registry::solver(const std::string& name) {
  return static_cast<const graft_solver_type*>(find(Kind::kSolver, name));
}
const graft_loader_type* Registry::loader(const std::string& name) {
  return static_cast<const graft_loader_type*>(find(Kind::kLoader, name));
}
const graft_guess_type* Registry::guess(const std::string& name) {
  return static_cast<const graft_guess_type*>(find(Kind::kGuess, name));
}

std::vector<Provided> Registry::provided() const {
  std::vector<Provided> all;
  all.reserve(entries_.size());
  for (const auto& entry : entries_) all.push_back(entry.first);
  return all;
}

const PluginRecord* Registry::providerOf(const Provided& wanted) const {
  const auto position = entries_.find(wanted);
  return position == entries_.end() ? nullptr : &plugins_[position->second.plugin];
}

std::string Registry::advice(const Provided& wanted) const {
  std::string text = advisor_ ? advisor_(wanted) : std::string();
  std::string nearest;
  std::size_t distance = wanted.name.size() / 3 + 1;
  for (const auto& entry : entries_) {
    if (entry.first.kind != wanted.kind) continue;
    const std::size_t d = editDistance(entry.first.name, wanted.name);
    if (d < distance) {
      distance = d;
      nearest = entry.first.name;
    }
  }
  if (!nearest.empty()) text += " (did you mean " + nearest + "?)";
  return text;
}

bool edgeShape(const graft_edge_type& type, int arity, int& error_dim, int& measurement_dim,
               graft_message& message) {
  const auto fail = [&message](const std::string& text) {
    std::snprintf(message.text, sizeof message.text, "%s", text.c_str());
    return false;
  };
  if (arity <= 0) return fail("needs vertices");
  error_dim = type.error_dim;
  measurement_dim = type.measurement_dim;
  if (type.arity != GRAFT_DYNAMIC) return true;
  std::int32_t errors = 0;
  std::int32_t measurements = 0;
  const auto shape = [&] { return type.shape(arity, &errors, &measurements, &message); };
  if (callPlugin(Callback::kShape, type.tag, message, shape) != GRAFT_OK) return false;
  if (!isDim(errors) || measurements < 0 || measurements > kMaximumDim) {
    return fail("its shape() says " + std::to_string(errors) + " errors, " +
                std::to_string(measurements) + " measured numbers" + ofPlugin(type.tag));
  }
  error_dim = errors;
  measurement_dim = measurements;
  return true;
}

std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

}  // namespace graft
