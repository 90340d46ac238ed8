// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/initial_guess.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/solve/optimizer.hpp"
#include "tests/core/solve/solve_types.hpp"

namespace graft {
namespace {

using testing::TestGraph;
using testing::testRegistry;

SpreadResult spread(const TestGraph& g) {
  const Problem problem(g.graph, InformationPolicy::kError);
  State state;
  state.values = g.values;
  state.associations.resize(problem.groups().size());
  return spreadEstimates(problem, state);
}

TEST(SpreadEstimates, FollowsEdgesInBothDirectionsFromWhatIsFixed) {
  TestGraph g;
  g.vertex("VERTEX_SE2", 1, {0, 0, 0});
  g.vertex("VERTEX_SE2", 2, {5, 6, std::acos(0.0)}, true);
  g.vertex("VERTEX_SE2", 3, {0, 0, 0});
  g.edge("TEST_BETWEEN2", {2, 3}, {1, 0, 0});
  g.edge("TEST_BETWEEN2", {1, 2}, {2, 0, 0});
  const SpreadResult result = spread(g);
  EXPECT_EQ(result.placed, 2);
  EXPECT_EQ(result.unplaced, 0);
  const double* third = result.values.at(g.graph.find(3));
  EXPECT_NEAR(third[0], 5, 1e-15);
  EXPECT_NEAR(third[1], 7, 1e-15);
  const double* first = result.values.at(g.graph.find(1));
  EXPECT_NEAR(first[0], 5, 1e-15);
  EXPECT_NEAR(first[1], 4, 1e-15);
}

TEST(SpreadEstimates, TakesTheFewestEdges) {
  // A chain 0-1-2-3 with bad steps, and an edge 0-3.
  TestGraph g;
  for (int i = 0; i < 4; ++i) g.vertex("VERTEX_SE2", i, {9, 9, 0});
  for (int i = 1; i < 4; ++i) g.edge("TEST_BETWEEN2", {i - 1, i}, {10, 0, 0});
  g.edge("TEST_BETWEEN2", {0, 3}, {1, 0, 0});
  const SpreadResult result = spread(g);
  EXPECT_NEAR(result.values.at(g.graph.find(3))[0], 10, 1e-15);
  EXPECT_NEAR(result.values.at(g.graph.find(2))[0], 29, 1e-15);
  EXPECT_EQ(result.values.at(g.graph.find(0))[0], 9);
}

TEST(SpreadEstimates, CountsWhatNoEdgeCanPlace) {
  TestGraph g;
  g.point(1, 0, 0, true);
  g.point(2, 3, 4);
  g.edge("TEST_RANGE", {1, 2}, {1});
  const SpreadResult result = spread(g);
  EXPECT_EQ(result.placed, 0);
  EXPECT_EQ(result.unplaced, 1);
  EXPECT_EQ(result.values.at(g.graph.find(2))[1], 4);
}

TEST(SpreadEstimates, AutoTakesWhatHasTheLowerChi2) {
  for (const bool good : {false, true}) {
    TestGraph g;
    for (int i = 0; i < 3; ++i) g.vertex("VERTEX_SE2", i, {good ? i * 1.0 : 7.0, 0, 0});
    g.edge("TEST_BETWEEN2", {0, 1}, {1, 0, 0});
    g.edge("TEST_BETWEEN2", {1, 2}, {1, 0, 0});
    g.edge("TEST_BETWEEN2", {0, 2}, {2.3, 0, 0});
    g.edge("TEST_BETWEEN2", {0, 2}, {1.9, 0, 0}, {5, 0, 0, 5, 0, 5});
    const Summary summary = optimize(g.graph, g.values, testRegistry());
    EXPECT_EQ(summary.start, good ? StartKind::kGiven : StartKind::kSpanningTree);
    EXPECT_LE(summary.chi2_start, summary.chi2_initial);
    EXPECT_EQ(summary.status, Status::kConverged);
  }
}

}  // namespace
}  // namespace graft
