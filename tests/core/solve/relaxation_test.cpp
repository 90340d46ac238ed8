// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/relaxation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/error.hpp"
#include "core/geometry/se2.hpp"
#include "core/geometry/se3.hpp"
#include "core/graph/factor_graph.hpp"
#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"
#include "tests/support/graphs.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

class RelaxationTest : public ::testing::Test {
 protected:
  double uniform(double extent) {
    return std::uniform_real_distribution<double>(-extent, extent)(random_);
  }
  Pose2 planePose() { return {uniform(20), uniform(20), uniform(3.1)}; }
  Pose spacePose() {
    Eigen::Quaterniond q(uniform(1), uniform(1), uniform(1), uniform(1));
    return Pose(Vec<double, 3>(uniform(20), uniform(20), uniform(20)), q.normalized());
  }
  template <class P>
  static std::vector<double> numbers(const P& pose) {
    std::vector<double> list(P::kAmbientDim);
    pose.toArray(list.data());
    return list;
  }
  /// A positive definite matrix's upper triangle.
  std::vector<double> information(int n) {
    Eigen::MatrixXd root(n, n);
    for (Eigen::Index i = 0; i < root.size(); ++i) root.data()[i] = uniform(1);
    const Eigen::MatrixXd omega = root.transpose() * root + 0.1 * Eigen::MatrixXd::Identity(n, n);
    std::vector<double> upper;
    for (int r = 0; r < n; ++r) {
      for (int c = r; c < n; ++c) upper.push_back(omega(r, c));
    }
    return upper;
  }
  /// chi2 after the chordal guess alone, without a step.
  static Summary guess(const FactorGraph& g, Values& values, Registry& registry) {
    SolveOptions options;
    options.initial_guess = InitialGuess::kChordal;
    options.iterations = 0;
    return optimize(g.graph(), values, registry, options);
  }

  std::mt19937_64 random_{5};
  Engine engine_;
};

TEST_F(RelaxationTest, WithoutNoiseIsExactInThePlane) {
  FactorGraph g(engine_.registry());
  std::vector<Pose2> truth;
  for (int i = 0; i < 30; ++i) {
    truth.push_back(planePose());
    // Estimates that tell nothing, but for the fixed one.
    g.addVertex("VERTEX_SE2", i, numbers(i == 4 ? truth.back() : planePose()));
  }
  g.fix(4);
  for (int i = 0; i < 30; ++i) {
    for (const int j : {(i + 1) % 30, (i + 7) % 30}) {
      g.addEdge("EDGE_SE2", {i, j},
                numbers(truth[std::size_t(i)].inverse() * truth[std::size_t(j)]), information(3));
    }
  }
  // A landmark, placed by the second stage.
  g.addVertex("VERTEX_XY", 100, {0, 0});
  const Vec<double, 2> landmark(3, -4);
  for (int i = 0; i < 5; ++i) {
    const Vec<double, 2> seen = truth[std::size_t(i)].inverse() * landmark;
    g.addEdge("EDGE_SE2_XY", {i, 100}, {seen[0], seen[1]}, information(2));
  }
  Values values = g.values();
  const Summary summary = guess(g, values, engine_.registry());
  EXPECT_EQ(summary.start, StartKind::kChordal);
  EXPECT_LT(summary.chi2_start, 1e-20);
  for (int i = 0; i < 30; ++i) {
    const double* x = values.at(g.graph().find(i));
    EXPECT_NEAR(x[0], truth[std::size_t(i)].x, 1e-9);
    EXPECT_NEAR(x[1], truth[std::size_t(i)].y, 1e-9);
    EXPECT_NEAR(wrapAngle(x[2] - truth[std::size_t(i)].theta), 0, 1e-9);
  }
  EXPECT_NEAR(values.at(g.graph().find(100))[1], -4, 1e-9);
}

TEST_F(RelaxationTest, WithoutNoiseIsExactInSpace) {
  FactorGraph g(engine_.registry());
  g.addResource("PARAMS_SE3OFFSET", 0, {"1", "2", "3", "0.5", "0.5", "-0.5", "0.5"}, ".");
  const Pose offset(Vec<double, 3>(1, 2, 3), Eigen::Quaterniond(0.5, 0.5, 0.5, -0.5));
  std::vector<Pose> truth;
  for (int i = 0; i < 30; ++i) {
    truth.push_back(spacePose());
    g.addVertex("VERTEX_SE3:QUAT", i, numbers(spacePose()));
  }
  // A prior anchors it, nothing is fixed.
  g.addEdge("EDGE_SE3_PRIOR", {7}, numbers(truth[7] * offset), information(6), {0});
  for (int i = 0; i < 30; ++i) {
    const Pose& a = truth[std::size_t(i)];
    const Pose& b = truth[std::size_t((i + 1) % 30)];
    const Pose& c = truth[std::size_t((i + 7) % 30)];
    g.addEdge("EDGE_SE3:QUAT", {i, (i + 1) % 30}, numbers(a.inverse() * b), information(6));
    g.addEdge("EDGE_SE3_OFFSET", {i, (i + 7) % 30}, numbers((a * offset).inverse() * (c * offset)),
              information(6), {0, 0});
  }
  g.addVertex("VERTEX_TRACKXYZ", 100, {0, 0, 0});
  const Vec<double, 3> seen = (truth[3] * offset).inverse() * Vec<double, 3>(3, -4, 5);
  g.addEdge("EDGE_SE3_TRACKXYZ", {3, 100}, {seen[0], seen[1], seen[2]}, information(3), {0});
  Values values = g.values();
  const Summary summary = guess(g, values, engine_.registry());
  EXPECT_LT(summary.chi2_start, 1e-19);
  EXPECT_NEAR(values.at(g.graph().find(100))[2], 5, 1e-9);
}

