// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/information_check.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace graft {

namespace {

double largestEntry(const double* upper, int n) {
  double largest = 0;
  const int count = n * (n + 1) / 2;
  for (int i = 0; i < count; ++i) largest = std::max(largest, std::abs(upper[i]));
  return largest;
}

Eigen::MatrixXd expand(const double* upper, int n, double scale) {
  Eigen::MatrixXd matrix(n, n);
  for (int r = 0; r < n; ++r) {
    for (int c = r; c < n; ++c) matrix(r, c) = matrix(c, r) = *upper++ * scale;
  }
  return matrix;
}

/// Plain Cholesky of the scaled matrix: nearly every matrix of a file passes
/// this, at a fraction of the cost of eigenvalues.
template <int Capacity>
bool isClearlyPositive(const double* upper, int n, double scale) {
  double factor[Capacity][Capacity];
  for (int r = 0; r < n; ++r) {
    for (int c = r; c < n; ++c) factor[c][r] = *upper++ * scale;
  }
  for (int k = 0; k < n; ++k) {
    double pivot = factor[k][k];
    for (int j = 0; j < k; ++j) pivot -= factor[k][j] * factor[k][j];
    if (!(pivot > 0)) return false;
    const double root = std::sqrt(pivot);
    factor[k][k] = root;
    for (int i = k + 1; i < n; ++i) {
      double sum = factor[i][k];
      for (int j = 0; j < k; ++j) sum -= factor[i][j] * factor[k][j];
      factor[i][k] = sum / root;
    }
  }
  return true;
}

}  // namespace

InformationKind judgeInformation(const double* upper, int n, double& smallest) {
  smallest = 0;
  const double largest = largestEntry(upper, n);
  if (largest == 0) return InformationKind::kZero;
  const double scale = 1.0 / largest;
  // 1 / (a denormal) is infinite.
  if (!std::isfinite(scale)) return InformationKind::kSemidefinite;
  if (n <= 12 && isClearlyPositive<12>(upper, n, scale)) return InformationKind::kSemidefinite;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(expand(upper, n, scale),
                                                              Eigen::EigenvaluesOnly);
  const Eigen::VectorXd& values = solver.eigenvalues();
  if (values[0] >= -kSemidefiniteTolerance * values.cwiseAbs().maxCoeff()) {
    return InformationKind::kSemidefinite;
  }
  smallest = values[0] * largest;
  return InformationKind::kIndefinite;
}

void projectInformation(double* upper, int n) {
  const double largest = largestEntry(upper, n);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(expand(upper, n, 1.0 / largest));
  const Eigen::VectorXd clipped = solver.eigenvalues().cwiseMax(0.0) * largest;
  const Eigen::MatrixXd& vectors = solver.eigenvectors();
  const Eigen::MatrixXd projected = vectors * clipped.asDiagonal() * vectors.transpose();
  for (int r = 0; r < n; ++r) {
    for (int c = r; c < n; ++c) *upper++ = projected(r, c);
  }
}

}  // namespace graft
