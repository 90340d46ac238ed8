// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/optimizer.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "tests/core/solve/solve_types.hpp"

namespace graft {
namespace {

using testing::assemble;
using testing::makePoseGraph;
using testing::PoseGraphPart;
using testing::TestGraph;
using testing::testRegistry;

constexpr Algorithm kAlgorithms[] = {Algorithm::kLevenbergMarquardt, Algorithm::kGaussNewton,
                                     Algorithm::kDogleg};

SolveOptions optionsFor(Algorithm algorithm) {
  SolveOptions options;
  options.algorithm = algorithm;
  options.threads = 1;
  return options;
}

TEST(Optimize, SolvesLinearLeastSquaresInClosedForm) {
  // Two points, priors and a difference, with full information matrices.
  const std::vector<double> w1 = {2, 0.5, 3};
  const std::vector<double> w2 = {1, -0.2, 4};
  const std::vector<double> w3 = {5, 1, 2};
  Eigen::Matrix2d o1, o2, o3;
  o1 << 2, 0.5, 0.5, 3;
  o2 << 1, -0.2, -0.2, 4;
  o3 << 5, 1, 1, 2;
  const Eigen::Vector2d z1(1, 2), z2(4, -1), z3(2, 2);
  Eigen::Matrix4d h = Eigen::Matrix4d::Zero();
  h.topLeftCorner<2, 2>() = o1 + o3;
  h.bottomRightCorner<2, 2>() = o2 + o3;
  h.topRightCorner<2, 2>() = -o3;
  h.bottomLeftCorner<2, 2>() = -o3;
  Eigen::Vector4d b;
  b << o1 * z1 - o3 * z3, o2 * z2 + o3 * z3;
  const Eigen::Vector4d expected = h.ldlt().solve(b);
  for (const Algorithm algorithm : kAlgorithms) {
    TestGraph g;
    g.point(1, 10, -10);
    g.point(2, 0, 7);
    g.edge("TEST_PRIOR", {1}, {1, 2}, w1);
    g.edge("TEST_PRIOR", {2}, {4, -1}, w2);
    g.edge("TEST_DIFFERENCE", {1, 2}, {2, 2}, w3);
    const Summary summary = optimize(g.graph, g.values, testRegistry(), optionsFor(algorithm));
    EXPECT_EQ(summary.status, Status::kConverged) << summary.reason;
    EXPECT_TRUE(summary.notes.empty());
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(g.at(1 + i / 2)[std::size_t(i % 2)], expected[i], 1e-8);
    }
    const Eigen::Vector2d p1 = expected.head<2>(), p2 = expected.tail<2>();
    const auto square = [](const Eigen::Vector2d& e, const Eigen::Matrix2d& o) -> double {
      return e.dot(o * e);
    };
    EXPECT_NEAR(summary.chi2_final,
                square(p1 - z1, o1) + square(p2 - z2, o2) + square(p2 - p1 - z3, o3), 1e-10);
    EXPECT_NEAR(evaluateChi2(g.graph, g.values), summary.chi2_final, 1e-12);
    double sum = 0;
    for (const auto& [tag, chi2] : summary.chi2_by_tag) sum += chi2;
    EXPECT_NEAR(sum, summary.chi2_final, 1e-12);
    EXPECT_EQ(summary.chi2_by_tag.size(), 2u);
  }
}

TEST(Optimize, FindsTheTruthOfNoiseFreePoseGraphs) {
  const std::vector<PoseGraphPart> parts = makePoseGraph(150, 0, 0.1, 3);
  for (const Algorithm algorithm : kAlgorithms) {
    TestGraph g = assemble(parts);
    SolveOptions options = optionsFor(algorithm);
    options.initial_guess = InitialGuess::kFile;
    const Summary summary = optimize(g.graph, g.values, testRegistry(), options);
    EXPECT_EQ(summary.status, Status::kConverged) << summary.reason;
    EXPECT_LT(summary.chi2_final, 1e-18);
    EXPECT_EQ(summary.start, StartKind::kGiven);
    // Zero residuals: the last full steps converge quadratically.
    const auto& iterations = summary.iterations;
    ASSERT_GE(iterations.size(), 4u);
    for (std::size_t i = 1; i + 1 < iterations.size(); ++i) {
      const double before = std::sqrt(iterations[i].chi2);
      const double after = std::sqrt(iterations[i + 1].chi2);
      if (before < 1e-2 && after > 1e-12) {
        EXPECT_LT(after, before * before);
      }
    }
  }
}

TEST(Optimize, SpanningTreeSolvesNoiseFreeGraphsAtOnce) {
  TestGraph g = assemble(makePoseGraph(150, 0, 1.5, 4));
  const Summary summary = optimize(g.graph, g.values, testRegistry());
  EXPECT_EQ(summary.start, StartKind::kSpanningTree);
  EXPECT_GT(summary.chi2_initial, 1);
  EXPECT_LT(summary.chi2_start, 1e-18);
  EXPECT_EQ(summary.status, Status::kConverged);
}

TEST(Optimize, AgreesBetweenAlgorithmsAndSolversAndNeverClimbs) {
  const std::vector<PoseGraphPart> parts = makePoseGraph(200, 0.05, 0.3, 5);
  double reference = 0;
  for (const char* solver : {"block", "test_dense"}) {
    for (const Algorithm algorithm : kAlgorithms) {
      TestGraph g = assemble(parts);
      SolveOptions options = optionsFor(algorithm);
      options.linear_solver = solver;
      options.function_tolerance = 1e-14;
      const Summary summary = optimize(g.graph, g.values, testRegistry(), options);
      EXPECT_EQ(summary.status, Status::kConverged) << summary.reason;
      EXPECT_EQ(summary.linear_solver, solver);
      for (std::size_t i = 1; i < summary.iterations.size(); ++i) {
        EXPECT_LE(summary.iterations[i].chi2, summary.iterations[i - 1].chi2);
        EXPECT_EQ(summary.iterations[i].iteration, int(i));
      }
      if (reference == 0) reference = summary.chi2_final;
      EXPECT_NEAR(summary.chi2_final, reference, 1e-9 * reference);
    }
  }
}

TEST(Optimize, GivesTheSameBitsForAnyThreadsAndOrder) {
  std::vector<PoseGraphPart> parts = makePoseGraph(400, 0.05, 0.2, 6);
  TestGraph first = assemble(parts);
  SolveOptions options = optionsFor(Algorithm::kLevenbergMarquardt);
  const Summary reference = optimize(first.graph, first.values, testRegistry(), options);
  std::mt19937_64 random(7);
  for (const int threads : {1, 2, 4}) {
    std::shuffle(parts.begin(), parts.end(), random);
    TestGraph g = assemble(parts);
    options.threads = threads;
    const Summary summary = optimize(g.graph, g.values, testRegistry(), options);
    EXPECT_EQ(summary.chi2_final, reference.chi2_final);
    EXPECT_EQ(summary.threads, threads);
    ASSERT_EQ(summary.iterations.size(), reference.iterations.size());
    for (std::size_t i = 0; i < summary.iterations.size(); ++i) {
      EXPECT_EQ(summary.iterations[i].chi2, reference.iterations[i].chi2);
      EXPECT_EQ(summary.iterations[i].step_norm, reference.iterations[i].step_norm);
    }
    for (std::int64_t id = 0; id < 400; ++id) ASSERT_EQ(g.at(id), first.at(id)) << id;
  }
}

TEST(Optimize, DoesNotCareWhichVertexIsHeld) {
  const std::vector<PoseGraphPart> parts = makePoseGraph(60, 0.05, 0.1, 8);
  double reference = 0;
  for (const std::int64_t held : {0, 17, 59}) {
    TestGraph g = assemble(parts);
    g.graph.setFixed(g.graph.find(held), true);
    const std::vector<double> before = g.at(held);
    SolveOptions options;
    options.function_tolerance = 1e-14;
    const Summary summary = optimize(g.graph, g.values, testRegistry(), options);
    EXPECT_EQ(g.at(held), before);
    EXPECT_TRUE(summary.notes.empty());
    if (reference == 0) reference = summary.chi2_final;
    EXPECT_NEAR(summary.chi2_final, reference, 1e-9 * reference);
  }
}

TEST(Optimize, SolvesEdgesOfAnyArity) {
  // The mean of n points is moved to (1, 2): least change of each, with weak priors.
  TestGraph g;
  std::vector<std::int64_t> ids;
  for (int i = 0; i < 7; ++i) {
    g.point(i, i, -i);
    g.edge("TEST_PRIOR", {i}, {double(i), double(-i)});
    ids.push_back(i);
  }
  g.edge("TEST_CENTROID", ids, {1, 2}, {49, 0, 49});
  g.edge("TEST_CENTROID", {0, 1}, {0.5, -0.5});
  const Summary summary = optimize(g.graph, g.values, testRegistry());
  EXPECT_EQ(summary.status, Status::kConverged);
  Eigen::MatrixXd h = Eigen::MatrixXd::Identity(7, 7) + Eigen::MatrixXd::Ones(7, 7);
  h.topLeftCorner(2, 2).array() += 0.25;
  for (int c = 0; c < 2; ++c) {
    Eigen::VectorXd b(7);
    for (int i = 0; i < 7; ++i) b[i] = (c == 0 ? i : -i) + 7 * (c == 0 ? 1 : 2);
    b.head(2).array() += 0.5 * (c == 0 ? 0.5 : -0.5);
    const Eigen::VectorXd x = h.ldlt().solve(b);
    for (int i = 0; i < 7; ++i) EXPECT_NEAR(g.at(i)[std::size_t(c)], x[i], 1e-9);
  }
}

TEST(Optimize, RobustKernelsWeighByTheirDerivative) {
  // One outlier: the minimum of F(x) = (x)^2 + 4 (x - 0.1)^2 + rho((x - 8)^2), by bisection of F'.
  TestGraph g;
  const std::int32_t kernel = g.graph.addKernel({testRegistry().kernel("cauchy"), 1.5});
  g.point(1, 3, 0);
  g.edge("TEST_PRIOR", {1}, {0, 0});
  g.edge("TEST_PRIOR", {1}, {0.1, 0}, {4, 0, 4});
  g.edge("TEST_PRIOR", {1}, {8, 0}, {}, 0, kernel);
  const auto slope = [](double x) {
    return 2 * x + 8 * (x - 0.1) + 2 * (x - 8) / (1 + (x - 8) * (x - 8) / 2.25);
  };
  double low = 0;
  double high = 3;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (slope(middle) < 0 ? low : high) = middle;
  }
  for (const Algorithm algorithm : kAlgorithms) {
    Values values = g.values;
    SolveOptions options = optionsFor(algorithm);
    options.function_tolerance = 0;
    const Summary summary = optimize(g.graph, values, testRegistry(), options);
    EXPECT_TRUE(summary.usable()) << summary.reason;
    const double x = values.at(g.graph.find(1))[0];
    EXPECT_NEAR(x, low, 1e-7);
    const double s = (x - 8) * (x - 8);
    EXPECT_NEAR(summary.chi2_final,
                x * x + 4 * (x - 0.1) * (x - 0.1) + 2.25 * std::log(1 + s / 2.25), 1e-12);
  }
}

