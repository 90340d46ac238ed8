// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/graph_builder.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/text.hpp"
#include "core/io/information_check.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

constexpr double kQuaternionWarning = 1e-2;
constexpr double kQuaternionError = 2.0;
// Unknown tags are remembered, too, but a hostile file has any number of them.
constexpr std::size_t kTagLimit = 4096;

std::string plural(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

}  // namespace

int quaternionField(const char* fields) {
  if (fields == nullptr) return -1;
  LineTokens tokens(fields);
  int index = 0;
  for (std::string_view name = tokens.next(); !name.empty(); name = tokens.next(), ++index) {
    if (name == "qx") return index;
  }
  return -1;
}

GraphBuilder::GraphBuilder(std::string path, Registry& registry, const LoadOptions& options,
                           Diagnostics& diagnostics)
    : path_(path == "-" ? "<stdin>" : std::move(path)),
      registry_(registry),
      options_(options),
      diagnostics_(diagnostics) {}

void GraphBuilder::error(std::int64_t line, std::int64_t column, const std::string& text) {
  diagnostics_.error({path_, line, column}, text);
}

void GraphBuilder::warning(std::int64_t line, const std::string& text) {
  diagnostics_.warning({path_, line, 0}, text);
}

std::int64_t GraphBuilder::column(std::int64_t line, int token) const {
  // Finding a column costs a pass over the text; only shown messages pay it.
  const bool shown = diagnostics_.errorCount() < Diagnostics::kShown;
  return columns_ && shown ? columns_(line, token) : 0;
}

const TagType& GraphBuilder::tag(std::string_view name) {
  if (last_tag_ != nullptr && name == last_name_) return *last_tag_;
  std::string key(name);
  auto position = tags_.find(key);
  if (position == tags_.end()) {
    TagType type;
    type.vertex = registry_.vertex(key);
    if (type.vertex == nullptr) type.edge = registry_.edge(key);
    if (type.vertex == nullptr && type.edge == nullptr) type.resource = registry_.resource(key);
    if (!type.known() && tags_.size() >= kTagLimit) return unknown_;
    if (type.vertex != nullptr) type.quaternion = quaternionField(type.vertex->fields);
    if (type.edge != nullptr) type.quaternion = quaternionField(type.edge->fields);
    position = tags_.emplace(key, type).first;
  }
  last_name_ = std::move(key);
  last_tag_ = &position->second;
  return *last_tag_;
}

void GraphBuilder::unknownTag(std::string_view name, std::int64_t line) {
  const bool shown = diagnostics_.errorCount() < Diagnostics::kShown &&
                     loaded_.counts.skipped_lines < Diagnostics::kShown;
  std::string advice;
  if (shown && name.size() < 256) {
    const std::string tag(name);
    for (const Kind kind : {Kind::kVertex, Kind::kEdge, Kind::kResource}) {
      if (advice.empty()) advice = registry_.advice({kind, tag});
    }
  }
  const std::string text = "unknown tag " + quoted(name) + ", no known plugin provides it" + advice;
  if (options_.lenient) {
    ++loaded_.counts.skipped_lines;
    warning(line, text + "; line skipped");
  } else {
    error(line, column(line, 0), text);
    definitionLost();
  }
}

bool GraphBuilder::checkQuaternion(const TagType& type, const double* numbers, std::int64_t line) {
  if (type.quaternion < 0) return true;
  const double* q = numbers + type.quaternion;
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  // Zero is rejected with its own text by the type.
  if (length == 0 || std::abs(length - 1.0) <= kQuaternionWarning) return true;
  const std::string text = "the quaternion has length " + formatDouble(length);
  if (length > kQuaternionError || length < 1.0 / kQuaternionError) {
    error(line, 0, text + ", expected 1");
    return false;
  }
  warning(line, text + ", expected 1; normalised");
  return true;
}

