// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/inner_iterations.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/base/disjoint_sets.hpp"
#include "core/solve/step_strategy.hpp"

namespace graft {

namespace {

/// A part has converged when a step changes its chi2 by less, relative: the next step of
/// the whole moves what it stands on.
constexpr double kTolerance = 1e-4;
/// A step that changes it by less is not made: tiny ones, found by strong damping beside a
/// change of choice, hang on rounding, so that the same scene elsewhere would end elsewhere.
constexpr double kWorthwhile = 1e-5;

/// Full steps from the start run from one choice into the next, far and back: shorter ones
/// end sooner, and do not multiply rounding on their way.
constexpr double kDamping = 0.1;

/// Per vertex type, whether its vertices take part.
std::vector<char> typesThatTakePart(const Problem& problem) {
  const std::size_t count = problem.graph().vertexBlocks().size();
  std::vector<char> chosen(count, 0);
  std::vector<char> tied(count, 0);
  for (const EdgeGroup& group : problem.groups()) {
    const auto arity = std::size_t(group.arity);
    for (std::size_t first = 0; first < group.vertices.size(); first += arity) {
      const VertexRef* v = &group.vertices[first];
      if (std::all_of(v, v + arity, [v](VertexRef o) { return o.type == v->type; })) continue;
      for (std::size_t k = 0; k < arity; ++k) {
        (group.type->associate != nullptr ? chosen : tied)[std::size_t(v[k].type)] = 1;
      }
    }
  }
  std::vector<std::int64_t> dims(count, 0);
  for (const VertexRef v : problem.freeVertices()) {
    dims[std::size_t(v.type)] += problem.graph().type(v).tangent_dim;
  }
  const auto rest = std::max_element(dims.begin(), dims.end()) - dims.begin();
  for (std::size_t t = 0; t < count; ++t) {
    if (tied[t] != 0 || std::ptrdiff_t(t) == rest) chosen[t] = 0;
  }
  return chosen;
}

/// Which vertices take part, by components.
class Membership {
 public:
  explicit Membership(const Problem& problem)
      : problem_(problem),
        types_(typesThatTakePart(problem)),
        components_(problem.freeVertices().size()) {
    for (const EdgeGroup& group : problem.groups()) {
      for (std::int64_t e = 0; e < group.count; ++e) {
        const VertexRef* v = &group.vertices[std::size_t(e * group.arity)];
        const std::int32_t first = memberOf(v, group.arity);
        for (int k = 0; first >= 0 && k < group.arity; ++k) {
          if (has(v[k])) components_.merge(std::size_t(first), block(v[k]));
        }
      }
    }
  }

  bool has(VertexRef v) const {
    return types_[std::size_t(v.type)] != 0 && problem_.blockOf(v) >= 0;
  }
  /// Block of the first of an edge's vertices that takes part, -1 = none.
  std::int32_t memberOf(const VertexRef* vertices, int arity) const {
    const VertexRef* const end = vertices + arity;
    const VertexRef* found = std::find_if(vertices, end, [this](VertexRef v) { return has(v); });
    return found == end ? -1 : problem_.blockOf(*found);
  }
  std::size_t component(std::int32_t block) { return components_.find(std::size_t(block)); }

 private:
  std::size_t block(VertexRef v) const { return std::size_t(problem_.blockOf(v)); }

  const Problem& problem_;
  std::vector<char> types_;
  DisjointSets components_;
};

}  // namespace

/// A graph of its own: the vertices that take part are free, their neighbours fixed.
struct InnerIterations::Part {
  Graph graph;
  Values values;
  std::vector<std::pair<VertexRef, VertexRef>> vertices;  ///< in the whole, here
  ThreadPool pool{1};
  std::unique_ptr<LinearSolver> solver;
  PatternMemory memory;
  std::map<std::string, double> seconds;
  std::optional<Problem> problem;
  std::optional<Linearizer> linearizer;
  std::optional<SolveContext> context;

  VertexRef addVertex(const Graph& whole, VertexRef v, bool free) {
    const VertexRef known = graph.find(whole.id(v));
    if (known.type >= 0) return known;
    const VertexRef here = graph.addVertex(whole.type(v), whole.id(v), nullptr, values);
    graph.setFixed(here, !free);
    vertices.emplace_back(v, here);
    return here;
  }

  std::int32_t addResource(const Resource& resource) {
    const std::int32_t known = graph.findResource(resource.id);
    if (known >= 0) return known;
    return graph.addResource(*resource.type, resource.id, resource.tokens, resource.data);
  }

