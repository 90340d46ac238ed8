// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace graft {

/// out (rows x columns, column-major) += A' B of two groups of columns of one row-major
/// matrix of `errors` rows, `stride` numbers apart: a and b point at their first rows.
using BlockProduct = void (*)(const double* a, const double* b, int errors, int rows, int columns,
                              int stride, double* out);

/// The fastest that this processor has for these dimensions.
BlockProduct blockProduct(int errors, int rows, int columns);
/// The one that every processor has, to test the others against.
BlockProduct portableBlockProduct(int errors, int rows, int columns);

}  // namespace graft
