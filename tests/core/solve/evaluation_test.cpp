// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/evaluation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/solve/optimizer.hpp"
#include "tests/core/solve/solve_types.hpp"
#include "tests/support/derivatives.hpp"

namespace graft {
namespace {

using testing::assemble;
using testing::makePoseGraph;
using testing::riddersJacobian;
using testing::TestGraph;

EvaluationOptions withJacobians() {
  EvaluationOptions options;
  options.jacobians = true;
  return options;
}

TEST(EvaluateEdges, GivesErrorsWhitenedAndWeightedInClosedForm) {
  TestGraph g;
  g.point(1, 0, 0);
  g.point(2, 3, 4, true);
  const std::int32_t kernel = g.graph.addKernel({testing::testRegistry().kernel("cauchy"), 2.0});
  g.edge("TEST_RANGE", {1, 2}, {1}, {9}, 7);                // e = 5 - 1, s = 9 * 16
  g.edge("TEST_PRIOR", {2}, {1, 1}, {4, 2, 2}, 8, kernel);  // e = (2, 3), s = 16 + 24 + 18
  const std::vector<EdgeEvaluation> edges = evaluateEdges(g.graph, g.values, withJacobians());
  ASSERT_EQ(edges.size(), 2u);
  const EdgeEvaluation& prior = edges[0];
  EXPECT_EQ(prior.describe(g.graph), "TEST_PRIOR 2 (line 8)");
  EXPECT_EQ(prior.error, Eigen::Vector2d(2, 3));
  EXPECT_NEAR(prior.squared, 58, 1e-12);
  EXPECT_NEAR(prior.whitened.squaredNorm(), 58, 1e-12);
  // Cauchy: rho = w^2 log(1 + s / w^2), rho' = 1 / (1 + s / w^2).
  EXPECT_NEAR(prior.chi2, 4 * std::log1p(58.0 / 4), 1e-12);
  EXPECT_NEAR(prior.weight, 1 / (1 + 58.0 / 4), 1e-15);
  ASSERT_EQ(prior.jacobians.size(), 1u);
  EXPECT_EQ(prior.jacobians[0], Eigen::Matrix2d::Identity());  // of a fixed vertex, too
  const EdgeEvaluation& range = edges[1];
  EXPECT_EQ(range.line, 7);
  EXPECT_NEAR(range.error[0], 4, 1e-12);
  EXPECT_NEAR(std::abs(range.whitened[0]), 12, 1e-12);
  EXPECT_NEAR(range.chi2, 144, 1e-12);
  EXPECT_EQ(range.weight, 1);
  ASSERT_EQ(range.jacobians.size(), 2u);
  EXPECT_LT((range.jacobians[0] - Eigen::RowVector2d(-0.6, -0.8)).norm(), 1e-12);
  EXPECT_LT((range.jacobians[1] - Eigen::RowVector2d(0.6, 0.8)).norm(), 1e-12);
  EXPECT_TRUE(evaluateEdges(g.graph, g.values)[0].jacobians.empty());
}

/// The estimates moved by a step in the columns of a linearisation.
Values moved(const TestGraph& g, const Linearization& linear, const Eigen::VectorXd& step) {
  Values values = g.values;
  for (std::size_t i = 0; i < linear.vertices.size(); ++i) {
    const VertexRef v = linear.vertices[i];
    g.graph.type(v).plus(1, g.values.at(v), step.data() + linear.columns[i], values.at(v));
  }
  return values;
}

TEST(Linearize, AgreesWithDerivativesByRidders) {
  TestGraph g = assemble(makePoseGraph(6, 0.1, 0.3, 4));
  const Linearization linear = linearize(g.graph, g.values);
  const int n = int(linear.columns.back());
  ASSERT_EQ(n, 6 * 5) << "one of six poses is held";
  ASSERT_EQ(linear.notes.size(), 1u);
  EXPECT_NE(linear.notes[0].find("is held"), std::string::npos);
  EXPECT_NEAR(linear.chi2, evaluateChi2(g.graph, g.values), 1e-12 * linear.chi2);
  EXPECT_NEAR(linear.residual.squaredNorm(), linear.chi2, 1e-12 * linear.chi2);
  const auto residuals = [&](const Eigen::VectorXd& step) {
    return linearize(g.graph, moved(g, linear, step)).residual;
  };
  const Eigen::MatrixXd truth = riddersJacobian(residuals, n, 1e-3);
  EXPECT_LT((Eigen::MatrixXd(linear.jacobian) - truth).lpNorm<Eigen::Infinity>(),
            1e-8 * truth.lpNorm<Eigen::Infinity>());
}

TEST(Linearize, TheGradientIsThatOfChi2UnderRobustKernelsToo) {
  TestGraph g = assemble(makePoseGraph(5, 0.1, 0.3, 9));
  g.graph.setKernel({testing::testRegistry().kernel("cauchy"), 1.5});
  const Linearization linear = linearize(g.graph, g.values);
  const auto chi2 = [&](const Eigen::VectorXd& step) {
    return Eigen::VectorXd::Constant(1, evaluateChi2(g.graph, moved(g, linear, step)));
  };
  const Eigen::MatrixXd truth = riddersJacobian(chi2, int(linear.columns.back()), 1e-3);
  EXPECT_LT((linear.gradient.transpose() - truth).norm(), 1e-8 * truth.norm());
  double sum = 0;
  for (const EdgeEvaluation& edge : evaluateEdges(g.graph, g.values)) sum += edge.chi2;
  EXPECT_NEAR(sum, linear.chi2, 1e-12 * sum);
}

TEST(Linearize, DependsOnTheGraphAlone) {
  auto parts = makePoseGraph(8, 0.1, 0.3, 2);
  const TestGraph a = assemble(parts);
  std::reverse(parts.begin(), parts.end());
  const TestGraph b = assemble(parts);
  const Linearization one = linearize(a.graph, a.values);
  const Linearization other = linearize(b.graph, b.values);
  EXPECT_EQ(one.residual, other.residual);
  EXPECT_EQ(Eigen::MatrixXd(one.jacobian), Eigen::MatrixXd(other.jacobian));
}

TEST(EvaluateEdges, NamesWhatIsNotFinite) {
  TestGraph g;
  g.point(1, 6, 0);
  g.edge("TEST_NAN", {1}, {0, 0}, {}, 12);
  for (const bool jacobians : {false, true}) {
    try {
      evaluateEdges(g.graph, g.values, jacobians ? withJacobians() : EvaluationOptions());
      FAIL();
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ExitCode::kNoResult);
      EXPECT_NE(std::string(e.what()).find("TEST_NAN 1 (line 12)"), std::string::npos) << e.what();
    }
  }
}

TEST(EvaluateEdges, TakesTheEdgesOfOneLevel) {
  TestGraph g;
  g.point(1, 6, 0);
  g.edge("TEST_PRIOR", {1}, {5, 0});
  g.edge("TEST_PRIOR", {1}, {3, 0});
  g.graph.setLevel(0, 1, 2);
  const auto chi2 = [&](std::int32_t level) {
    EvaluationOptions options;
    options.level = level;
    double sum = 0;
    for (const EdgeEvaluation& e : evaluateEdges(g.graph, g.values, options)) sum += e.chi2;
    EXPECT_EQ(linearize(g.graph, g.values, options).chi2, sum);
    return sum;
  };
  EXPECT_EQ(chi2(0), 1);
  EXPECT_EQ(chi2(2), 9);
  EXPECT_EQ(chi2(kAllLevels), 10);
}

TEST(Linearize, OfAGraphWithoutEdgesIsEmpty) {
  TestGraph g;
  g.point(1, 6, 0);
  const Linearization linear = linearize(g.graph, g.values);
  EXPECT_EQ(linear.residual.size(), 0);
  EXPECT_EQ(linear.jacobian.cols(), 0);
  EXPECT_EQ(linear.chi2, 0);
  EXPECT_TRUE(evaluateEdges(g.graph, g.values).empty());
}

}  // namespace
}  // namespace graft
