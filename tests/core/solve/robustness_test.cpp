// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <atomic>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/parallel.hpp"
#include "core/solve/information.hpp"
#include "core/solve/optimizer.hpp"
#include "tests/core/solve/solve_types.hpp"

namespace graft {
namespace {

using testing::assemble;
using testing::makePoseGraph;
using testing::TestGraph;
using testing::testRegistry;

TEST(Information, FactorsWhatIsSemidefinite) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (int dim = 1; dim <= 7; ++dim) {
    for (int rank = 0; rank <= dim; ++rank) {
      const Eigen::MatrixXd half =
          Eigen::MatrixXd::NullaryExpr(rank, dim, [&] { return normal(random); });
      const Eigen::MatrixXd omega = half.transpose() * half;
      std::vector<double> upper;
      for (int r = 0; r < dim; ++r) {
        for (int c = r; c < dim; ++c) upper.push_back(omega(r, c));
      }
      Eigen::MatrixXd root(dim, dim);
      EXPECT_TRUE(factorInformation(upper.data(), dim, root.data()).semidefinite);
      EXPECT_LT((root.transpose() * root - omega).norm(), 1e-12 * (1 + omega.norm()));
    }
  }
}

TEST(Information, FindsIndefiniteOnesBeyondRounding) {
  const double indefinite[] = {1, 2, 1};
  double root[4];
  const InformationFactor factor = factorInformation(indefinite, 2, root);
  EXPECT_FALSE(factor.semidefinite);
  EXPECT_NEAR(factor.smallest_eigenvalue, -1, 1e-12);
  const double rounding[] = {1, 1 + 1e-12, 1};
  EXPECT_TRUE(factorInformation(rounding, 2, root).semidefinite);
  const double negative[] = {-1, 0, 0};
  EXPECT_FALSE(factorInformation(negative, 2, root).semidefinite);
}

TEST(Optimize, RefusesIndefiniteInformationByName) {
  TestGraph g;
  g.point(3, 0, 0);
  g.edge("TEST_PRIOR", {3}, {1, 1}, {1, 2, 1}, 42);
  try {
    optimize(g.graph, g.values, testRegistry());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_EQ(error.where().line, 42);
    const std::string text = error.what();
    EXPECT_NE(text.find("TEST_PRIOR 3"), std::string::npos) << text;
    EXPECT_NE(text.find("eigenvalue"), std::string::npos) << text;
  }
  SolveOptions options;
  options.information = InformationPolicy::kProject;
  const Summary summary = optimize(g.graph, g.values, testRegistry(), options);
  EXPECT_EQ(summary.status, Status::kConverged);
  ASSERT_EQ(summary.notes.size(), 2u);
  EXPECT_NE(summary.notes[0].find("projected"), std::string::npos);
  // [1 2; 2 1] without its negative part resists (1, 1) only.
  EXPECT_NE(summary.notes[1].find("TEST_POINT2 3 is free along"), std::string::npos)
      << summary.notes[1];
}

TEST(Optimize, LeavesDirectionsWithoutInformationAlone) {
  TestGraph g;
  g.point(1, 5, 6);
  g.point(2, 7, 8);
  g.edge("TEST_PRIOR", {1}, {1, 2}, {1, 0, 0});
  g.edge("TEST_PRIOR", {2}, {1, 2}, {0, 0, 0});
  for (const Algorithm algorithm : {Algorithm::kLevenbergMarquardt, Algorithm::kDogleg}) {
    Values values = g.values;
    SolveOptions options;
    options.algorithm = algorithm;
    const Summary summary = optimize(g.graph, values, testRegistry(), options);
    EXPECT_EQ(summary.status, Status::kConverged) << summary.reason;
    EXPECT_NEAR(values.at(g.graph.find(1))[0], 1, 1e-9);
    EXPECT_EQ(values.at(g.graph.find(1))[1], 6);
    EXPECT_EQ(values.at(g.graph.find(2))[0], 7);
  }
  SolveOptions options;
  options.algorithm = Algorithm::kGaussNewton;
  const Values before = g.values;
  const Summary summary = optimize(g.graph, g.values, testRegistry(), options);
  EXPECT_EQ(summary.status, Status::kFailed);
  EXPECT_NE(summary.reason.find("TEST_POINT2"), std::string::npos) << summary.reason;
  EXPECT_TRUE(g.values == before);
}

TEST(Optimize, NamesTheVertexAndWhatIsFreeOfASingularSystem) {
  for (const Algorithm algorithm :
       {Algorithm::kLevenbergMarquardt, Algorithm::kDogleg, Algorithm::kGaussNewton}) {
    TestGraph g;
    g.point(1, 0, 0, true);
    g.point(2, 3, 0);
    g.point(3, 5, 5);
    g.edge("TEST_RANGE", {1, 2}, {2});
    g.edge("TEST_PRIOR", {3}, {1, 1});
    SolveOptions options;
    options.algorithm = algorithm;
    const Summary summary = optimize(g.graph, g.values, testRegistry(), options);
    ASSERT_EQ(summary.notes.size(), 1u) << summary.reason;
    EXPECT_TRUE(summary.notes[0].find("TEST_POINT2 2 is free along (1 y)") != std::string::npos ||
                summary.notes[0].find("TEST_POINT2 2 is free along (-1 y)") != std::string::npos)
        << summary.notes[0];
    const bool undamped = algorithm == Algorithm::kGaussNewton;
    EXPECT_EQ(summary.usable(), !undamped) << summary.reason;
    EXPECT_EQ(summary.reason.find("2 is free along") != std::string::npos, undamped);
    EXPECT_EQ(g.at(2)[1], 0);
  }
}

TEST(Optimize, NamesWhatVerticesCanDoTogetherWhereGaussNewtonFails) {
  TestGraph g;
  g.point(1, 0, 0, true);
  g.point(2, 1, 0);
  g.point(3, 2, 0);
  g.edge("TEST_RANGE", {1, 2}, {1.5});
  g.edge("TEST_DIFFERENCE", {2, 3}, {1, 0});
  SolveOptions options;
  options.algorithm = Algorithm::kGaussNewton;
  const Summary summary = optimize(g.graph, g.values, testRegistry(), options);
  EXPECT_EQ(summary.status, Status::kFailed);
  ASSERT_EQ(summary.notes.size(), 2u);
  for (const std::string& note : summary.notes) {
    EXPECT_NE(note.find("y), together with others"), std::string::npos) << note;
  }
}

TEST(Optimize, SaysNothingWhereEverythingIsDetermined) {
  TestGraph g = assemble(makePoseGraph(20, 0.1, 0.3, 5));
  g.graph.setFixed(g.graph.find(0), true);
  EXPECT_TRUE(optimize(g.graph, g.values, testRegistry()).notes.empty());
}

TEST(Optimize, NamesTheEdgeThatIsNotFinite) {
  struct Case {
    const char* tag;
    const char* what;
  };
  for (const Case c : {Case{"TEST_NAN", "error"}, Case{"TEST_FORGETS", "Jacobian"}}) {
    TestGraph g;
    for (int i = 0; i < 600; ++i) {
      g.point(i, i == 577 ? 6 : 0, 0);
      g.edge(i == 577 || c.what[0] == 'e' ? c.tag : "TEST_PRIOR", {i}, {1, 1}, {}, 1000 + i);
    }
    const Values before = g.values;
    const Summary summary = optimize(g.graph, g.values, testRegistry());
    EXPECT_EQ(summary.status, Status::kFailed);
    EXPECT_FALSE(summary.usable());
    EXPECT_NE(summary.reason.find(std::string(c.tag) + " 577 (line 1577)"), std::string::npos)
        << summary.reason;
    EXPECT_NE(summary.reason.find(c.what), std::string::npos) << summary.reason;
    EXPECT_TRUE(g.values == before);
  }
}

TEST(Optimize, RefusesTrialsThatAreNotFinite) {
  // The minimum at x = 4.9 is overshot by the first step of the range edge.
  for (const Algorithm algorithm :
       {Algorithm::kLevenbergMarquardt, Algorithm::kGaussNewton, Algorithm::kDogleg}) {
    TestGraph g;
    g.point(1, 0.5, 1);
    g.point(2, 0, 0, true);
    g.edge("TEST_RANGE", {1, 2}, {6});
    g.edge("TEST_NAN", {1}, {4.5, 0}, {0.3, 0, 0.3});
    SolveOptions options;
    options.algorithm = algorithm;
    const Summary summary = optimize(g.graph, g.values, testRegistry(), options);
    EXPECT_TRUE(summary.usable()) << summary.reason;
    EXPECT_TRUE(std::isfinite(summary.chi2_final));
    EXPECT_LE(summary.chi2_final, summary.chi2_initial);
    EXPECT_LE(g.at(1)[0], 5);
  }
}

TEST(Optimize, SaysSoWhereAJacobianIsWrong) {
  TestGraph g;
  g.point(1, 3, 3);
  g.edge("TEST_WRONG", {1}, {1, 1});
  const Values before = g.values;
  const Summary summary = optimize(g.graph, g.values, testRegistry());
  EXPECT_EQ(summary.status, Status::kFailed);
  EXPECT_NE(summary.reason.find("Jacobian"), std::string::npos) << summary.reason;
  EXPECT_TRUE(g.values == before);
}

TEST(Optimize, HoldsOneVertexPerComponentWithoutAnchor) {
  TestGraph g;
  g.point(5, 0, 0);
  g.point(3, 1, 1);
  g.edge("TEST_DIFFERENCE", {5, 3}, {1, 0});
  g.point(9, 4, 4);
  g.point(8, 2, 2);
  g.edge("TEST_DIFFERENCE", {9, 8}, {1, 0});
  g.edge("TEST_PRIOR", {9}, {0, 0});
  g.point(11, 2, 2, true);
  g.point(12, 2, 2);
  g.edge("TEST_DIFFERENCE", {11, 12}, {1, 0});
  g.point(20, 6, 7);
  const Summary summary = optimize(g.graph, g.values, testRegistry());
  EXPECT_EQ(summary.status, Status::kConverged);
  ASSERT_EQ(summary.notes.size(), 1u);
  EXPECT_NE(summary.notes[0].find("TEST_POINT2 3 is held"), std::string::npos) << summary.notes[0];
  EXPECT_EQ(g.at(3), (std::vector<double>{1, 1}));
  EXPECT_EQ(g.at(20), (std::vector<double>{6, 7}));
  EXPECT_NEAR(g.at(5)[0], 0, 1e-9);
  EXPECT_NEAR(g.at(8)[0], 1, 1e-9);
  EXPECT_NEAR(g.at(12)[0], 3, 1e-9);
  EXPECT_LT(summary.chi2_final, 1e-15);
}

TEST(Optimize, HasNothingToDoWithoutEdgesOrFreeVertices) {
  TestGraph empty;
  EXPECT_EQ(optimize(empty.graph, empty.values, testRegistry()).status, Status::kConverged);
  TestGraph g;
  g.point(1, 0, 0, true);
  Summary summary = optimize(g.graph, g.values, testRegistry());
  EXPECT_EQ(summary.status, Status::kConverged);
  EXPECT_NE(summary.reason.find("no edges"), std::string::npos);
  g.edge("TEST_PRIOR", {1}, {3, 4});
  summary = optimize(g.graph, g.values, testRegistry());
  EXPECT_EQ(summary.status, Status::kConverged);
  EXPECT_NE(summary.reason.find("fixed"), std::string::npos);
  EXPECT_DOUBLE_EQ(summary.chi2_final, 25);
}

TEST(Optimize, TakesTheEdgesOfOneLevel) {
  TestGraph g;
  g.point(1, 0, 0);
  g.point(2, 5, 5);
  g.edge("TEST_PRIOR", {1}, {1, 2});
  g.edge("TEST_PRIOR", {1}, {3, 4});
  g.edge("TEST_DIFFERENCE", {1, 2}, {1, 1});
  g.graph.setLevel(0, 1, 1);
  g.graph.setLevel(1, 0, 2);
  const auto solve = [&g](std::int32_t level) {
    Values values = g.values;
    SolveOptions options;
    options.level = level;
    const Summary summary = optimize(g.graph, values, testRegistry(), options);
    EXPECT_EQ(summary.status, Status::kConverged);
    EXPECT_NEAR(evaluateChi2(g.graph, values, nullptr, level), summary.chi2_final, 1e-12);
    return values;
  };
  const auto x = [&g](const Values& values, std::int64_t id) {
    return values.at(g.graph.find(id))[0];
  };
  EXPECT_NEAR(x(solve(0), 1), 1, 1e-9);
  // A vertex without an edge of the level stays where it is.
  EXPECT_EQ(x(solve(0), 2), 5);
  EXPECT_NEAR(x(solve(1), 1), 3, 1e-9);
  EXPECT_EQ(x(solve(2), 1), 0);  // held, for nothing else fixes it
  EXPECT_NEAR(x(solve(2), 2), 1, 1e-9);
  EXPECT_NEAR(x(solve(kAllLevels), 1), 2, 1e-9);
  EXPECT_NEAR(x(solve(kAllLevels), 2), 3, 1e-9);
  EXPECT_EQ(solve(7), g.values);  // none has this level
  EXPECT_THROW(g.graph.setLevel(0, 0, -1), Error);
  Graph::EdgeSpec spec;
  spec.type = testRegistry().edge("TEST_PRIOR");
  spec.vertices = {g.graph.find(1)};
  spec.measurement = {0, 0};
  spec.level = -3;
  EXPECT_THROW(g.graph.addEdge(spec), Error);
}

TEST(Optimize, StopsWhenAsked) {
  const auto parts = makePoseGraph(40, 0.1, 0.3, 2);
  SolveOptions options;
  options.iterations = 1;
  TestGraph limited = assemble(parts);
  Summary summary = optimize(limited.graph, limited.values, testRegistry(), options);
  EXPECT_EQ(summary.status, Status::kIterationLimit);
  EXPECT_EQ(summary.iterationCount(), 1);
  EXPECT_NEAR(evaluateChi2(limited.graph, limited.values), summary.chi2_final, 1e-12);

  options = {};
  int calls = 0;
  options.callback = [&](const IterationRecord&, const Values&) { return ++calls < 3; };
  TestGraph called = assemble(parts);
  summary = optimize(called.graph, called.values, testRegistry(), options);
  EXPECT_EQ(summary.status, Status::kInterrupted);
  EXPECT_EQ(summary.iterationCount(), 2);

  options = {};
  const std::atomic<int> interrupt(1);
  options.interrupt = &interrupt;
  TestGraph interrupted = assemble(parts);
  summary = optimize(interrupted.graph, interrupted.values, testRegistry(), options);
  EXPECT_EQ(summary.status, Status::kInterrupted);
  EXPECT_EQ(summary.iterationCount(), 0);

  options = {};
  options.time_limit = 1e-9;
  TestGraph hurried = assemble(parts);
  summary = optimize(hurried.graph, hurried.values, testRegistry(), options);
  EXPECT_EQ(summary.status, Status::kTimeLimit);
}

TEST(Optimize, RefusesBadOptions) {
  TestGraph g;
  const auto expectUsage = [&](const SolveOptions& options, const char* text) {
    try {
      optimize(g.graph, g.values, testRegistry(), options);
      FAIL() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kUsage);
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
  };
  SolveOptions options;
  options.linear_solver = "test_dens";
  expectUsage(options, "test_dense");
  options = {};
  options.iterations = -1;
  expectUsage(options, "iterations");
  options = {};
  options.threads = -2;
  expectUsage(options, "threads");
  options = {};
  options.function_tolerance = std::numeric_limits<double>::quiet_NaN();
  expectUsage(options, "function_tolerance");
  options = {};
  options.association_tolerance = -1;
  expectUsage(options, "association_tolerance");
  options = {};
  options.initial_damping = 0;
  expectUsage(options, "initial_damping");
  options = {};
  options.level = -2;
  expectUsage(options, "level");
  for (const double probability : {0.0, 1.0, std::numeric_limits<double>::quiet_NaN()}) {
    options = {};
    options.graduation.inlier_probability = probability;
    expectUsage(options, "inlier_probability");
  }
}

TEST(ThreadPool, RunsEveryPieceOnceAndPassesOnTheFirstError) {
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    for (int round = 0; round < 50; ++round) {
      std::vector<int> done(97, 0);
      pool.run(97, [&](std::int64_t i) { ++done[std::size_t(i)]; });
      EXPECT_EQ(std::count(done.begin(), done.end(), 1), 97);
    }
    try {
      pool.run(20, [](std::int64_t i) {
        if (i >= 7) throw Error(ExitCode::kInternal, std::to_string(i));
      });
      FAIL();
    } catch (const Error& error) {
      EXPECT_STREQ(error.what(), "7");
    }
  }
}

}  // namespace
}  // namespace graft
