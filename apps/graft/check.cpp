// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "apps/graft/commands.hpp"
#include "apps/graft/engine_options.hpp"
#include "core/base/disjoint_sets.hpp"
#include "core/base/text.hpp"
#include "core/geometry/so3.hpp"
#include "core/io/graph_builder.hpp"
#include "core/solve/inspection.hpp"
#include "core/solve/optimizer.hpp"

namespace graft {

namespace {

/// Mean rotation of measurements, degrees, that few robots turn.
constexpr double kOddRotation = 120;
constexpr double kDegrees = 57.29577951308232;

/// Connected components of a graph; vertices are numbered by rising id.
class Components {
 public:
  explicit Components(const Graph& graph)
      : graph_(graph), vertices_(graph.verticesById()), sets_(vertices_.size()) {
    for (const VertexBlock& block : graph.vertexBlocks()) numbers_.emplace_back(block.ids.size());
    for (std::size_t i = 0; i < vertices_.size(); ++i) number(vertices_[i]) = i;
    for (const EdgeBlock& block : graph.edgeBlocks()) {
      for (std::size_t e = 0; e < block.size(); ++e) {
        const auto begin = std::size_t(block.vertex_begin[e]);
        for (std::size_t k = begin + 1; k < std::size_t(block.vertex_begin[e + 1]); ++k) {
          sets_.merge(number(block.vertices[begin]), number(block.vertices[k]));
        }
      }
    }
    findAnchors();
  }

  /// Per component: id of its first vertex, size, whether something holds it.
  struct Component {
    std::int64_t first_id = 0;
    std::size_t size = 0;
    bool anchored = false;
  };
  std::vector<Component> list() {
    std::map<std::size_t, Component> by_root;
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      Component& component = by_root[sets_.find(i)];
      if (component.size++ == 0) component.first_id = graph_.id(vertices_[i]);
      component.anchored = component.anchored || anchors_.count(i) > 0;
    }
    std::vector<Component> components;
    components.reserve(by_root.size());
    for (const auto& entry : by_root) components.push_back(entry.second);
    return components;
  }

 private:
  std::size_t& number(VertexRef v) { return numbers_[std::size_t(v.type)][std::size_t(v.index)]; }
  void findAnchors() {
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (graph_.isFixed(vertices_[i])) anchors_.insert(i);
    }
    for (const EdgeBlock& block : graph_.edgeBlocks()) {
      if ((block.type->flags & GRAFT_EDGE_RELATIVE) != 0) continue;
      for (std::size_t e = 0; e < block.size(); ++e) {
        if (block.arity(e) == 1) {
          anchors_.insert(number(block.vertices[std::size_t(block.vertex_begin[e])]));
        }
      }
    }
  }

  const Graph& graph_;
  std::vector<VertexRef> vertices_;
  std::vector<std::vector<std::size_t>> numbers_;
  DisjointSets sets_;
  std::set<std::size_t> anchors_;
};

std::size_t countRepeatedEdges(const Graph& graph) {
  std::size_t repeated = 0;
  for (const EdgeBlock& block : graph.edgeBlocks()) {
    std::set<std::vector<std::int64_t>> seen;
    for (std::size_t e = 0; e < block.size(); ++e) {
      std::vector<std::int64_t> ids;
      for (auto k = std::size_t(block.vertex_begin[e]); k < std::size_t(block.vertex_begin[e + 1]);
           ++k) {
        ids.push_back(graph.id(block.vertices[k]));
      }
      if (!seen.insert(std::move(ids)).second) ++repeated;
    }
  }
  return repeated;
}

/// Prints up to Diagnostics::kShown lines of a list, and how many more there are.
template <class List, class Line>
void printSome(const List& list, const Line& line) {
  for (std::size_t i = 0; i < list.size() && i < Diagnostics::kShown; ++i) line(list[i]);
  if (list.size() > Diagnostics::kShown) {
    std::printf("  ... and %zu more\n", list.size() - Diagnostics::kShown);
  }
}

void printWeights(const Problem& problem) {
  const std::vector<OddWeight> odd = findOddWeights(problem);
  std::printf("%8zu edges whose weight is off the median of their tag by more than %g times\n",
              odd.size(), kOddWeight);
  printSome(odd, [](const OddWeight& one) {
    std::printf("  %s: %.3g times the median\n", one.edge.c_str(), one.ratio);
  });
}