void GraphBuilder::addVertex(const TagType& type, std::int64_t id, const double* estimate,
                             int count, std::int64_t line) {
  ++vertex_lines_;
  if (count != type.vertex->ambient_dim) {
    error(line, 0,
          std::string(type.vertex->tag) + ": expected " + std::to_string(type.vertex->ambient_dim) +
              " numbers, got " + std::to_string(count));
    definitionLost();
    return;
  }
  if (!checkQuaternion(type, estimate, line)) return definitionLost();
  try {
    loaded_.graph.addVertex(*type.vertex, id, estimate, loaded_.values, line);
  } catch (const Error& e) {
    definitionLost();
    error(line, column(line, 1), e.what());
  }
}

void GraphBuilder::addResource(const TagType& type, std::int64_t id,
                               std::vector<std::string> tokens, std::int64_t line) {
  resources_.push_back({&type, id, std::move(tokens), line});
}

void GraphBuilder::addEdge(const TagType& type, const EdgeNumbers& n, std::int64_t line) {
  edges_.push_back({&type, line, ids_.size(), numbers_.size(), n.arity, n.resource_count,
                    n.measurement_count, n.information_count, -1, -1});
  ids_.insert(ids_.end(), n.vertices, n.vertices + n.arity);
  ids_.insert(ids_.end(), n.resources, n.resources + n.resource_count);
  numbers_.insert(numbers_.end(), n.measurement, n.measurement + n.measurement_count);
  numbers_.insert(numbers_.end(), n.information, n.information + n.information_count);
}

std::string GraphBuilder::nameOf(const PendingEdge& edge) {
  return edge.line > 0 ? "the edge of line " + std::to_string(edge.line)
                       : std::string("the last ") + edge.type->edge->tag;
}

void GraphBuilder::setKernel(std::string_view name, double width, std::int64_t line,
                             std::int64_t column) {
  if (!(width > 0) || !std::isfinite(width)) {
    return error(line, 0,
                 "the width of a robust kernel must be positive, got " + formatDouble(width));
  }
  const std::string key(name);
  const graft_kernel_type* kernel = registry_.kernel(key);
  if (kernel == nullptr) {
    return error(line, column,
                 "unknown robust kernel " + quoted(name) + registry_.advice({Kind::kKernel, key}));
  }
  PendingEdge& edge = edges_.back();
  if (edge.kernel >= 0) {
    return error(line, 0, nameOf(edge) + " has a robust kernel already");
  }
  edge.kernel = loaded_.graph.addKernel({kernel, width});
}

void GraphBuilder::setLevel(std::int32_t level, std::int64_t line) {
  PendingEdge& edge = edges_.back();
  if (level < 0) {
    return error(line, 0,
                 "expected a level from 0 to 2147483647, got '" + std::to_string(level) + "'");
  }
  if (edge.level >= 0) return error(line, 0, nameOf(edge) + " has a level already");
  edge.level = level;
}

void GraphBuilder::resolveResources() {
  const std::string directory = directoryOf(path_);
  for (PendingResource& pending : resources_) {
    const graft_resource_type& type = *pending.type->resource;
    const std::string name = std::string(type.tag) + ' ' + std::to_string(pending.id);
    if (pending.id < 0) {
      definitionLost();
      error(pending.line, column(pending.line, 1), name + ": the id is negative");
      continue;
    }
    if (loaded_.graph.findResource(pending.id) >= 0) {
      definitionLost();
      error(pending.line, column(pending.line, 1),
            "resource " + std::to_string(pending.id) + " is already defined");
      continue;
    }
    graft_message message = {};
    const std::string place = path_ + ":" + std::to_string(pending.line);
    const WorkSubject subject(pending.line > 0 ? place.c_str() : path_.c_str());
    std::shared_ptr<const void> data = loadResource(type, directory, pending.tokens, message);
    if (data == nullptr) {
      definitionLost();
      error(pending.line, 0, name + ": " + message.text);
      continue;
    }
    loaded_.graph.addResource(type, pending.id, std::move(pending.tokens), std::move(data));
    ++loaded_.counts.resources;
  }
}

