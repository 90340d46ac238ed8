// SPDX-License-Identifier: BSD-3-Clause
// Graphs that change between solves: the result is that of a graph made anew, whatever was
// kept of the symbolic work.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/graph/factor_graph.hpp"
#include "core/solve/optimizer.hpp"
#include "tests/core/solve/solve_types.hpp"

namespace graft {
namespace {

using testing::assemble;
using testing::makePoseGraph;
using testing::PoseGraphPart;
using testing::TestGraph;
using testing::testRegistry;

void add(TestGraph& g, const PoseGraphPart& part) {
  if (part.is_vertex) {
    g.vertex("VERTEX_SE3:QUAT", part.ids[0], part.numbers);
  } else {
    g.edge("TEST_BETWEEN3", part.ids, part.numbers);
  }
}

/// The parts that only name vertices below `count`.
std::vector<PoseGraphPart> firstVertices(const std::vector<PoseGraphPart>& parts, int count) {
  std::vector<PoseGraphPart> some;
  for (const PoseGraphPart& part : parts) {
    bool inside = true;
    for (const std::int64_t id : part.ids) inside = inside && id < count;
    if (inside) some.push_back(part);
  }
  return some;
}

double largestDifference(const TestGraph& a, const TestGraph& b) {
  double largest = 0;
  for (const VertexRef v : a.graph.verticesById()) {
    const std::vector<double> one = a.at(a.graph.id(v));
    const std::vector<double> two = b.at(a.graph.id(v));
    for (std::size_t i = 0; i < one.size(); ++i) {
      largest = std::max(largest, std::abs(one[i] - two[i]));
    }
  }
  return largest;
}

TEST(Reuse, SamePatternIsNotAnalyzedAgainAndGivesTheSameBits) {
  const std::vector<PoseGraphPart> parts = makePoseGraph(120, 0.05, 0.2, 21);
  Optimizer optimizer(testRegistry());
  TestGraph first = assemble(parts);
  EXPECT_EQ(optimizer.solve(first.graph, first.values).symbolic_reuse, SymbolicReuse::kNothing);
  TestGraph again = assemble(parts);
  const Summary kept = optimizer.solve(again.graph, again.values);
  EXPECT_EQ(kept.symbolic_reuse, SymbolicReuse::kEverything);
  EXPECT_TRUE(again.values == first.values);
}

TEST(Reuse, GrowingGraphsEndWhereNewOnesDo) {
  const int count = 160;
  const std::vector<PoseGraphPart> parts = makePoseGraph(count, 0.05, 0.2, 22);
  Optimizer optimizer(testRegistry());
  TestGraph growing;
  std::vector<bool> present(parts.size(), false);
  int orders_kept = 0;
  int orders_new = 0;
  for (int size = 20; size <= count; size += 5) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      bool inside = !present[i];
      for (const std::int64_t id : parts[i].ids) inside = inside && id < size;
      if (!inside) continue;
      add(growing, parts[i]);
      present[i] = true;
    }
    const Summary summary = optimizer.solve(growing.graph, growing.values);
    ASSERT_EQ(summary.status, Status::kConverged) << summary.reason;
    orders_kept += summary.symbolic_reuse == SymbolicReuse::kOrdering ? 1 : 0;
    orders_new += summary.symbolic_reuse == SymbolicReuse::kNothing ? 1 : 0;
    TestGraph fresh = assemble(firstVertices(parts, size));
    const Summary reference = optimize(fresh.graph, fresh.values, testRegistry());
    EXPECT_NEAR(summary.chi2_final, reference.chi2_final, 1e-7 * reference.chi2_final);
    EXPECT_LT(largestDifference(growing, fresh), 1e-4);
  }
  // Most steps keep the order; now and then it has become too dear.
  EXPECT_GT(orders_kept, orders_new);
  EXPECT_GT(orders_new, 1);
}

