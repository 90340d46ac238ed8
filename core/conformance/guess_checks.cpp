// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/error.hpp"
#include "core/base/parallel.hpp"
#include "core/conformance/checks.hpp"
#include "core/conformance/function_checks.hpp"
#include "core/geometry/se2.hpp"
#include "core/solve/linearizer.hpp"
#include "core/solve/plugin_guess.hpp"
#include "core/types/plugin.hpp"

namespace graft::conformance {

namespace {

/// Relative pose in the plane: an edge that every guess for poses should cope with.
struct PlaneEdge : Edge<PlaneEdge, 3, SE2, SE2>, Measured<Pose2> {
  static constexpr auto tag = "CHECK_PLANE_EDGE";
  static constexpr auto doc = "measured pose of the second vertex in the first";

  template <class T>
  Vec<T, 3> error(const SE2<T>& a, const SE2<T>& b) const {
    const SE2<T> rest = measurement.inverse().template cast<T>() * (a.inverse() * b);
    return Vec<T, 3>(rest.x, rest.y, rest.theta);
  }
  bool propagate(int to, Pose2& a, Pose2& b) const {
    if (to == 1) {
      b = a * measurement;
    } else {
      a = b * measurement.inverse();
    }
    return true;
  }
};

struct World {
  Graph graph;
  Values values;
};

/// A loop of poses, one of them fixed, and one that no edge touches.
World loopOfPoses() {
  constexpr int kPoses = 6;
  World world;
  const auto add = [&](int id) {
    const double numbers[] = {0.5 * id, -0.25 * id, 0.1 * id};
    return world.graph.addVertex(vertexType<SE2>(), id, numbers, world.values);
  };
  std::vector<VertexRef> poses;
  poses.reserve(kPoses);
  for (int i = 0; i < kPoses; ++i) poses.push_back(add(i));
  add(kPoses + 3);
  world.graph.setFixed(poses[2], true);
  for (int i = 0; i < kPoses; ++i) {
    Graph::EdgeSpec spec;
    spec.type = &PlaneEdge::descriptor();
    spec.vertices = {poses[std::size_t(i)], poses[std::size_t((i + 1) % kPoses)]};
    spec.measurement = {1, 0, 1.05};
    world.graph.addEdge(std::move(spec));
  }
  return world;
}

PluginGuessResult guess(const graft_guess_type& type, const Graph& graph, const Values& values) {
  const Problem problem(graph, InformationPolicy::kProject);
  ThreadPool pool(1);
  State state;
  const Evaluation evaluation = Linearizer(problem, pool).begin(values, state);
  if (!evaluation.ok()) throw Skip("the graph cannot be evaluated: " + evaluation.failure);
  try {
    return guessByPlugin(problem, state, type);
  } catch (const Error& error) {
    throw Defect(error.what());
  }
}

void requireReason(const PluginGuessResult& result) {
  if (result.failed && result.reason.empty()) throw Defect("guess() fails without a reason");
}

void checkContract(const graft_guess_type& type, const Graph& graph, const Values& values) {
  const PluginGuessResult first = guess(type, graph, values);
  requireReason(first);
  if (first.failed) throw Skip("it has no guess for this graph: " + first.reason);
  const PluginGuessResult second = guess(type, graph, values);
  if (!(first.values == second.values) || !(first.placed == second.placed)) {
    throw Defect("two calls with the same graph differ");
  }
  const World other = loopOfPoses();
  guess(type, other.graph, other.values);
  const PluginGuessResult third = guess(type, graph, values);
  if (!(first.values == third.values)) throw Defect("it keeps state from one graph to the next");
}

void checkEmpty(const graft_guess_type& type) {
  const World empty;
  requireReason(guess(type, empty.graph, empty.values));
}

}  // namespace

void addGuessChecks(const Context& context, const graft_guess_type& type, Checks& checks) {
  checks.push_back({"guess.empty", [&type] { checkEmpty(type); }});
  checks.push_back({"guess.loop", [&type] {
                      const World world = loopOfPoses();
                      checkContract(type, world.graph, world.values);
                    }});
  if (context.example == nullptr) return;
  checks.push_back({"guess.example", [context, &type] {
                      checkContract(type, *context.example, *context.example_values);
                    }});
}

}  // namespace graft::conformance