void printJacobians(const Problem& problem, const Values& values) {
  for (const JacobianCheck& check : checkJacobians(problem, values)) {
    std::printf("%8lld Jacobians of %s agree with differences to %.2g (worst: %s)%s\n",
                static_cast<long long>(check.edges - check.suspicious), check.tag.c_str(),
                check.worst, check.worst_edge.c_str(),
                check.suspicious > 0 ? "; the others DO NOT" : "");
  }
}

void printFreeDirections(const Problem& problem, const Values& values) {
  const std::vector<FreeDirection> free = findFreeDirections(problem, values);
  std::printf("%8zu directions that no edge determines\n", free.size());
  printSome(free, [&](const FreeDirection& one) {
    std::printf("  %s\n", describe(problem, one).c_str());
  });
}

/// How far measured rotations turn on average: a file that gives qw first, which no reader can
/// tell, has half turns where small ones are meant.
void printRotations(const Graph& graph) {
  for (const EdgeBlock& block : graph.edgeBlocks()) {
    const int first = quaternionField(block.type->fields);
    if (first < 0 || block.size() == 0) continue;
    double sum = 0;
    for (std::size_t e = 0; e < block.size(); ++e) {
      const double* q = &block.measurements[std::size_t(block.measurement_begin[e]) + first];
      sum += rotationAngle(Eigen::Quaterniond(q[3], q[0], q[1], q[2]));
    }
    const double degrees = kDegrees * sum / double(block.size());
    std::printf(
        "%8.3g degrees is the mean rotation of %s%s\n", degrees, block.type->tag,
        degrees > kOddRotation ? " (does the file give qw first? expected qx qy qz qw)" : "");
  }
}

/// What needs estimates and derivatives.
void printAtEstimates(const LoadedGraph& loaded) {
  const Problem problem(loaded.graph, InformationPolicy::kProject);
  printWeights(problem);
  if (loaded.vertices_made) {
    std::printf("no estimates in the file: Jacobians and free directions are not checked\n");
    return;
  }
  std::map<std::string, double> by_tag;
  std::printf("chi2 at the estimates of the file: %.10g\n",
              evaluateChi2(loaded.graph, loaded.values, &by_tag));
  for (const auto& [tag, chi2] : by_tag) std::printf("  %.10g  %s\n", chi2, tag.c_str());
  printJacobians(problem, loaded.values);
  printFreeDirections(problem, loaded.values);
}

struct CheckOptions {
  EngineOptions engine;
  std::string input;
};

ExitCode run(const CheckOptions& options) {
  const auto engine = makeEngine(options.engine);
  const LoadedGraph loaded = loadAndReport(options.input, *engine, options.engine);
  const Graph& graph = loaded.graph;
  for (const VertexBlock& block : graph.vertexBlocks()) {
    std::printf("%8zu %s\n", block.ids.size(), block.type->tag);
  }
  for (const EdgeBlock& block : graph.edgeBlocks()) {
    std::printf("%8zu %s\n", block.size(), block.type->tag);
  }
  std::printf("%8zu resources\n%8zu fixed vertices\n", loaded.counts.resources,
              loaded.counts.fixed);
  std::printf("%8zu edges without weight\n%8zu vertices without edges\n",
              loaded.counts.zero_information, loaded.counts.isolated);
  std::printf("%8zu edges between the same vertices as an earlier one\n",
              countRepeatedEdges(graph));
  const std::vector<Components::Component> components = Components(graph).list();
  std::printf("%8zu connected components\n", components.size());
  std::size_t loose = 0;
  for (const Components::Component& component : components) {
    if (component.anchored || component.size == 1) continue;
    if (++loose > Diagnostics::kShown) continue;
    std::printf("component of vertex %lld (%zu vertices) is not anchored: graft holds one vertex\n",
                static_cast<long long>(component.first_id), component.size);
  }
  if (loose > Diagnostics::kShown) {
    std::printf("... and %zu more that are not anchored\n", loose - Diagnostics::kShown);
  }
  printRotations(graph);
  printAtEstimates(loaded);
  return ExitCode::kSuccess;
}

}  // namespace

void addCheck(Program& program) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = program.add("check", "Look for defects in a graph without solving it",
                                  [options] { return run(*options); });
  command->add_option("IN", options->input, "Graph file, - = stdin")->required();
  options->engine.addPluginOption(*command);
  options->engine.addLoadOptions(*command);
}

}  // namespace graft