void GraphBuilder::makeVertices() {
  for (const PendingEdge& edge : edges_) {
    const graft_edge_type& type = *edge.type->edge;
    for (int k = 0; k < edge.arity; ++k) {
      const std::int64_t id = ids_[edge.ids + std::size_t(k)];
      if (loaded_.graph.find(id).type >= 0) continue;
      const std::string slot = slotType(type, k);
      const TagType& vertex = tag(slot);
      if (vertex.vertex == nullptr) {
        error(edge.line, 0,
              std::string(type.tag) + " needs vertices " + slot +
                  ", which no known plugin provides" + registry_.advice({Kind::kVertex, slot}));
        return;
      }
      loaded_.graph.addVertex(*vertex.vertex, id, nullptr, loaded_.values, edge.line);
      ++loaded_.counts.made_vertices;
    }
  }
  loaded_.vertices_made = loaded_.counts.made_vertices > 0;
  if (loaded_.vertices_made) {
    diagnostics_.note({path_, 0, 0},
                      "no vertex lines; " +
                          plural(loaded_.counts.made_vertices, "vertex", "vertices") +
                          " made along the edges");
  }
}

bool GraphBuilder::checkInformation(const PendingEdge& edge, int error_dim, double* upper) {
  const auto count = std::size_t(triangleSize(error_dim));
  if (good_information_.size() == count &&
      std::memcmp(good_information_.data(), upper, count * sizeof(double)) == 0) {
    return true;
  }
  const auto name = [&] {
    std::string text = edge.type->edge->tag;
    for (int k = 0; k < edge.arity && k < 8; ++k) {
      text += ' ' + std::to_string(ids_[edge.ids + std::size_t(k)]);
    }
    return text + (edge.arity > 8 ? " ..." : "");
  };
  double smallest = 0;
  switch (judgeInformation(upper, error_dim, smallest)) {
    case InformationKind::kZero:
      ++loaded_.counts.zero_information;
      warning(edge.line, name() + " has an information matrix of zeros and thus no effect");
      return true;
    case InformationKind::kSemidefinite:
      good_information_.assign(upper, upper + count);
      return true;
    case InformationKind::kIndefinite:
      break;
  }
  const std::string text = name() +
                           ": the information matrix is not positive semidefinite, its smallest "
                           "eigenvalue is " +
                           formatDouble(smallest);
  if (!options_.project_information) {
    error(edge.line, 0, text);
    return false;
  }
  projectInformation(upper, error_dim);
  ++loaded_.counts.projected;
  warning(edge.line, text + "; projected");
  return true;
}