TEST(Optimize, AssociationsFindTheBestOfASet) {
  // (p - x0)^2 + the least of (p - a)^2 / 2 over three anchors, begun at x0: brute force.
  const double anchors[3][2] = {{0, 0}, {4, 1}, {9, -2}};
  for (double x0 = -1; x0 <= 11; x0 += 0.5) {
    TestGraph g;
    g.point(1, x0, 0);
    g.edge("TEST_PRIOR", {1}, {x0, 0});
    g.edge("TEST_NEAREST", {1}, {0, 0, 4, 1, 9, -2}, {0.5, 0, 0.5});
    const Summary summary = optimize(g.graph, g.values, testRegistry());
    EXPECT_EQ(summary.status, Status::kConverged) << summary.reason;
    double best = std::numeric_limits<double>::infinity();
    for (const auto& a : anchors) best = std::min(best, (std::pow(a[0] - x0, 2) + a[1] * a[1]) / 3);
    EXPECT_NEAR(summary.chi2_final, best, 1e-9);
  }
}

TEST(Optimize, AssociationsFollowTheStateAndNeverRaiseChi2) {
  for (const Algorithm algorithm : kAlgorithms) {
    TestGraph g;
    g.point(1, 20, 0);
    g.edge("TEST_PRIOR", {1}, {0.5, 0}, {4, 0, 4});
    g.edge("TEST_NEAREST", {1}, {0, 0, 4, 1, 9, -2});
    const Summary summary = optimize(g.graph, g.values, testRegistry(), optionsFor(algorithm));
    EXPECT_EQ(summary.status, Status::kConverged) << summary.reason;
    EXPECT_GT(summary.associations_changed, 0);
    EXPECT_NEAR(g.at(1)[0], 0.4, 1e-8);
    EXPECT_NEAR(summary.chi2_final, evaluateChi2(g.graph, g.values), 1e-12)
        << "associations are not those of the final estimates";
    std::int64_t changed = 0;
    for (std::size_t i = 1; i < summary.iterations.size(); ++i) {
      EXPECT_LE(summary.iterations[i].chi2, summary.iterations[i - 1].chi2);
      changed += summary.iterations[i].associations_changed;
    }
    EXPECT_EQ(summary.associations_changed, changed);
  }
}

