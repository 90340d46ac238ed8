// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "plugins/slam3d/edges.hpp"
#include "tests/support/edge_check.hpp"

namespace graft {
namespace {

using testing::EdgeUnderTest;

class Slam3d : public ::testing::Test {
 protected:
  std::vector<double> randomPose(double extent = 3, double angle = 3) {
    std::normal_distribution<double> number;
    Vec<double, 3> turn(number(random_), number(random_), number(random_));
    turn *= angle * std::uniform_real_distribution<double>(0, 1)(random_) / turn.norm();
    const Pose pose(extent * Vec<double, 3>(number(random_), number(random_), number(random_)),
                    expSO3(turn).normalized());
    std::vector<double> p(7);
    pose.toArray(p.data());
    return p;
  }
  EdgeUnderTest relative() {
    return {&EdgeSe3::descriptor(), {&vertexType<SE3>(), &vertexType<SE3>()}, randomPose(), {}};
  }
  EdgeUnderTest prior() {
    offset_.body_T_sensor = Pose::fromArray(randomPose().data());
    return {&EdgeSe3Prior::descriptor(), {&vertexType<SE3>()}, randomPose(), {&offset_}};
  }
  void expectJacobian(const EdgeUnderTest& edge, const std::vector<std::vector<double>>& x) {
    EXPECT_LT((edge.jacobian(x) - edge.numericJacobian(x)).lpNorm<Eigen::Infinity>(), 1e-7);
  }