void GraphBuilder::resolveEdge(const PendingEdge& edge) {
  const graft_edge_type& type = *edge.type->edge;
  Graph::EdgeSpec spec;
  spec.type = &type;
  spec.line = edge.line;
  spec.kernel = edge.kernel;
  spec.level = std::max(edge.level, 0);
  const std::int64_t* ids = ids_.data() + edge.ids;
  spec.vertices.reserve(std::size_t(edge.arity));
  for (int k = 0; k < edge.arity; ++k) {
    const VertexRef v = loaded_.graph.find(ids[k]);
    if (v.type < 0) {
      error(edge.line, column(edge.line, 1 + k),
            "vertex " + std::to_string(ids[k]) + " is not defined (needed by " + type.tag +
                " slot " + std::to_string(k + 1) + ")");
      return;
    }
    spec.vertices.push_back(v);
  }
  for (int k = 0; k < edge.resource_count; ++k) {
    const std::int64_t id = ids[edge.arity + k];
    const std::int32_t index = loaded_.graph.findResource(id);
    if (index < 0) {
      const int separator = type.arity == GRAFT_DYNAMIC ? 1 : 0;
      error(edge.line, column(edge.line, 1 + edge.arity + separator + k),
            "resource " + std::to_string(id) + " is not defined (needed by " + type.tag + ")");
      return;
    }
    spec.resources.push_back(index);
  }
  const double* numbers = numbers_.data() + edge.numbers;
  spec.measurement.assign(numbers, numbers + edge.measurement_count);
  numbers += edge.measurement_count;
  spec.information.assign(numbers, numbers + edge.information_count);
  if (edge.type->quaternion >= 0 && edge.measurement_count >= edge.type->quaternion + 4 &&
      !checkQuaternion(*edge.type, spec.measurement.data(), edge.line)) {
    return;
  }
  int dim = type.error_dim;
  if (dim == GRAFT_DYNAMIC) {
    // Found again from the number of entries; addEdge checks it against shape().
    dim = int(std::lround((std::sqrt(8.0 * edge.information_count + 1.0) - 1.0) / 2.0));
  }
  if (triangleSize(dim) == edge.information_count && dim > 0 &&
      !checkInformation(edge, dim, spec.information.data())) {
    return;
  }
  try {
    loaded_.graph.addEdge(std::move(spec));
  } catch (const Error& e) {
    error(edge.line, 0, e.what());
  }
}

void GraphBuilder::resolveFixed() {
  for (const PendingFix& pending : fixed_) {
    const VertexRef v = loaded_.graph.find(pending.id);
    if (v.type < 0) {
      error(pending.line, 0, "vertex " + std::to_string(pending.id) + " is not defined (FIX)");
      continue;
    }
    if (!loaded_.graph.isFixed(v)) ++loaded_.counts.fixed;
    loaded_.graph.setFixed(v, true);
  }
}

void GraphBuilder::findIsolated() {
  std::vector<std::vector<char>> used;
  for (const VertexBlock& block : loaded_.graph.vertexBlocks()) {
    used.emplace_back(block.ids.size(), char{0});
  }
  for (const EdgeBlock& block : loaded_.graph.edgeBlocks()) {
    for (const VertexRef v : block.vertices) used[std::size_t(v.type)][std::size_t(v.index)] = 1;
  }
  std::int64_t first = -1;
  for (std::size_t t = 0; t < used.size(); ++t) {
    for (std::size_t i = 0; i < used[t].size(); ++i) {
      if (used[t][i] != 0) continue;
      ++loaded_.counts.isolated;
      const std::int64_t id = loaded_.graph.vertexBlocks()[t].ids[i];
      first = first < 0 ? id : std::min(first, id);
    }
  }
  if (loaded_.counts.isolated == 0) return;
  const bool one = loaded_.counts.isolated == 1;
  diagnostics_.warning(
      {path_, 0, 0}, one ? "vertex " + std::to_string(first) + " has no edge and keeps its estimate"
                         : plural(loaded_.counts.isolated, "vertex has", "vertices have") +
                               " no edge and keep their estimates, the first is " +
                               std::to_string(first));
}

LoadedGraph GraphBuilder::finish() {
  if (diagnostics_.errorCount() == 0 && vertex_lines_ == 0 && edges_.empty()) {
    error(1, 0, "no vertices");
  }
  resolveResources();
  if (definitions_good_ && vertex_lines_ == 0) makeVertices();
  if (definitions_good_) {
    for (const PendingEdge& edge : edges_) resolveEdge(edge);
    resolveFixed();
  }
  if (diagnostics_.errorCount() == 0) findIsolated();
  loaded_.counts.vertices = loaded_.graph.vertexCount();
  loaded_.counts.edges = loaded_.graph.edgeCount();
  if (loaded_.counts.skipped_lines > 0) {
    diagnostics_.note({path_, 0, 0}, plural(loaded_.counts.skipped_lines, "line", "lines") +
                                         " with unknown tags skipped");
  }
  return std::move(loaded_);
}

}  // namespace graft