TEST(Reuse, RemovedEdgesAndVerticesLeaveTheGraphOfTheRest) {
  const std::vector<PoseGraphPart> parts = makePoseGraph(80, 0.05, 0.2, 23);
  Optimizer optimizer(testRegistry());
  TestGraph g = assemble(parts);
  optimizer.solve(g.graph, g.values);
  // The last 15 poses, and every edge that closes a loop over an odd distance.
  std::vector<EdgeId> wrong;
  std::vector<PoseGraphPart> rest;
  for (const PoseGraphPart& part : firstVertices(parts, 65)) {
    const bool odd =
        !part.is_vertex && part.ids[1] - part.ids[0] > 1 && (part.ids[1] - part.ids[0]) % 2 != 0;
    if (!odd) rest.push_back(part);
  }
  const EdgeBlock& block = g.graph.edgeBlocks()[0];
  for (std::size_t e = 0; e < block.size(); ++e) {
    const auto id = [&](std::size_t k) { return g.graph.id(block.vertices[2 * e + k]); };
    const std::int64_t apart = id(1) - id(0);
    if (apart > 1 && apart % 2 != 0) wrong.push_back(block.ids[e]);
  }
  ASSERT_GT(wrong.size(), 3u);
  g.graph.removeEdges(wrong);
  std::vector<std::int64_t> last;
  for (std::int64_t id = 65; id < 80; ++id) last.push_back(id);
  EXPECT_GE(g.graph.removeVertices(last, g.values), 15u);
  TestGraph fresh = assemble(rest);
  EXPECT_EQ(g.graph.edgeCount(), fresh.graph.edgeCount());
  EXPECT_EQ(g.graph.vertexCount(), fresh.graph.vertexCount());
  const Summary summary = optimizer.solve(g.graph, g.values);
  EXPECT_EQ(summary.symbolic_reuse, SymbolicReuse::kOrdering);
  const Summary reference = optimize(fresh.graph, fresh.values, testRegistry());
  EXPECT_NEAR(summary.chi2_final, reference.chi2_final, 1e-7 * reference.chi2_final);
  EXPECT_LT(largestDifference(g, fresh), 1e-4);
}

TEST(Reuse, ASolverThatFailedStartsAnew) {
  // A point that nothing holds in one solve; in the next a prior does.
  Optimizer optimizer(testRegistry());
  for (const bool held : {false, true, false, true}) {
    TestGraph g;
    g.point(0, 0, 0, true);
    g.point(1, 2, 0.5);
    g.edge("TEST_RANGE", {0, 1}, {1});
    if (held) g.edge("TEST_PRIOR", {1}, {0, 1});
    const Summary summary = optimizer.solve(g.graph, g.values);
    ASSERT_TRUE(summary.usable()) << summary.reason;
    EXPECT_NEAR(std::hypot(g.at(1)[0], g.at(1)[1]), 1, 1e-7);
    if (held) {
      EXPECT_NEAR(g.at(1)[1], 1, 1e-6);
    }
  }
}

TEST(Removal, KeepsAllThatBelongsToTheOtherEdges) {
  TestGraph g;
  constexpr int kEdges = 9;
  g.point(0, 0, 0);
  for (int i = 1; i <= kEdges; ++i) {
    g.point(i, i, 0);
    g.edge("TEST_DIFFERENCE", {0, i}, {double(i), 0}, {double(i), 0, 1}, 100 + i, -1);
    g.graph.setLevel(0, std::size_t(i - 1), i);
  }
  g.graph.removeEdges({0, 3, 7});
  EXPECT_EQ(g.graph.removeVertices({6}, g.values), 1u);
  const EdgeBlock& block = g.graph.edgeBlocks()[0];
  const std::vector<std::int32_t> expected = {2, 3, 5, 7, 9};
  EXPECT_EQ(block.levels, expected);
  ASSERT_EQ(block.size(), expected.size());
  ASSERT_EQ(block.kernels.size(), expected.size());
  ASSERT_EQ(block.error_dims.size(), expected.size());
  for (std::size_t e = 0; e < expected.size(); ++e) {
    const std::int32_t i = expected[e];
    EXPECT_EQ(block.lines[e], 100 + i);
    EXPECT_EQ(block.ids[e], i - 1);
    EXPECT_EQ(block.measurements[2 * e], i);
    EXPECT_EQ(block.information[3 * e], i);
    EXPECT_EQ(g.graph.id(block.vertices[2 * e + 1]), i);
    EXPECT_EQ(g.values.at(block.vertices[2 * e + 1])[0], i);
  }
}

TEST(Removal, ChangesNothingWhereSomethingIsNotThere) {
  TestGraph g;
  g.point(1, 0, 0);
  g.point(2, 1, 0);
  g.edge("TEST_DIFFERENCE", {1, 2}, {1, 0});
  EXPECT_THROW(g.graph.removeEdges({0, 7}), Error);
  EXPECT_THROW(g.graph.removeVertices({1, 9}, g.values), Error);
  EXPECT_EQ(g.graph.edgeCount(), 1u);
  EXPECT_EQ(g.graph.vertexCount(), 2u);
  EXPECT_EQ(g.at(2)[0], 1);
  // An edge's name is not given to another one.
  g.graph.removeEdges({0});
  g.edge("TEST_DIFFERENCE", {1, 2}, {1, 0});
  EXPECT_THROW(g.graph.removeEdges({0}), Error);
  EXPECT_EQ(g.graph.removeVertices({1}, g.values), 1u);
  EXPECT_EQ(g.graph.find(1).type, -1);
  EXPECT_EQ(g.at(2)[0], 1);
  g.point(1, 5, 6);
  EXPECT_EQ(g.at(1)[1], 6);
}

}  // namespace
}  // namespace graft
