// SPDX-License-Identifier: BSD-3-Clause
// What only edges that choose tie to the rest is solved by itself after every step.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "core/solve/inner_iterations.hpp"
#include "core/solve/optimizer.hpp"
#include "tests/core/solve/solve_types.hpp"

namespace graft::testing {
namespace {

constexpr int kPoints = 12;
constexpr int kChains = 5;
constexpr int kWalk = 40;

std::int64_t pose(int chain) { return 1000 * (chain + 1); }
std::int64_t point(int chain, int i) { return pose(chain) + 1 + i; }

/// Chains of points above a wedge that hangs on a pose of the chain's own, and a walk of poses,
/// so that poses are the rest. One chain alone if `only` is not -1. Convex: a quadratic program
/// with one minimum.
TestGraph chains(int only = -1) {
  TestGraph g;
  g.vertex("VERTEX_SE2", 0, {0, 0, 0}, true);
  for (int i = 1; i <= kWalk; ++i) {
    g.vertex("VERTEX_SE2", i, {1.1 * i, 0.1, 0});
    g.edge("TEST_BETWEEN2", {i - 1, i}, {1, 0, 0});
  }
  for (int c = 0; c < kChains; ++c) {
    if (only >= 0 && c != only) continue;
    g.vertex("VERTEX_SE2", pose(c), {0.3 * c, -0.2, 0});
    g.edge("TEST_BETWEEN2", {0, pose(c)}, {0.25 * c, 0.1 * c, 0}, {50, 0, 0, 50, 0, 50});
    for (int i = 0; i < kPoints; ++i) {
      const double u = double(i) / (kPoints - 1);
      g.point(point(c, i), 1 - 2 * u, 4);
      g.edge("TEST_PRIOR", {point(c, i)},
             {2 * std::sin((5 + c) * u), 2 * std::cos((3 + c) * u) - 1}, {1, 0, 1});
      g.edge("TEST_BEYOND_SEEN", {pose(c), point(c, i)}, {0.8, 0.6, 0}, {1e4});
      g.edge("TEST_BEYOND_SEEN", {pose(c), point(c, i)}, {-0.8, 0.6, 0}, {1e4});
      if (i > 0) g.edge("TEST_DIFFERENCE", {point(c, i - 1), point(c, i)}, {0, 0}, {20, 0, 20});
    }
  }
  return g;
}

SolveOptions options(int inner, int threads = 1) {
  SolveOptions o;
  o.initial_guess = InitialGuess::kFile;
  o.inner_iterations = inner;
  o.association_tolerance = 1e-12;
  o.threads = threads;
  return o;
}

std::size_t partsOf(const TestGraph& g, int iterations = 8) {
  const Problem problem(g.graph, InformationPolicy::kError);
  return InnerIterations(problem, testRegistry(), InformationPolicy::kError, iterations).parts();
}

TEST(InnerIterations, PartsAreComponentsThatOnlyChoosingEdgesTieToTheRest) {
  EXPECT_EQ(partsOf(chains()), std::size_t{kChains});
  EXPECT_EQ(partsOf(chains(), 0), 0U);
  TestGraph joined = chains();
  joined.edge("TEST_DIFFERENCE", {point(0, 0), point(1, 0)}, {0, 0});
  EXPECT_EQ(partsOf(joined), std::size_t{kChains - 1});
  TestGraph held = chains();
  for (int i = 0; i < kPoints; ++i) held.graph.setFixed(held.graph.find(point(0, i)), true);
  EXPECT_EQ(partsOf(held), std::size_t{kChains - 1});
  TestGraph tied = chains();
  tied.edge("TEST_LEASH", {pose(0), point(0, 0)}, {});
  EXPECT_EQ(partsOf(tied), 0U);
}

TEST(InnerIterations, WithoutChoicesNothingTakesPart) {
  TestGraph g;
  g.vertex("VERTEX_SE2", 0, {0, 0, 0}, true);
  g.vertex("VERTEX_SE2", 1, {0, 0, 0});
  g.edge("TEST_BETWEEN2", {0, 1}, {1, 0, 0});
  g.point(2, 0, 0);
  g.edge("TEST_LEASH", {1, 2}, {});
  EXPECT_EQ(partsOf(g), 0U);
  // An edge that chooses, but joins nothing: all that is free is the rest.
  TestGraph alone;
  alone.point(1, 0, 0);
  alone.edge("TEST_NEAREST", {1}, {1, 1, 2, 2, 3, 3});
  EXPECT_EQ(partsOf(alone), 0U);
}

TEST(InnerIterations, EndAtTheSameMinimumInFewerSteps) {
  TestGraph without = chains();
  TestGraph with = chains();
  const Summary a = optimize(without.graph, without.values, testRegistry(), options(0));
  const Summary b = optimize(with.graph, with.values, testRegistry(), options(8));
  ASSERT_EQ(a.status, Status::kConverged) << a.reason;
  ASSERT_EQ(b.status, Status::kConverged) << b.reason;
  EXPECT_EQ(a.inner_parts, 0U);
  EXPECT_EQ(b.inner_parts, std::size_t{kChains});
  EXPECT_NEAR(b.chi2_final, a.chi2_final, 1e-6 * a.chi2_final);
  EXPECT_NEAR(b.chi2_final, evaluateChi2(with.graph, with.values), 1e-9 * b.chi2_final);
  EXPECT_LT(b.iterationCount(), a.iterationCount());
  for (int c = 0; c < kChains; ++c) {
    for (int i = 0; i < kPoints; ++i) {
      EXPECT_NEAR(with.at(point(c, i))[0], without.at(point(c, i))[0], 1e-4);
      EXPECT_NEAR(with.at(point(c, i))[1], without.at(point(c, i))[1], 1e-4);
    }
  }
}

TEST(InnerIterations, OnlyWhatTakesPartMovesAndNoPartDependsOnAnother) {
  TestGraph all = chains();
  const Problem problem(all.graph, InformationPolicy::kError);
  ThreadPool pool(2);
  const double before = evaluateChi2(all.graph, all.values);
  InnerIterations(problem, testRegistry(), InformationPolicy::kError, 50).run(all.values, pool);
  EXPECT_LT(evaluateChi2(all.graph, all.values), 0.5 * before);
  for (int c = 0; c < kChains; ++c) {
    EXPECT_EQ(all.at(pose(c)), chains().at(pose(c)));
    TestGraph one = chains(c);
    const Problem alone(one.graph, InformationPolicy::kError);
    InnerIterations(alone, testRegistry(), InformationPolicy::kError, 50).run(one.values, pool);
    for (int i = 0; i < kPoints; ++i) EXPECT_EQ(all.at(point(c, i)), one.at(point(c, i)));
  }
}

TEST(InnerIterations, ResultsDoNotDependOnThreads) {
  TestGraph first = chains();
  optimize(first.graph, first.values, testRegistry(), options(8, 1));
  for (const int threads : {2, 4}) {
    TestGraph g = chains();
    optimize(g.graph, g.values, testRegistry(), options(8, threads));
    EXPECT_TRUE(g.values == first.values) << threads;
  }
}

TEST(InnerIterations, AnInterruptLeavesThePartsAsTheyAre) {
  std::atomic<int> interrupt{1};
  TestGraph g = chains();
  const Problem problem(g.graph, InformationPolicy::kError);
  ThreadPool pool(1);
  InnerIterations(problem, testRegistry(), InformationPolicy::kError, 8, &interrupt)
      .run(g.values, pool);
  EXPECT_TRUE(g.values == chains().values);
}

TEST(InnerIterations, NegativeCountsAreRefused) {
  SolveOptions o;
  o.inner_iterations = -1;
  EXPECT_NE(o.validate().find("inner_iterations is -1"), std::string::npos);
}

}  // namespace
}  // namespace graft::testing