TEST(Optimize, AssociationToleranceEndsGraphsWithChoicesOnly) {
  for (const bool choices : {false, true}) {
    TestGraph g;
    g.point(1, 20, 0);
    g.point(2, 3, 2);
    g.edge("TEST_PRIOR", {1}, {0.5, 0}, {4, 0, 4});
    g.edge("TEST_RANGE", {1, 2}, {3}, {2});
    g.edge("TEST_RANGE", {1, 2}, {4}, {1});
    g.edge("TEST_PRIOR", {2}, {1, 1});
    if (choices) g.edge("TEST_NEAREST", {1}, {0, 0, 4, 1, 9, -2});
    SolveOptions options = optionsFor(Algorithm::kLevenbergMarquardt);
    Values values = g.values;
    const Summary fine = optimize(g.graph, values, testRegistry(), options);
    options.association_tolerance = 0.01;
    values = g.values;
    const Summary coarse = optimize(g.graph, values, testRegistry(), options);
    if (!choices) {
      EXPECT_EQ(coarse.iterations.size(), fine.iterations.size());
      continue;
    }
    EXPECT_LT(coarse.iterations.size(), fine.iterations.size());
    EXPECT_NE(coarse.reason.find("association_tolerance"), std::string::npos) << coarse.reason;
    for (std::size_t i = 1; i < coarse.iterations.size(); ++i) {
      const bool small = coarse.iterations[i].chi2_change <= 0.01 * coarse.iterations[i - 1].chi2;
      EXPECT_EQ(small, i + 1 == coarse.iterations.size()) << "iteration " << i;
    }
  }
}

}  // namespace
}  // namespace graft
