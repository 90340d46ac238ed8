// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/graph_loader.hpp"

#include <exception>
#include <filesystem>
#include <fstream>

#include "core/base/file.hpp"
#include "core/io/g2o_reader.hpp"
#include "core/io/graph_builder.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

/// The C face of a builder, as a loader plugin sees it. No exception leaves a
/// call; the first is kept and thrown after the loader has returned.
class Sink {
 public:
  explicit Sink(GraphBuilder& builder) : builder_(builder) {}

  graft_graph_sink table() {
    graft_graph_sink sink = {};
    sink.struct_size = sizeof sink;
    sink.host = this;
    sink.add_vertex = &addVertex;
    sink.add_resource = &addResource;
    sink.add_edge = &addEdge;
    sink.fix_vertex = &fixVertex;
    sink.report = &report;
    sink.set_kernel = &setKernel;
    sink.set_level = &setLevel;
    return sink;
  }
  void rethrow() const {
    if (caught_) std::rethrow_exception(caught_);
  }

 private:
  template <class Body>
  static int guard(void* host, Body&& body) {
    auto& self = *static_cast<Sink*>(host);
    PluginCall::signOfLife();
    if (self.caught_) return GRAFT_FAILED;
    try {
      body(self.builder_);
      return GRAFT_OK;
    } catch (...) {
      self.caught_ = std::current_exception();
    }
    return GRAFT_FAILED;
  }

  static int addVertex(void* host, const char* tag, std::int64_t id, const double* estimate,
                       std::int32_t count, std::int64_t line) {
    return guard(host, [&](GraphBuilder& builder) {
      const TagType& type = builder.tag(tag);
      if (type.vertex == nullptr) return builder.unknownTag(tag, line);
      builder.addVertex(type, id, estimate, count, line);
    });
  }
  static int addResource(void* host, const char* tag, std::int64_t id, std::int32_t count,
                         const char* const* tokens, std::int64_t line) {
    return guard(host, [&](GraphBuilder& builder) {
      const TagType& type = builder.tag(tag);
      if (type.resource == nullptr) return builder.unknownTag(tag, line);
      builder.addResource(type, id, std::vector<std::string>(tokens, tokens + count), line);
    });
  }
  static int addEdge(void* host, const char* tag, std::int32_t arity, const std::int64_t* vertices,
                     std::int32_t resource_count, const std::int64_t* resources,
                     std::int32_t measurement_count, const double* measurement,
                     std::int32_t information_count, const double* information, std::int64_t line) {
    return guard(host, [&](GraphBuilder& builder) {
      const TagType& type = builder.tag(tag);
      Before& before = static_cast<Sink*>(host)->before_;
      before = Before::kLostEdge;
      if (type.edge == nullptr) return builder.unknownTag(tag, line);
      before = Before::kEdge;
      builder.addEdge(type,
                      {vertices, arity, resources, resource_count, measurement, measurement_count,
                       information, information_count},
                      line);
    });
  }
  static int fixVertex(void* host, std::int64_t id, std::int64_t line) {
    return guard(host, [&](GraphBuilder& builder) { builder.fix(id, line); });
  }
  /// Whether there is an edge that a loader may say more of.
  static bool hasEdge(void* host, const char* what, std::int64_t line) {
    auto& self = *static_cast<Sink*>(host);
    if (self.before_ == Before::kEdge) return true;
    if (self.before_ == Before::kLostEdge) {
      self.builder_.warning(line, std::string(what) + " of an edge that was not read, skipped");
    } else {
      self.builder_.error(line, 0, std::string(what) + " without an edge before it");
    }
    return false;
  }
  static int setKernel(void* host, const char* name, double width, std::int64_t line) {
    return guard(host, [&](GraphBuilder& builder) {
      if (hasEdge(host, "a robust kernel", line)) {
        builder.setKernel(name != nullptr ? name : "", width, line, 0);
      }
    });
  }
  static int setLevel(void* host, std::int32_t level, std::int64_t line) {
    return guard(host, [&](GraphBuilder& builder) {
      if (hasEdge(host, "a level", line)) builder.setLevel(level, line);
    });
  }
  static void report(void* host, std::int32_t severity, const char* path, std::int64_t line,
                     std::int64_t column, const char* text) {
    guard(host, [&](GraphBuilder& builder) {
      const SourceLocation where{path != nullptr ? std::string(path) : builder.path(), line,
                                 column};
      if (severity >= 3) throw Error(ExitCode::kNoResult, where, text);
      if (severity == 2) {
        builder.diagnostics().error(where, text);
      } else if (severity == 1) {
        builder.diagnostics().warning(where, text);
      } else {
        builder.diagnostics().note(where, text);
      }
    });
  }

  GraphBuilder& builder_;
  std::exception_ptr caught_;
  enum class Before { kNoEdge, kEdge, kLostEdge };
  Before before_ = Before::kNoEdge;
};

bool hasExtension(const std::string& path, const char* extension) {
  return std::filesystem::path(path).extension() == extension;
}

/// The loader of a plugin that recognises the file; null if none does.
const graft_loader_type* findLoader(const std::string& path, Registry& registry) {
  if (path == "-" || hasExtension(path, ".g2o")) return nullptr;
  std::string head(4096, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), std::streamsize(head.size()));
  head.resize(std::size_t(std::max<std::streamsize>(file.gcount(), 0)));
  if (head.empty()) return nullptr;
  registry.loader(kEveryLoader);
  for (const Provided& one : registry.provided()) {
    if (one.kind != Kind::kLoader) continue;
    const graft_loader_type* loader = registry.loader(one.name);
    const int recognized = callPlugin(Callback::kLoadFile, loader->name, [&] {
      return loader->recognizes(path.c_str(), head.data(), std::int64_t(head.size()));
    });
    if (recognized == 1) return loader;
  }
  return nullptr;
}

}  // namespace

std::string directoryOf(const std::string& path) {
  if (path == "-" || path == "<stdin>") return ".";
  const std::filesystem::path parent = std::filesystem::path(path).parent_path();
  return parent.empty() ? std::string(".") : parent.string();
}

LoadedGraph loadGraph(const std::string& path, Registry& registry, const LoadOptions& options,
                      Diagnostics& diagnostics) {
  std::error_code not_there;
  const auto status = std::filesystem::status(path, not_there);
  // Reading from a pipe that nobody writes would wait for ever.
  if (path != "-" && std::filesystem::is_directory(status)) {
    throw Error(ExitCode::kInput, {path, 0, 0}, "is a directory, expected a file");
  }
  const WorkSubject subject(path.c_str());
  const graft_loader_type* loader =
      std::filesystem::is_regular_file(status) ? findLoader(path, registry) : nullptr;
  GraphBuilder builder(path, registry, options, diagnostics);
  std::string text;
  std::string format = "g2o";
  if (loader != nullptr) {
    format = loader->name;
    Sink sink(builder);
    const graft_graph_sink table = sink.table();
    const int result = callPlugin(Callback::kLoadFile, loader->name,
                                  [&] { return loader->load(path.c_str(), &table); });
    sink.rethrow();
    if (result != GRAFT_OK && diagnostics.errorCount() == 0) {
      diagnostics.error({path, 0, 0}, "the loader " + format + " failed without saying why");
    }
  } else {
    text = readFile(path);
    readG2o(text, builder);
  }
  LoadedGraph loaded = builder.finish();
  loaded.format = format;
  diagnostics.throwIfErrors();
  return loaded;
}

}  // namespace graft
