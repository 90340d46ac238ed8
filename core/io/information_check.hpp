// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace graft {

/// A matrix whose smallest eigenvalue is above -kSemidefiniteTolerance times the
/// largest in magnitude counts as positive semidefinite: what is below is
/// rounding, of the file's decimals or ours.
constexpr double kSemidefiniteTolerance = 1e-9;

enum class InformationKind { kZero, kSemidefinite, kIndefinite };

/// Judges an n x n symmetric matrix given by its upper triangle, row by row.
/// `smallest` receives the smallest eigenvalue where it is indefinite.
InformationKind judgeInformation(const double* upper, int n, double& smallest);

/// Replaces negative eigenvalues by zero, in place.
void projectInformation(double* upper, int n);

}  // namespace graft
