// SPDX-License-Identifier: BSD-3-Clause
#include "core/linear/block_product.hpp"

#include "core/linear/front_kernels.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace graft {

namespace {

/// E, A, B > 0 fix the dimensions at compile time.
template <int E, int A, int B>
void addProduct(const double* a, const double* b, int errors, int rows, int columns, int stride,
                double* out) {
  const int ne = E > 0 ? E : errors;
  const int na = A > 0 ? A : rows;
  const int nb = B > 0 ? B : columns;
  for (int j = 0; j < nb; ++j) {
    double* column = out + j * na;
    for (int e = 0; e < ne; ++e) {
      const double factor = b[e * stride + j];
      for (int i = 0; i < na; ++i) column[i] += a[e * stride + i] * factor;
    }
  }
}

#if defined(__x86_64__)
/// 6 x 6 with vectors of four: nine of them hold the whole block, of which every second
/// has the end of one column and the beginning of the next.
__attribute__((target("avx2,fma"))) void addPoseProduct(const double* a, const double* b,
                                                        int errors, int /*rows*/, int /*columns*/,
                                                        int stride, double* out) {
  __m256d s0 = _mm256_loadu_pd(out), s1 = _mm256_loadu_pd(out + 4);
  __m256d s2 = _mm256_loadu_pd(out + 8), s3 = _mm256_loadu_pd(out + 12);
  __m256d s4 = _mm256_loadu_pd(out + 16), s5 = _mm256_loadu_pd(out + 20);
  __m256d s6 = _mm256_loadu_pd(out + 24), s7 = _mm256_loadu_pd(out + 28);
  __m256d s8 = _mm256_loadu_pd(out + 32);
  for (int e = 0; e < errors; ++e, a += stride, b += stride) {
    const __m256d head = _mm256_loadu_pd(a);
    const __m256d tail = _mm256_loadu_pd(a + 2);
    const __m256d seam = _mm256_permute2f128_pd(tail, head, 0x21);
    __m256d left = _mm256_broadcast_sd(b);
    __m256d right = _mm256_broadcast_sd(b + 1);
    s0 = _mm256_fmadd_pd(head, left, s0);
    s1 = _mm256_fmadd_pd(seam, _mm256_blend_pd(left, right, 0xc), s1);
    s2 = _mm256_fmadd_pd(tail, right, s2);
    left = _mm256_broadcast_sd(b + 2);
    right = _mm256_broadcast_sd(b + 3);
    s3 = _mm256_fmadd_pd(head, left, s3);
    s4 = _mm256_fmadd_pd(seam, _mm256_blend_pd(left, right, 0xc), s4);
    s5 = _mm256_fmadd_pd(tail, right, s5);
    left = _mm256_broadcast_sd(b + 4);
    right = _mm256_broadcast_sd(b + 5);
    s6 = _mm256_fmadd_pd(head, left, s6);
    s7 = _mm256_fmadd_pd(seam, _mm256_blend_pd(left, right, 0xc), s7);
    s8 = _mm256_fmadd_pd(tail, right, s8);
  }
  _mm256_storeu_pd(out, s0);
  _mm256_storeu_pd(out + 4, s1);
  _mm256_storeu_pd(out + 8, s2);
  _mm256_storeu_pd(out + 12, s3);
  _mm256_storeu_pd(out + 16, s4);
  _mm256_storeu_pd(out + 20, s5);
  _mm256_storeu_pd(out + 24, s6);
  _mm256_storeu_pd(out + 28, s7);
  _mm256_storeu_pd(out + 32, s8);
}
#endif

}  // namespace

BlockProduct portableBlockProduct(int e, int a, int b) {
  const int key = e < 10 && a < 10 && b < 10 ? e * 100 + a * 10 + b : 0;
  switch (key) {
    case 666:
      return &addProduct<6, 6, 6>;
    case 333:
      return &addProduct<3, 3, 3>;
    case 332:
      return &addProduct<3, 3, 2>;
    case 323:
      return &addProduct<3, 2, 3>;
    case 322:
      return &addProduct<3, 2, 2>;
    case 233:
      return &addProduct<2, 3, 3>;
    case 232:
      return &addProduct<2, 3, 2>;
    case 223:
      return &addProduct<2, 2, 3>;
    case 222:
      return &addProduct<2, 2, 2>;
    case 366:
      return &addProduct<3, 6, 6>;
    case 363:
      return &addProduct<3, 6, 3>;
    case 336:
      return &addProduct<3, 3, 6>;
    case 663:
      return &addProduct<6, 6, 3>;
    case 636:
      return &addProduct<6, 3, 6>;
    case 633:
      return &addProduct<6, 3, 3>;
    default:
      return &addProduct<0, 0, 0>;
  }
}

BlockProduct blockProduct(int errors, int rows, int columns) {
#if defined(__x86_64__)
  if (hasFusedVectors() && rows == 6 && columns == 6) return &addPoseProduct;
#endif
  return portableBlockProduct(errors, rows, columns);
}

}  // namespace graft