  std::mt19937_64 random_{20};
  Se3Offset offset_;
};

TEST_F(Slam3d, JacobiansAreTheDerivatives) {
  for (int i = 0; i < 100; ++i) {
    expectJacobian(relative(), {randomPose(), randomPose()});
    expectJacobian(prior(), {randomPose()});
  }
}

TEST_F(Slam3d, JacobiansNearIdentityAndNearHalfATurn) {
  const std::vector<double> origin = {0, 0, 0, 0, 0, 0, 1};
  for (const double angle : {0.0, 1e-12, 1e-9, 1e-4, 3.0, -3.0, 3.14}) {
    EdgeUnderTest edge = relative();
    edge.measurement = origin;
    const std::vector<double> turned = {1, 2, 3, 0, 0, std::sin(angle / 2), std::cos(angle / 2)};
    expectJacobian(edge, {origin, turned});
    expectJacobian(edge, {turned, origin});
  }
}

TEST_F(Slam3d, ErrorIsG2osByHand) {
  // a at x = 1 turned 90 degrees about z, b at (1, 2, 0) with the same turn: b lies 2 m along
  // a's x axis; measured 1.5 m and a turn of 60 degrees about x.
  const double r = std::sqrt(0.5);
  EdgeUnderTest edge = relative();
  edge.measurement = {1.5, 0, 0, 0.5, 0, 0, std::sqrt(0.75)};
  const Eigen::VectorXd e = edge.error({{1, 0, 0, 0, 0, r, r}, {1, 2, 0, 0, 0, r, r}});
  Eigen::VectorXd expected(6);
  expected << 0.5, 0, 0, -0.5, 0, 0;
  EXPECT_LT((e - expected).lpNorm<Eigen::Infinity>(), 1e-15);
}

TEST_F(Slam3d, PriorMeasuresTheSensor) {
  EdgeUnderTest edge = prior();
  offset_.body_T_sensor = Pose(Vec<double, 3>(0, 0, 1), Eigen::Quaterniond::Identity());
  edge.measurement = {0, 0, 3, 0, 0, 0, 1};
  const Eigen::VectorXd e = edge.error({{1, 0, 0, 0, 0, 0, 1}});
  EXPECT_EQ(e[0], 1);
  EXPECT_EQ(e[2], -2);
}

TEST_F(Slam3d, SignsOfQuaternionsDoNotMatter) {
  for (int i = 0; i < 50; ++i) {
    EdgeUnderTest edge = relative();
    std::vector<std::vector<double>> x = {randomPose(), randomPose()};
    const Eigen::VectorXd e = edge.error(x);
    for (int k = 3; k < 7; ++k) x[0][std::size_t(k)] *= -1;
    EXPECT_EQ(edge.error(x), e);
    for (int k = 3; k < 7; ++k) edge.measurement[std::size_t(k)] *= -1;
    EXPECT_EQ(edge.error(x), e);
  }
}

TEST_F(Slam3d, HalfTurnsAreFiniteAndTheSameForBothSigns) {
  const std::vector<double> origin = {0, 0, 0, 0, 0, 0, 1};
  for (const double w : {0.0, -0.0, 5e-10, -5e-10}) {
    for (const Vec<double, 3>& axis :
         {Vec<double, 3>(1, 0, 0), Vec<double, 3>(0, 0, -1), Vec<double, 3>(-0.6, 0, 0.8)}) {
      EdgeUnderTest edge = relative();
      edge.measurement = origin;
      std::vector<double> turned = {1, 2, 3, axis[0], axis[1], axis[2], w};
      const Eigen::VectorXd e = edge.error({origin, turned});
      const Eigen::MatrixXd j = edge.jacobian({origin, turned});
      EXPECT_NEAR(e.tail<3>().norm(), 1, 1e-12);
      EXPECT_TRUE(j.allFinite());
      for (int k = 3; k < 7; ++k) turned[std::size_t(k)] *= -1;
      EXPECT_EQ(edge.error({origin, turned}), e) << w << ' ' << axis.transpose();
      EXPECT_EQ(edge.jacobian({origin, turned}), j) << w << ' ' << axis.transpose();
    }
  }
}

TEST_F(Slam3d, ManyUpdatesKeepTheQuaternionsLength) {
  const graft_vertex_type& type = vertexType<SE3>();
  std::vector<double> x = randomPose();
  for (int i = 0; i < 10000; ++i) {
    const std::vector<double> step = randomPose(0.1, 1);
    type.plus(1, x.data(), step.data(), x.data());
  }
  EXPECT_NEAR(std::hypot(std::hypot(x[3], x[4]), std::hypot(x[5], x[6])), 1, 1e-12);
}

TEST_F(Slam3d, PropagationMakesTheErrorZero) {
  for (int i = 0; i < 50; ++i) {
    const EdgeUnderTest edge = relative();
    std::vector<std::vector<double>> x = {randomPose(), randomPose()};
    for (const int to : {0, 1}) {
      std::vector<std::vector<double>> y = x;
      y[std::size_t(to)] = edge.propagate(x, to);
      EXPECT_LT(edge.error(y).norm(), 1e-13);
    }
    const EdgeUnderTest anchor = prior();
    EXPECT_LT(anchor.error({anchor.propagate({randomPose()}, 0)}).norm(), 1e-13);
  }
}

TEST_F(Slam3d, ACommonMotionChangesNoRelativeError) {
  for (int i = 0; i < 50; ++i) {
    const EdgeUnderTest edge = relative();
    std::vector<std::vector<double>> x = {randomPose(), randomPose()};
    const Eigen::VectorXd e = edge.error(x);
    const Pose motion = Pose::fromArray(randomPose().data());
    for (std::vector<double>& p : x) (motion * Pose::fromArray(p.data())).toArray(p.data());
    EXPECT_LT((edge.error(x) - e).norm(), 1e-13);
  }
}

TEST(Se3OffsetResource, BadTokensSayWhy) {
  const auto load = [](const std::vector<std::string>& tokens) {
    return ResourceTag<Se3Offset>::load(".", tokens);
  };
  EXPECT_EQ(load({"1", "2", "3", "0", "0", "0", "1"})->body_T_sensor.translation[2], 3);
  EXPECT_THROW(load({"1", "2", "3", "0", "0", "0"}), std::invalid_argument);
  EXPECT_THROW(load({"1", "2", "3", "0", "0", "0", "1", "1"}), std::invalid_argument);
  EXPECT_THROW(load({"1", "2", "nan", "0", "0", "0", "1"}), std::invalid_argument);
  EXPECT_THROW(load({"1", "2", "3x", "0", "0", "0", "1"}), std::invalid_argument);
  EXPECT_THROW(load({"1", "2", "3", "0", "0", "0", "0"}), std::invalid_argument);
  EXPECT_THROW(load({"1", "2", "3", "0", "0", "0", "3"}), std::invalid_argument);
}

}  // namespace
}  // namespace graft