  void addEdge(const Graph& whole, const EdgeGroup& group, std::int64_t edge) {
    const EdgeBlock& block = whole.edgeBlocks()[group.block];
    const auto at = std::size_t(group.edges[std::size_t(edge)]);
    Graph::EdgeSpec spec;
    spec.type = group.type;
    for (int k = 0; k < group.arity; ++k) {
      const VertexRef v = group.vertices[std::size_t(edge * group.arity + k)];
      spec.vertices.push_back(addVertex(whole, v, false));
    }
    const auto resources = std::size_t(group.type->resource_count);
    for (std::size_t k = at * resources; k < (at + 1) * resources; ++k) {
      spec.resources.push_back(addResource(whole.resources()[std::size_t(block.resources[k])]));
    }
    spec.measurement.assign(block.measurements.begin() + block.measurement_begin[at],
                            block.measurements.begin() + block.measurement_begin[at + 1]);
    spec.information.assign(block.information.begin() + block.information_begin[at],
                            block.information.begin() + block.information_begin[at + 1]);
    const std::int32_t kernel = group.kernels[std::size_t(edge)];
    if (kernel >= 0) spec.kernel = graph.addKernel(whole.kernels()[std::size_t(kernel)]);
    graph.addEdge(std::move(spec));
  }

  void compile(Registry& registry, InformationPolicy policy, const std::atomic<int>* interrupt) {
    solver = LinearSolver::create("block", registry, pool);
    problem.emplace(graph, policy);
    linearizer.emplace(*problem, pool);
    linearizer->setInterrupt(interrupt);
    context.emplace(*problem, *solver, memory, pool, seconds);
    context->setInterrupt(interrupt);
  }

  void run(int iterations, Values& whole) {
    for (const auto& [there, here] : vertices) {
      std::copy_n(whole.at(there), whole.dim(there.type), values.at(here));
    }
    State state;
    Evaluation evaluation = linearizer->begin(values, state);
    if (evaluation.ok()) evaluation = linearizer->evaluate(state);
    if (!evaluation.ok()) return;
    context->start(std::move(state), evaluation.chi2);
    SolveOptions options;
    options.initial_damping = kDamping;
    const std::unique_ptr<StepStrategy> strategy = StepStrategy::create(options);
    for (int i = 0; i < iterations && context->linearize().ok(); ++i) {
      const State kept = context->state();
      const double before = context->chi2();
      if (strategy->iterate(*context).kind != StepResult::Kind::kAccepted) break;
      const double change = before - context->chi2();
      if (change <= kWorthwhile * before) context->restore(kept, before);
      if (change <= kTolerance * before) break;
    }
    for (const auto& [there, here] : vertices) {
      if (graph.isFixed(here)) continue;
      std::copy_n(context->state().values.at(here), whole.dim(there.type), whole.at(there));
    }
  }
};

InnerIterations::InnerIterations(const Problem& problem, Registry& registry,
                                 InformationPolicy policy, int iterations,
                                 const std::atomic<int>* interrupt)
    : iterations_(iterations) {
  const auto& groups = problem.groups();
  const bool chooses = std::any_of(groups.begin(), groups.end(),
                                   [](const EdgeGroup& g) { return g.type->associate != nullptr; });
  if (iterations <= 0 || !chooses) return;
  Membership membership(problem);
  const std::vector<VertexRef>& free = problem.freeVertices();
  std::vector<Part*> part_of(free.size(), nullptr);
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (!membership.has(free[i])) continue;
    Part*& part = part_of[membership.component(std::int32_t(i))];
    if (part == nullptr) {
      parts_.push_back(std::make_unique<Part>());
      part = parts_.back().get();
    }
    part->addVertex(problem.graph(), free[i], true);
  }
  for (const EdgeGroup& group : groups) {
    for (std::int64_t e = 0; e < group.count; ++e) {
      const std::int32_t member =
          membership.memberOf(&group.vertices[std::size_t(e * group.arity)], group.arity);
      if (member < 0) continue;
      part_of[membership.component(member)]->addEdge(problem.graph(), group, e);
    }
  }
  for (const std::unique_ptr<Part>& part : parts_) part->compile(registry, policy, interrupt);
}

InnerIterations::~InnerIterations() = default;

void InnerIterations::run(Values& values, ThreadPool& pool) {
  // Parts read what is held and write what is theirs alone.
  pool.run(std::int64_t(parts_.size()),
           [&](std::int64_t part) { parts_[std::size_t(part)]->run(iterations_, values); });
}

}  // namespace graft
