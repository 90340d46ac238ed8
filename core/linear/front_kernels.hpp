// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace graft {

/// Dense kernels on strips. A strip holds kStrip rows of a front, column after
/// column: entry (r, p) at p * kStrip + r. Rows that fill up the last strip are
/// zero and stay zero. The vector length is chosen once per process.
struct FrontKernels {
  const char* name;
  /// c(:, 0..n) -= a(:, 0..k) b(0..n, 0..k)', n <= kStrip; columns of c are `stride` apart.
  void (*subtractProduct)(int k, const double* a, const double* b, int n, double* c,
                          std::int64_t stride);
  /// c(:, 0..n) = -a(:, 0..k) b(0..n, 0..k)', likewise.
  void (*negateProduct)(int k, const double* a, const double* b, int n, double* c,
                        std::int64_t stride);
  /// Cholesky of the n x n lower triangle of a tile, `inverses` = 1 / diag(L); returns the
  /// first column whose pivot is not above its threshold or not finite, or -1.
  int (*factorTile)(int n, const double* thresholds, double* tile, double* inverses);
  /// c(:, 0..n) = c inv(L)', where L is the lower triangle of the tile and
  /// `inverses` are 1 over its diagonal.
  void (*solveTile)(int n, const double* tile, const double* inverses, double* c);
  /// sums(0..kStrip) = strip(:, 0..k) x.
  void (*multiply)(int k, const double* strip, const double* x, double* sums);
  /// x(0..k) -= strip(:, 0..k)' y.
  void (*subtractTransposed)(int k, const double* strip, const double* y, double* x);
};

/// Whether this processor has the instructions (AVX2, FMA) of the fast kernels.
bool hasFusedVectors();
const FrontKernels& frontKernels();
/// The kernels that every processor has, to test the others against.
const FrontKernels& portableFrontKernels();

/// Factors the leading `columns` of a front that is stored by strips: first those
/// of the columns' own rows, then `row_strips` more. Afterwards they hold L.
/// `inverses` receives 1 / diag(L). A pivot that is not above thresholds[c] ends
/// it: returns that column, else -1.
int factorFront(const FrontKernels& kernels, int columns, int row_strips, const double* thresholds,
                double* strips, double* inverses);

}  // namespace graft
