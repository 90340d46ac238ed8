// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/solve/problem.hpp"

namespace graft {

/// r = S e for one edge. `e` may not be `r`.
void whitenError(const double* root, RootShape shape, int dim, const double* e, double* r);

/// out (row-major, dim x columns) = scale * S * J (column-major, dim x columns).
void whitenJacobian(const double* root, RootShape shape, int dim, int columns, double scale,
                    const double* jacobian, double* out);

}  // namespace graft
