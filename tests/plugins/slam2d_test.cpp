// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "plugins/slam2d/edges.hpp"
#include "plugins/slam2d/landmarks.hpp"
#include "tests/support/edge_check.hpp"

namespace graft {
namespace {

using testing::EdgeUnderTest;

constexpr double kPi = 3.14159265358979323846;

class Slam2d : public ::testing::Test {
 protected:
  double number(double extent) {
    return std::uniform_real_distribution<double>(-extent, extent)(random_);
  }
  std::vector<double> pose() { return {number(5), number(5), number(3)}; }
  std::vector<double> point() { return {number(5), number(5)}; }
  EdgeUnderTest relative() {
    return {&EdgeSe2::descriptor(), {&vertexType<SE2>(), &vertexType<SE2>()}, pose(), {}};
  }
  EdgeUnderTest sight() {
    return {&EdgeSe2Xy::descriptor(), {&vertexType<SE2>(), &vertexType<Point2>()}, point(), {}};
  }
  EdgeUnderTest prior() { return {&EdgePriorSe2::descriptor(), {&vertexType<SE2>()}, pose(), {}}; }
  std::mt19937_64 random_{21};
};

TEST_F(Slam2d, JacobiansAreTheDerivatives) {
  const auto expectJacobian = [](const EdgeUnderTest& edge,
                                 const std::vector<std::vector<double>>& x) {
    // Where the angle of the error jumps from pi to -pi there is no derivative.
    const Eigen::VectorXd e = edge.error(x);
    if (e.size() == 3 && std::abs(e[2]) > 3.0) return;
    EXPECT_LT((edge.jacobian(x) - edge.numericJacobian(x)).lpNorm<Eigen::Infinity>(), 1e-8);
  };
  for (int i = 0; i < 200; ++i) {
    expectJacobian(relative(), {pose(), pose()});
    expectJacobian(sight(), {pose(), point()});
    expectJacobian(prior(), {pose()});
  }
}

TEST_F(Slam2d, ErrorsByHand) {
  EdgeUnderTest edge = relative();
  edge.measurement = {1, 0, kPi / 2};
  // b is 2 m ahead of a, which looks along y, and looks back along -x.
  const Eigen::VectorXd e = edge.error({{1, 1, kPi / 2}, {1, 3, kPi}});
  EXPECT_NEAR(e[0], 0, 1e-15);
  EXPECT_NEAR(e[1], -1, 1e-15);
  EXPECT_NEAR(e[2], 0, 1e-15);
  EdgeUnderTest seen = sight();
  seen.measurement = {2, 0.5};
  const Eigen::VectorXd s = seen.error({{1, 1, kPi / 2}, {1, 3}});
  EXPECT_NEAR(s[0], 0, 1e-15);
  EXPECT_NEAR(s[1], -0.5, 1e-15);
}

TEST_F(Slam2d, AnglesOfManyTurnsAreTheSameErrors) {
  EdgeUnderTest edge = relative();
  edge.measurement = {1, 0, 0};
  const Eigen::VectorXd e = edge.error({{0, 0, 0}, {2, 0, 0.25}});
  const Eigen::VectorXd turned = edge.error({{0, 0, 2 * kPi * 1000}, {2, 0, 0.25 - 2 * kPi * 500}});
  EXPECT_LT((e - turned).norm(), 1e-11);
}

TEST_F(Slam2d, PropagationMakesTheErrorZero) {
  for (int i = 0; i < 50; ++i) {
    const EdgeUnderTest edge = relative();
    const std::vector<std::vector<double>> x = {pose(), pose()};
    EXPECT_LT(edge.error({edge.propagate(x, 0), x[1]}).norm(), 1e-13);
    EXPECT_LT(edge.error({x[0], edge.propagate(x, 1)}).norm(), 1e-13);
    const EdgeUnderTest seen = sight();
    EXPECT_LT(seen.error({x[0], seen.propagate({x[0], point()}, 1)}).norm(), 1e-13);
    EXPECT_TRUE(seen.propagate({x[0], point()}, 0).empty());
    const EdgeUnderTest anchor = prior();
    EXPECT_LT(anchor.error({anchor.propagate({x[0]}, 0)}).norm(), 1e-13);
  }
}

}  // namespace
}  // namespace graft
