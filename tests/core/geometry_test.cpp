// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "core/geometry/se2.hpp"
#include "core/geometry/se3.hpp"
#include "tests/support/derivatives.hpp"

namespace graft {
namespace {

constexpr double kPi = 3.14159265358979323846;

class Geometry : public ::testing::Test {
 protected:
  Vec<double, 3> randomVector(double scale) {
    std::normal_distribution<double> normal;
    return scale * Vec<double, 3>(normal(random_), normal(random_), normal(random_));
  }
  Pose randomPose(double angle) {
    return Pose(randomVector(2.0), expSO3<double>(angle * randomVector(1.0).normalized()));
  }
  std::mt19937_64 random_{7};
};

TEST_F(Geometry, LogInvertsExpAtEveryAngle) {
  for (const double angle : {0.0, 1e-12, 1e-8, 1e-5, 1.1e-5, 0.1, 1.0, 3.0, kPi - 1e-9}) {
    const Vec<double, 3> phi = angle * randomVector(1.0).normalized();
    EXPECT_LT((logSO3(expSO3<double>(phi)) - phi).norm(), 1e-14 + 1e-15 * angle) << angle;
  }
}

TEST_F(Geometry, LogIgnoresTheSignOfTheQuaternion) {
  const Eigen::Quaterniond q = expSO3<double>(randomVector(0.7));
  const Eigen::Quaterniond minus(-q.w(), -q.x(), -q.y(), -q.z());
  EXPECT_EQ(logSO3(q), logSO3(minus));
  // Half turns, where w says nothing.
  EXPECT_EQ(logSO3(Eigen::Quaterniond(0, 0, -0.6, 0.8)),
            logSO3(Eigen::Quaterniond(-0.0, 0, 0.6, -0.8)));
}

TEST_F(Geometry, PlusAndMinusAreInverse) {
  for (int i = 0; i < 100; ++i) {
    const Pose a = randomPose(2.5);
    const Pose b = randomPose(2.5);
    const Pose c = a.plus(b.minus(a));
    EXPECT_LT(poseError(b.inverse() * c).norm(), 1e-13);
    const Pose2 p(1, 2, 3);
    const Pose2 q(-1, 0.5, -3);
    EXPECT_LT(poseError(q.inverse() * p.plus(q.minus(p))).norm(), 1e-14);
  }
}

TEST_F(Geometry, InverseRightJacobianMatchesRidders) {
  for (const double angle : {0.0, 1e-4, 0.3, 1.5, 3.0}) {
    const Vec<double, 3> phi = angle * randomVector(1.0).normalized();
    const Eigen::MatrixXd numeric = testing::riddersJacobian(
        [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
          return logSO3(Eigen::Quaterniond(expSO3<double>(phi) * expSO3<double>(d)));
        },
        3);
    EXPECT_LT((inverseRightJacobianSO3(phi) - numeric).norm(), 1e-8) << angle;
  }
}

TEST_F(Geometry, DualDerivativeOfThePoseErrorMatchesRidders) {
  using D = Dual<6>;
  for (const double angle : {0.0, 1e-6, 0.5, 2.9}) {
    const Pose x = randomPose(angle);
    const Pose z(randomVector(1.0), Eigen::Quaterniond::Identity());
    const auto f = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return poseError(z.inverse() * x.plus(d));
    };
    double numbers[7];
    x.toArray(numbers);
    double measured[7];
    z.toArray(measured);
    Vec<D, 6> delta;
    for (int i = 0; i < 6; ++i) delta[i] = D::variable(0, i);
    const Vec<D, 6> e =
        poseError(SE3<D>::fromArray(measured).inverse() * SE3<D>::fromArray(numbers).plus(delta));
    const Eigen::MatrixXd numeric = testing::riddersJacobian(f, 6);
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c < 6; ++c) EXPECT_NEAR(e[r].d[c], numeric(r, c), 1e-8) << angle;
    }
  }
}

TEST(Interpolate, HitsTheEndsAndTakesTheShorterArc) {
  const Pose a(Vec<double, 3>(0, 0, 0), expSO3<double>(Vec<double, 3>(0, 0, 0.2)));
  Pose b(Vec<double, 3>(1, 2, 3), expSO3<double>(Vec<double, 3>(0, 0, 1.2)));
  b.rotation.coeffs() *= -1;
  EXPECT_LT(poseError(a.inverse() * interpolate(a, b, 0)).norm(), 1e-15);
  EXPECT_LT(poseError(b.inverse() * interpolate(a, b, 1)).norm(), 1e-15);
  const Pose middle = interpolate(a, b, 0.25);
  EXPECT_LT((middle.translation - Vec<double, 3>(0.25, 0.5, 0.75)).norm(), 1e-15);
  EXPECT_NEAR(logSO3(middle.rotation)[2], 0.45, 1e-14);
}

TEST(WrapAngle, IsExactInsideAndStaysOutOfMinusPi) {
  EXPECT_EQ(wrapAngle(kPi), kPi);
  EXPECT_EQ(wrapAngle(0.3), 0.3);
  EXPECT_NEAR(wrapAngle(-kPi - 0.1), kPi - 0.1, 1e-15);
  EXPECT_NEAR(wrapAngle(1e9), std::remainder(1e9, 2 * kPi), 1e-6);
}

TEST(NormalizeQuaternion, IsIdempotentToTheBit) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 100000; ++i) {
    double q[4] = {uniform(random), uniform(random), uniform(random), uniform(random)};
    if (!normalizeQuaternion(q)) continue;
    const double once[4] = {q[0], q[1], q[2], q[3]};
    ASSERT_TRUE(normalizeQuaternion(q));
    for (int k = 0; k < 4; ++k) ASSERT_EQ(q[k], once[k]);
  }
  double zero[4] = {0, 0, 0, 0};
  EXPECT_FALSE(normalizeQuaternion(zero));
}

TEST(Dual, TheDirectionOfNothingHasNoDerivative) {
  const Dual<2> angle = atan2(Dual<2>::variable(0, 0), Dual<2>::variable(0, 1));
  EXPECT_EQ(angle.v, 0);
  EXPECT_EQ(angle.d[0], 0);
  EXPECT_EQ(angle.d[1], 0);
}

}  // namespace
}  // namespace graft
