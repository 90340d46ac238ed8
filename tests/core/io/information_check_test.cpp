// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/information_check.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace graft {
namespace {

std::vector<double> upperOf(const Eigen::MatrixXd& m) {
  std::vector<double> upper;
  for (Eigen::Index r = 0; r < m.rows(); ++r) {
    for (Eigen::Index c = r; c < m.cols(); ++c) upper.push_back(m(r, c));
  }
  return upper;
}

/// A symmetric matrix with chosen eigenvalues and random eigenvectors.
Eigen::MatrixXd withEigenvalues(const Eigen::VectorXd& values, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto n = values.size();
  const Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return number(random); });
  const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(a).householderQ();
  const Eigen::MatrixXd m = q * values.asDiagonal() * q.transpose();
  return 0.5 * (m + m.transpose());
}

TEST(InformationCheck, SmallestEigenvalueOfAnIndefiniteMatrix) {
  for (const int n : {2, 3, 6, 15}) {
    Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(n, -0.25, 4.0);
    double smallest = 0;
    EXPECT_EQ(judgeInformation(upperOf(withEigenvalues(values, 7)).data(), n, smallest),
              InformationKind::kIndefinite);
    EXPECT_NEAR(smallest, -0.25, 1e-12);
  }
}

TEST(InformationCheck, SingularIsSemidefiniteAndRoundingIsForgiven) {
  double smallest = 0;
  Eigen::VectorXd values(6);
  values << 0, 0, 0, 1, 2, 3;
  EXPECT_EQ(judgeInformation(upperOf(withEigenvalues(values, 3)).data(), 6, smallest),
            InformationKind::kSemidefinite);
  values[0] = -0.5 * kSemidefiniteTolerance * 3;
  EXPECT_EQ(judgeInformation(upperOf(withEigenvalues(values, 3)).data(), 6, smallest),
            InformationKind::kSemidefinite);
  values[0] = -2 * kSemidefiniteTolerance * 3;
  EXPECT_EQ(judgeInformation(upperOf(withEigenvalues(values, 3)).data(), 6, smallest),
            InformationKind::kIndefinite);
}

TEST(InformationCheck, ScaleDoesNotMatter) {
  Eigen::VectorXd values(3);
  values << -1, 2, 3;
  for (const double scale : {1e-290, 1e-20, 1.0, 1e20, 1e290}) {
    double smallest = 0;
    const std::vector<double> bad = upperOf(scale * withEigenvalues(values, 5));
    EXPECT_EQ(judgeInformation(bad.data(), 3, smallest), InformationKind::kIndefinite);
    EXPECT_NEAR(smallest / scale, -1, 1e-12);
    const std::vector<double> good = upperOf(scale * withEigenvalues(values.cwiseAbs(), 5));
    EXPECT_EQ(judgeInformation(good.data(), 3, smallest), InformationKind::kSemidefinite);
  }
}

TEST(InformationCheck, ZeroIsToldApart) {
  const std::vector<double> zeros(21, 0.0);
  double smallest = 0;
  EXPECT_EQ(judgeInformation(zeros.data(), 6, smallest), InformationKind::kZero);
}

TEST(InformationCheck, ProjectionKeepsThePositivePart) {
  Eigen::VectorXd values(4);
  values << -2, -0.1, 1, 5;
  std::vector<double> upper = upperOf(withEigenvalues(values, 11));
  projectInformation(upper.data(), 4);
  const std::vector<double> expected = upperOf(withEigenvalues(values.cwiseMax(0.0), 11));
  for (std::size_t i = 0; i < upper.size(); ++i) EXPECT_NEAR(upper[i], expected[i], 1e-13);
}

}  // namespace
}  // namespace graft