TEST_F(RelaxationTest, WhatItCannotPlaceIsSpreadFromWhatItCan) {
  FactorGraph g(engine_.registry());
  for (int i = 0; i < 3; ++i) g.addVertex("VERTEX_SE2", i, {0, 0, 0});
  g.addVertex("VERTEX_XY", 9, {50, 50});
  g.addEdge("EDGE_SE2", {0, 1}, {1, 0, 0.5});
  g.addEdge("EDGE_SE2", {1, 2}, {1, 0, 0.5});
  // Has no linear equations, but can place its point from the pose.
  g.addEdge("EDGE_SE2_POINTXY_OFFSET", {2, 9}, {1, 1}, {}, [&] {
    g.addResource("PARAMS_SE2OFFSET", 0, {"0", "0", "0"}, ".");
    return std::vector<std::int64_t>{0};
  }());
  Values values = g.values();
  EXPECT_LT(guess(g, values, engine_.registry()).chi2_start, 1e-25);
}

TEST_F(RelaxationTest, AnEdgeOfManyPointsPlacesThemAll) {
  FactorGraph g(engine_.registry());
  g.addVertex("VERTEX_SE2", 0, {1, 2, 0.5});
  for (int i = 1; i < 4; ++i) g.addVertex("VERTEX_XY", i, {50, 50});
  g.addEdge("EDGE_SE2_LOTSOFXY", {0, 1, 2, 3}, {3, 1, 1, 2, 2, 3, 1});
  SolveOptions options;
  options.iterations = 0;
  Values values = g.values();
  const Summary summary = optimize(g.graph(), values, engine_.registry(), options);
  EXPECT_EQ(summary.start, StartKind::kSpanningTree);
  EXPECT_LT(summary.chi2_start, 1e-25);
}

TEST_F(RelaxationTest, SaysWhereThereIsNone) {
  FactorGraph g(engine_.registry());
  g.addVertex("VERTEX_XY", 0, {0, 0});
  g.addVertex("VERTEX_LINE2D", 1, {0, 1, -1, -1});
  g.addEdge("EDGE_LINE2D_POINTXY", {1, 0}, {1});
  Values values = g.values();
  try {
    guess(g, values, engine_.registry());
    FAIL() << "found one";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kNoResult);
    EXPECT_NE(std::string(error.what()).find("there is no chordal initial guess"),
              std::string::npos);
  }
}

TEST_F(RelaxationTest, DoesNotDependOnThreads) {
  FactorGraph g(engine_.registry());
  for (int i = 0; i < 200; ++i) g.addVertex("VERTEX_SE3:QUAT", i, numbers(spacePose()));
  for (int i = 0; i < 200; ++i) {
    for (const int j : {(i + 1) % 200, (i + 17) % 200}) {
      g.addEdge("EDGE_SE3:QUAT", {i, j}, numbers(spacePose()), information(6));
    }
  }
  Values first;
  for (const int threads : {1, 2, 5}) {
    SolveOptions options;
    options.initial_guess = InitialGuess::kChordal;
    options.iterations = 0;
    options.threads = threads;
    Values values = g.values();
    optimize(g.graph(), values, engine_.registry(), options);
    if (threads == 1) first = values;
    EXPECT_TRUE(values == first);
  }
}

struct Optimum {
  const char* name;
  double chi2;
  StartKind start;  ///< that auto takes
};

class SharedGraphs : public ::testing::TestWithParam<Optimum> {};

TEST_P(SharedGraphs, LeadToTheReferenceOptimum) {
  const std::string path = std::string("pose_graphs/") + GetParam().name + ".g2o";
  GRAFT_REQUIRE_DATA(path);
  Engine engine;
  for (const InitialGuess wanted : {InitialGuess::kChordal, InitialGuess::kAuto}) {
    LoadedGraph loaded = testing::loadData(path, engine.registry());
    SolveOptions options;
    options.initial_guess = wanted;
    const Summary summary = optimize(loaded.graph, loaded.values, engine.registry(), options);
    EXPECT_NEAR(summary.chi2_final / GetParam().chi2, 1, 1e-6);
    if (wanted == InitialGuess::kAuto) {
      EXPECT_EQ(summary.start, GetParam().start);
      EXPECT_LE(summary.chi2_start, summary.chi2_initial);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, SharedGraphs,
                         ::testing::Values(Optimum{"torus3D", 14574.75, StartKind::kChordal},
                                           Optimum{"sphere2500", 727.1495, StartKind::kChordal},
                                           Optimum{"smallGrid3D", 458.15378, StartKind::kChordal},
                                           Optimum{"MIT", 41.16327, StartKind::kChordal},
                                           Optimum{"M3500", 137.91295, StartKind::kSpanningTree},
                                           Optimum{"intel", 45.00470, StartKind::kGiven},
                                           // Its rotations have no loop: the relaxation is a tree.
                                           Optimum{"dlr", 56860.353, StartKind::kGiven}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace graft
