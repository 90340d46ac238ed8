// SPDX-License-Identifier: BSD-3-Clause
// The guess "odometry" against poses composed along the chain by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/graph/factor_graph.hpp"
#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"

namespace graft {
namespace {

constexpr int kPoses = 12;

struct Planar {
  double x, y, theta;
  Planar operator*(const Planar& o) const {
    return {x + std::cos(theta) * o.x - std::sin(theta) * o.y,
            y + std::sin(theta) * o.x + std::cos(theta) * o.y, theta + o.theta};
  }
};

/// The step from pose i to pose i + 1.
Planar step(int i) { return {1 + 0.1 * i, 0.05 * i, 0.3 - 0.04 * i}; }

SolveOptions guessOnly() {
  SolveOptions options;
  options.initial_guess = InitialGuess::kPlugin;
  options.guess_name = "odometry";
  options.iterations = 0;
  return options;
}

class GuessOdometry : public ::testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < kPoses; ++i) graph_.addVertex("VERTEX_SE2", i, {7, -3, 1});
    graph_.setEstimate(0, {1, 2, 0.5});
  }
  void addStep(int i, bool backwards) {
    const Planar s = step(i);
    if (!backwards) return void(graph_.addEdge("EDGE_SE2", {i, i + 1}, {s.x, s.y, s.theta}));
    const Planar turned = Planar{0, 0, -s.theta} * Planar{-s.x, -s.y, 0};
    graph_.addEdge("EDGE_SE2", {i + 1, i}, {turned.x, turned.y, -s.theta});
  }
  void expectAt(int id, const Planar& pose) {
    const std::vector<double> numbers = graph_.estimate(id);
    EXPECT_NEAR(numbers[0], pose.x, 1e-12) << id;
    EXPECT_NEAR(numbers[1], pose.y, 1e-12) << id;
    EXPECT_NEAR(std::remainder(numbers[2] - pose.theta, 2 * std::acos(-1.0)), 0, 1e-12) << id;
  }
  Summary solve() {
    return optimize(graph_.graph(), graph_.values(), engine_.registry(), guessOnly());
  }

  Engine engine_;
  FactorGraph graph_{engine_.registry()};
};

TEST_F(GuessOdometry, FollowsTheChainAndNotFalseClosures) {
  for (int i = 0; i + 1 < kPoses; ++i) addStep(i, i % 3 == 0);
  for (int i = 0; i + 4 < kPoses; ++i) graph_.addEdge("EDGE_SE2", {i, i + 4}, {0, 0, 0});
  const Summary summary = solve();
  EXPECT_EQ(summary.start, StartKind::kPlugin);
  EXPECT_EQ(summary.start_name, "odometry");
  Planar pose{1, 2, 0.5};
  for (int i = 0; i < kPoses; ++i) {
    expectAt(i, pose);
    pose = pose * step(i);
  }
}

TEST_F(GuessOdometry, LeavesGapsToTheSpanningTree) {
  // No step from 5 to 6; a closure leads there.
  for (int i = 0; i + 1 < kPoses; ++i) {
    if (i != 5) addStep(i, false);
  }
  graph_.addEdge("EDGE_SE2", {3, 8}, {2, 1, 0.25});
  solve();
  Planar pose{1, 2, 0.5};
  for (int i = 0; i < 3; ++i) pose = pose * step(i);
  Planar eighth = pose * Planar{2, 1, 0.25};
  expectAt(8, eighth);
  expectAt(9, eighth * step(8));
}

TEST_F(GuessOdometry, SaysWhyThereIsNone) {
  for (int i = 0; i + 2 < kPoses; i += 2) graph_.addEdge("EDGE_SE2", {i, i + 2}, {1, 0, 0});
  try {
    solve();
    FAIL() << "there is nothing to follow";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kNoResult);
    EXPECT_NE(std::string(error.what()).find("no edge joins a held vertex"), std::string::npos)
        << error.what();
  }
}

TEST_F(GuessOdometry, UnknownNamesAndMissingNamesAreRefused) {
  addStep(0, false);
  SolveOptions options = guessOnly();
  options.guess_name = "odometri";
  EXPECT_THROW(optimize(graph_.graph(), graph_.values(), engine_.registry(), options), Error);
  options.guess_name.clear();
  EXPECT_NE(options.validate(), "");
  options = SolveOptions();
  options.guess_name = "odometry";
  EXPECT_NE(options.validate(), "");
}

}  // namespace
}  // namespace graft
