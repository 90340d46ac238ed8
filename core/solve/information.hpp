// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace graft {

/// What factorInformation() found.
struct InformationFactor {
  bool semidefinite = true;
  double smallest_eigenvalue = 0;  ///< only set where the matrix was not definite
};

/// Eigenvalues down to -kInformationTolerance times the largest magnitude are
/// rounding (matrices are written with few digits) and count as zero.
constexpr double kInformationTolerance = 1e-9;

/// The square root S of an information matrix, Omega = S' S, so that the squared
/// length of S e is e' Omega e. `upper`: upper triangle of Omega row by row;
/// `root` receives S, dim x dim, column-major. Cholesky factor where Omega is
/// positive definite; diag(sqrt(eigenvalues)) times eigenvectors where it is
/// semidefinite (rank 0 included). Where it is indefinite the result says so and
/// S is the root of the nearest semidefinite matrix.
InformationFactor factorInformation(const double* upper, int dim, double* root);

}  // namespace graft
