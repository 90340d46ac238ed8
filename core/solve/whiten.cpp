// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/whiten.hpp"

namespace graft {

namespace {

/// The product with a dense root; D > 0 fixes the dimension at compile time.
template <int D>
void whitenDense(const double* root, int dim, int columns, double scale, const double* jacobian,
                 double* out) {
  const int n = D > 0 ? D : dim;
  for (int c = 0; c < columns; ++c) {
    const double* column = jacobian + c * n;
    for (int r = 0; r < n; ++r) {
      double sum = 0;
      for (int k = 0; k < n; ++k) sum += root[k * n + r] * column[k];
      out[r * columns + c] = scale * sum;
    }
  }
}

}  // namespace

void whitenError(const double* root, RootShape shape, int dim, const double* e, double* r) {
  if (shape == RootShape::kDense) {
    for (int i = 0; i < dim; ++i) r[i] = 0;
    for (int k = 0; k < dim; ++k) {
      for (int i = 0; i < dim; ++i) r[i] += root[k * dim + i] * e[k];
    }
    return;
  }
  for (int i = 0; i < dim; ++i) r[i] = root[i * dim + i] * e[i];
}

void whitenJacobian(const double* root, RootShape shape, int dim, int columns, double scale,
                    const double* jacobian, double* out) {
  if (shape != RootShape::kDense) {
    for (int r = 0; r < dim; ++r) {
      const double factor = scale * root[r * dim + r];
      for (int c = 0; c < columns; ++c) out[r * columns + c] = factor * jacobian[c * dim + r];
    }
    return;
  }
  switch (dim) {
    case 1:
      return whitenDense<1>(root, dim, columns, scale, jacobian, out);
    case 2:
      return whitenDense<2>(root, dim, columns, scale, jacobian, out);
    case 3:
      return whitenDense<3>(root, dim, columns, scale, jacobian, out);
    case 6:
      return whitenDense<6>(root, dim, columns, scale, jacobian, out);
    default:
      return whitenDense<0>(root, dim, columns, scale, jacobian, out);
  }
}

}  // namespace graft
