// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/information.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace graft {

namespace {

/// S = U of Omega = U' U; false where a pivot is not clearly positive.
bool factorDefinite(const double* upper, int dim, double* root) {
  const double* row = upper;
  for (int i = 0; i < dim; row += dim - i, ++i) {
    double pivot = row[0];
    for (int k = 0; k < i; ++k) pivot -= root[i * dim + k] * root[i * dim + k];
    if (!(pivot > 1e-12 * row[0])) return false;
    const double diagonal = std::sqrt(pivot);
    root[i * dim + i] = diagonal;
    for (int j = i + 1; j < dim; ++j) {
      double entry = row[j - i];
      for (int k = 0; k < i; ++k) entry -= root[i * dim + k] * root[j * dim + k];
      root[j * dim + i] = entry / diagonal;
    }
  }
  return true;
}

}  // namespace

InformationFactor factorInformation(const double* upper, int dim, double* root) {
  const std::size_t size = std::size_t(dim) * std::size_t(dim);
  std::fill(root, root + size, 0.0);
  if (factorDefinite(upper, dim, root)) return {};
  Eigen::MatrixXd omega(dim, dim);
  for (int r = 0; r < dim; ++r) {
    for (int c = r; c < dim; ++c) omega(r, c) = omega(c, r) = *upper++;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(omega);
  const Eigen::VectorXd& values = eigen.eigenvalues();
  InformationFactor result;
  result.smallest_eigenvalue = values[0];
  result.semidefinite = values[0] >= -kInformationTolerance * values.cwiseAbs().maxCoeff();
  Eigen::Map<Eigen::MatrixXd>(root, dim, dim) =
      values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
  return result;
}

}  // namespace graft
