// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "apps/graft/commands.hpp"
#include "apps/graft/engine_options.hpp"

namespace graft {

namespace {

std::string fieldsOf(const char* fields) {
  return fields == nullptr || *fields == '\0' ? "" : std::string(" ") + fields;
}

std::string dimension(int dim) { return dim == GRAFT_DYNAMIC ? "dynamic" : std::to_string(dim); }

void showVertex(const graft_vertex_type& type) {
  std::printf("vertex %s: %s\n", type.tag, type.doc);
  std::printf("  numbers %d, degrees of freedom %d\n", type.ambient_dim, type.tangent_dim);
  std::printf("  line    %s id%s\n", type.tag, fieldsOf(type.fields).c_str());
}

void showEdge(const graft_edge_type& type) {
  std::printf("edge %s: %s\n", type.tag, type.doc);
  std::printf("  vertices %s, error %s, measurement %s\n", dimension(type.arity).c_str(),
              dimension(type.error_dim).c_str(), dimension(type.measurement_dim).c_str());
  std::string line = type.tag;
  if (type.arity == GRAFT_DYNAMIC) {
    line += std::string(" id... || ");
    std::printf("  slots   ");
    for (int k = 0; k + 1 < type.dynamic_slots; ++k) std::printf(" %s", type.slot_types[k]);
    std::printf(" any number of %s\n", type.slot_types[type.dynamic_slots - 1]);
  } else {
    std::printf("  slots   ");
    for (int k = 0; k < type.arity; ++k) {
      std::printf(" %s", type.slot_types[k]);
      line += " id" + std::to_string(k + 1);
    }
    std::printf("\n");
  }
  for (int k = 0; k < type.resource_count; ++k) {
    line += " resource" + std::to_string(k + 1);
    std::printf("  resource %s\n", type.resource_types[k]);
  }
  line += type.measurement_dim == GRAFT_DYNAMIC ? "measurement" : fieldsOf(type.fields);
  const std::string entries = type.error_dim == GRAFT_DYNAMIC
                                  ? ""
                                  : std::to_string(triangleSize(type.error_dim)) + " numbers, ";
  std::printf("  line     %s information (%supper triangle, row by row)\n", line.c_str(),
              entries.c_str());
  std::printf("  %s\n", (type.flags & GRAFT_EDGE_RELATIVE) != 0
                            ? "relative: does not hold its vertices in the world"
                            : "absolute: holds its vertices in the world");
}

bool show(Registry& registry, const Provided& one) {
  switch (one.kind) {
    case Kind::kVertex:
      if (const graft_vertex_type* type = registry.vertex(one.name)) return showVertex(*type), true;
      return false;
    case Kind::kEdge:
      if (const graft_edge_type* type = registry.edge(one.name)) return showEdge(*type), true;
      return false;
    case Kind::kResource:
      if (const graft_resource_type* type = registry.resource(one.name)) {
        std::printf("resource %s: %s\n  line    %s id%s\n", type->tag, type->doc, type->tag,
                    fieldsOf(type->fields).c_str());
        return true;
      }
      return false;
    case Kind::kKernel:
      if (const graft_kernel_type* type = registry.kernel(one.name)) {
        std::printf("kernel %s: %s\n", type->name, type->doc);
        return true;
      }
      return false;
    case Kind::kSolver:
      if (const graft_solver_type* type = registry.solver(one.name)) {
        std::printf("solver %s: %s, license %s\n", type->name, type->doc, type->license);
        return true;
      }
      return false;
    case Kind::kLoader:
      if (const graft_loader_type* type = registry.loader(one.name)) {
        std::printf("loader %s: %s (%s)\n", type->name, type->doc, type->extensions);
        return true;
      }
      return false;
    case Kind::kGuess:
      if (const graft_guess_type* type = registry.guess(one.name)) {
        std::printf("guess %s: %s\n", type->name, type->doc);
        return true;
      }
      return false;
  }
  return false;
}

ExitCode run(const EngineOptions& options, const std::string& tag) {
  const auto engine = makeEngine(options);
  Registry& registry = engine->registry();
  if (tag.empty()) {
    engine->plugins().loadAll();
    printMessages(engine->plugins().diagnostics());
    for (const Provided& one : registry.provided()) show(registry, one);
    return ExitCode::kSuccess;
  }
  bool found = false;
  std::string advice;
  for (const Kind kind : kAllKinds) {
    if (show(registry, {kind, tag})) {
      found = true;
    } else if (advice.empty()) {
      advice = registry.advice({kind, tag});
    }
  }
  if (!found) {
    throw Error(ExitCode::kUsage, "no known plugin provides " + graft::quoted(tag) + advice);
  }
  return ExitCode::kSuccess;
}

}  // namespace

void addTypes(Program& program) {
  auto options = std::make_shared<EngineOptions>();
  auto tag = std::make_shared<std::string>();
  CLI::App* command =
      program.add("types", "Describe types: dimensions, vertices, layout of a line in a file",
                  [options, tag] { return run(*options, *tag); });
  command->add_option("TAG", *tag, "Only this tag or name");
  options->addPluginOption(*command);
}

}  // namespace graft
