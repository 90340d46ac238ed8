// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/information.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace graft {
namespace {

Eigen::MatrixXd randomMatrix(int rows, int columns, std::mt19937_64& random) {
  Eigen::MatrixXd m(rows, columns);
  for (int i = 0; i < m.size(); ++i) {
    m.data()[i] = 2 * static_cast<double>(random() >> 11) * 0x1p-53 - 1;
  }
  return m;
}

/// S of the matrix with this upper triangle.
Eigen::MatrixXd rootOf(const Eigen::MatrixXd& omega, InformationFactor& found) {
  std::vector<double> upper;
  for (int r = 0; r < omega.rows(); ++r) {
    for (int c = r; c < omega.cols(); ++c) upper.push_back(omega(r, c));
  }
  Eigen::MatrixXd root = Eigen::MatrixXd::Constant(omega.rows(), omega.cols(), 1e300);
  found = factorInformation(upper.data(), static_cast<int>(omega.rows()), root.data());
  return root;
}

TEST(FactorInformation, IsCholeskysFactorOfADefiniteMatrix) {
  std::mt19937_64 random(1);
  for (int dim = 1; dim <= 9; ++dim) {
    for (int trial = 0; trial < 20; ++trial) {
      const Eigen::MatrixXd a = randomMatrix(dim, dim + 2, random);
      const Eigen::MatrixXd omega = a * a.transpose();
      InformationFactor found;
      const Eigen::MatrixXd root = rootOf(omega, found);
      EXPECT_TRUE(found.semidefinite);
      const Eigen::MatrixXd expected = omega.llt().matrixU();
      EXPECT_LT((root - expected).norm(), 1e-9 * expected.norm()) << dim;
    }
  }
}

TEST(FactorInformation, TakesEveryRank) {
  std::mt19937_64 random(2);
  for (int dim = 1; dim <= 7; ++dim) {
    for (int rank = 0; rank < dim; ++rank) {
      const Eigen::MatrixXd a = randomMatrix(dim, rank, random);
      const Eigen::MatrixXd omega = a * a.transpose();
      InformationFactor found;
      const Eigen::MatrixXd root = rootOf(omega, found);
      EXPECT_TRUE(found.semidefinite) << dim << " " << rank;
      EXPECT_LT((root.transpose() * root - omega).norm(), 1e-8 * (1 + omega.norm())) << dim;
    }
  }
}

TEST(FactorInformation, TakesTheNearestSemidefiniteOfAnIndefinite) {
  std::mt19937_64 random(3);
  for (int dim = 2; dim <= 7; ++dim) {
    const Eigen::MatrixXd turn = randomMatrix(dim, dim, random).householderQr().householderQ();
    Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(dim, -2, 3);
    InformationFactor found;
    const Eigen::MatrixXd root = rootOf(turn * values.asDiagonal() * turn.transpose(), found);
    EXPECT_FALSE(found.semidefinite);
    EXPECT_NEAR(found.smallest_eigenvalue, -2, 1e-9);
    const Eigen::MatrixXd nearest = turn * values.cwiseMax(0).asDiagonal() * turn.transpose();
    EXPECT_LT((root.transpose() * root - nearest).norm(), 1e-8) << dim;
  }
}

}  // namespace
}  // namespace graft
