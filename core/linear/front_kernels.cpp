// SPDX-License-Identifier: BSD-3-Clause
#include "core/linear/front_kernels.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear/symbolic.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace graft {

namespace {

/// Plain loops of fixed length, which compilers turn into whatever vectors the
/// base instruction set has: 4 x 4 numbers are summed in registers.
struct Portable {
  template <bool kOverwrite>
  static void product(int k, const double* a, const double* b, int n, double* c,
                      std::int64_t stride) {
    for (int j = 0; j < n; j += 4) {
      const int width = std::min(4, n - j);
      for (int r = 0; r < kStrip; r += 4) {
        double sums[4][4] = {};
        const double* pa = a + r;
        const double* pb = b + j;
        for (int p = 0; p < k; ++p, pa += kStrip, pb += kStrip) {
          for (int q = 0; q < 4; ++q) {
            for (int i = 0; i < 4; ++i) sums[q][i] += pa[i] * pb[q];
          }
        }
        for (int q = 0; q < width; ++q) {
          double* out = c + (j + q) * stride + r;
          for (int i = 0; i < 4; ++i) out[i] = kOverwrite ? -sums[q][i] : out[i] - sums[q][i];
        }
      }
    }
  }
  static void subtractProduct(int k, const double* a, const double* b, int n, double* c,
                              std::int64_t stride) {
    product<false>(k, a, b, n, c, stride);
  }
  static void negateProduct(int k, const double* a, const double* b, int n, double* c,
                            std::int64_t stride) {
    product<true>(k, a, b, n, c, stride);
  }
  static int factorTile(int n, const double* thresholds, double* tile, double* inverses) {
    for (int j = 0; j < n; ++j) {
      double* column = tile + j * kStrip;
      for (int q = 0; q < j; ++q) {
        const double factor = tile[q * kStrip + j];
        for (int i = 0; i < kStrip; ++i) column[i] -= tile[q * kStrip + i] * factor;
      }
      const double pivot = column[j];
      if (!(pivot > thresholds[j]) || !std::isfinite(pivot)) return j;
      inverses[j] = 1.0 / std::sqrt(pivot);
      for (int i = 0; i < kStrip; ++i) column[i] *= inverses[j];
    }
    return -1;
  }
  static void solveTile(int n, const double* tile, const double* inverses, double* c) {
    for (int j = 0; j < n; ++j) {
      double* x = c + j * kStrip;
      for (int i = 0; i < kStrip; ++i) x[i] *= inverses[j];
      for (int l = j + 1; l < n; ++l) {
        const double factor = tile[j * kStrip + l];
        for (int i = 0; i < kStrip; ++i) c[l * kStrip + i] -= x[i] * factor;
      }
    }
  }
  static void multiply(int k, const double* strip, const double* x, double* sums) {
    double s[kStrip] = {};
    for (int p = 0; p < k; ++p) {
      for (int i = 0; i < kStrip; ++i) s[i] += strip[p * kStrip + i] * x[p];
    }
    std::copy(s, s + kStrip, sums);
  }
  static void subtractTransposed(int k, const double* strip, const double* y, double* x) {
    for (int p = 0; p < k; ++p, strip += kStrip) {
      double s[4] = {};
      for (int r = 0; r < kStrip; r += 4) {
        for (int i = 0; i < 4; ++i) s[i] += strip[r + i] * y[r + i];
      }
      x[p] -= (s[0] + s[1]) + (s[2] + s[3]);
    }
  }
};

constexpr FrontKernels kPortable = {"portable",
                                    &Portable::subtractProduct,
                                    &Portable::negateProduct,
                                    &Portable::factorTile,
                                    &Portable::solveTile,
                                    &Portable::multiply,
                                    &Portable::subtractTransposed};

#if defined(__x86_64__)
#define GRAFT_AVX2 __attribute__((target("avx2,fma")))

/// The same with vectors of four and fused multiply-add: a strip is three vectors.
struct Avx2 {
  /// Adds to one column of a tile; all sums have names, for compilers keep no
  /// array in registers across a loop.
  GRAFT_AVX2 static void finish(double* out, bool overwrite, const __m256d& s0, const __m256d& s1,
                                const __m256d& s2) {
    const __m256d zero = _mm256_setzero_pd();
    _mm256_storeu_pd(out, _mm256_sub_pd(overwrite ? zero : _mm256_loadu_pd(out), s0));
    _mm256_storeu_pd(out + 4, _mm256_sub_pd(overwrite ? zero : _mm256_loadu_pd(out + 4), s1));
    _mm256_storeu_pd(out + 8, _mm256_sub_pd(overwrite ? zero : _mm256_loadu_pd(out + 8), s2));
  }
  template <bool kOverwrite>
  GRAFT_AVX2 static void fourColumns(int k, const double* a, const double* b, double* c,
                                     std::int64_t stride) {
    __m256d s00 = _mm256_setzero_pd(), s01 = s00, s02 = s00;
    __m256d s10 = s00, s11 = s00, s12 = s00;
    __m256d s20 = s00, s21 = s00, s22 = s00;
    __m256d s30 = s00, s31 = s00, s32 = s00;
    for (int p = 0; p < k; ++p, a += kStrip, b += kStrip) {
      const __m256d a0 = _mm256_loadu_pd(a);
      const __m256d a1 = _mm256_loadu_pd(a + 4);
      const __m256d a2 = _mm256_loadu_pd(a + 8);
      __m256d factor = _mm256_broadcast_sd(b);
      s00 = _mm256_fmadd_pd(a0, factor, s00);
      s01 = _mm256_fmadd_pd(a1, factor, s01);
      s02 = _mm256_fmadd_pd(a2, factor, s02);
      factor = _mm256_broadcast_sd(b + 1);
      s10 = _mm256_fmadd_pd(a0, factor, s10);
      s11 = _mm256_fmadd_pd(a1, factor, s11);
      s12 = _mm256_fmadd_pd(a2, factor, s12);
      factor = _mm256_broadcast_sd(b + 2);
      s20 = _mm256_fmadd_pd(a0, factor, s20);
      s21 = _mm256_fmadd_pd(a1, factor, s21);
      s22 = _mm256_fmadd_pd(a2, factor, s22);
      factor = _mm256_broadcast_sd(b + 3);
      s30 = _mm256_fmadd_pd(a0, factor, s30);
      s31 = _mm256_fmadd_pd(a1, factor, s31);
      s32 = _mm256_fmadd_pd(a2, factor, s32);
    }
    finish(c, kOverwrite, s00, s01, s02);
    finish(c + stride, kOverwrite, s10, s11, s12);
    finish(c + 2 * stride, kOverwrite, s20, s21, s22);
    finish(c + 3 * stride, kOverwrite, s30, s31, s32);
  }
  template <bool kOverwrite>
  GRAFT_AVX2 static void oneColumn(int k, const double* a, const double* b, double* c) {
    __m256d s0 = _mm256_setzero_pd(), s1 = s0, s2 = s0;
    for (int p = 0; p < k; ++p, a += kStrip, b += kStrip) {
      const __m256d factor = _mm256_broadcast_sd(b);
      s0 = _mm256_fmadd_pd(_mm256_loadu_pd(a), factor, s0);
      s1 = _mm256_fmadd_pd(_mm256_loadu_pd(a + 4), factor, s1);
      s2 = _mm256_fmadd_pd(_mm256_loadu_pd(a + 8), factor, s2);
    }
    finish(c, kOverwrite, s0, s1, s2);
  }
  template <bool kOverwrite>
  GRAFT_AVX2 static void twoColumns(int k, const double* a, const double* b, double* c,
                                    std::int64_t stride) {
    __m256d s00 = _mm256_setzero_pd(), s01 = s00, s02 = s00;
    __m256d s10 = s00, s11 = s00, s12 = s00;
    for (int p = 0; p < k; ++p, a += kStrip, b += kStrip) {
      const __m256d a0 = _mm256_loadu_pd(a);
      const __m256d a1 = _mm256_loadu_pd(a + 4);
      const __m256d a2 = _mm256_loadu_pd(a + 8);
      __m256d factor = _mm256_broadcast_sd(b);
      s00 = _mm256_fmadd_pd(a0, factor, s00);
      s01 = _mm256_fmadd_pd(a1, factor, s01);
      s02 = _mm256_fmadd_pd(a2, factor, s02);
      factor = _mm256_broadcast_sd(b + 1);
      s10 = _mm256_fmadd_pd(a0, factor, s10);
      s11 = _mm256_fmadd_pd(a1, factor, s11);
      s12 = _mm256_fmadd_pd(a2, factor, s12);
    }
    finish(c, kOverwrite, s00, s01, s02);
    finish(c + stride, kOverwrite, s10, s11, s12);
  }
  template <bool kOverwrite>
  GRAFT_AVX2 static void product(int k, const double* a, const double* b, int n, double* c,
                                 std::int64_t stride) {
    for (; n >= 4; n -= 4, b += 4, c += 4 * stride) fourColumns<kOverwrite>(k, a, b, c, stride);
    for (; n >= 2; n -= 2, b += 2, c += 2 * stride) twoColumns<kOverwrite>(k, a, b, c, stride);
    if (n == 1) oneColumn<kOverwrite>(k, a, b, c);
  }
  GRAFT_AVX2 static void subtractProduct(int k, const double* a, const double* b, int n, double* c,
                                         std::int64_t stride) {
    product<false>(k, a, b, n, c, stride);
  }
  GRAFT_AVX2 static void negateProduct(int k, const double* a, const double* b, int n, double* c,
                                       std::int64_t stride) {
    product<true>(k, a, b, n, c, stride);
  }

  GRAFT_AVX2 static int factorTile(int n, const double* thresholds, double* tile,
                                   double* inverses) {
    for (int j = 0; j < n; ++j) {
      double* column = tile + j * kStrip;
      __m256d c0 = _mm256_loadu_pd(column);
      __m256d c1 = _mm256_loadu_pd(column + 4);
      __m256d c2 = _mm256_loadu_pd(column + 8);
      for (int q = 0; q < j; ++q) {
        const double* other = tile + q * kStrip;
        const __m256d factor = _mm256_broadcast_sd(other + j);
        c0 = _mm256_fnmadd_pd(_mm256_loadu_pd(other), factor, c0);
        c1 = _mm256_fnmadd_pd(_mm256_loadu_pd(other + 4), factor, c1);
        c2 = _mm256_fnmadd_pd(_mm256_loadu_pd(other + 8), factor, c2);
      }
      _mm256_storeu_pd(column, c0);
      _mm256_storeu_pd(column + 4, c1);
      _mm256_storeu_pd(column + 8, c2);
      const double pivot = column[j];
      if (!(pivot > thresholds[j]) || !std::isfinite(pivot)) return j;
      inverses[j] = 1.0 / std::sqrt(pivot);
      const __m256d inverse = _mm256_set1_pd(inverses[j]);
      _mm256_storeu_pd(column, _mm256_mul_pd(c0, inverse));
      _mm256_storeu_pd(column + 4, _mm256_mul_pd(c1, inverse));
      _mm256_storeu_pd(column + 8, _mm256_mul_pd(c2, inverse));
    }
    return -1;
  }

  /// One vector of rows at a time, so that all N columns stay in registers.
  template <int N>
  GRAFT_AVX2 static void solveColumns(const double* tile, const double* inverses, double* c) {
    for (int v = 0; v < kStrip; v += 4) {
      __m256d x[N];
      for (int j = 0; j < N; ++j) x[j] = _mm256_loadu_pd(c + j * kStrip + v);
      for (int j = 0; j < N; ++j) {
        x[j] = _mm256_mul_pd(x[j], _mm256_broadcast_sd(inverses + j));
        for (int l = j + 1; l < N; ++l) {
          x[l] = _mm256_fnmadd_pd(x[j], _mm256_broadcast_sd(tile + j * kStrip + l), x[l]);
        }
      }
      for (int j = 0; j < N; ++j) _mm256_storeu_pd(c + j * kStrip + v, x[j]);
    }
  }
  GRAFT_AVX2 static void solveTile(int n, const double* tile, const double* inverses, double* c) {
    switch (n) {
      case 12:
        return solveColumns<12>(tile, inverses, c);
      case 9:
        return solveColumns<9>(tile, inverses, c);
      case 6:
        return solveColumns<6>(tile, inverses, c);
      case 3:
        return solveColumns<3>(tile, inverses, c);
      default:
        return Portable::solveTile(n, tile, inverses, c);
    }
  }
  GRAFT_AVX2 static void multiply(int k, const double* strip, const double* x, double* sums) {
    __m256d s0 = _mm256_setzero_pd();
    __m256d s1 = s0;
    __m256d s2 = s0;
    for (int p = 0; p < k; ++p, strip += kStrip) {
      const __m256d factor = _mm256_broadcast_sd(x + p);
      s0 = _mm256_fmadd_pd(_mm256_loadu_pd(strip), factor, s0);
      s1 = _mm256_fmadd_pd(_mm256_loadu_pd(strip + 4), factor, s1);
      s2 = _mm256_fmadd_pd(_mm256_loadu_pd(strip + 8), factor, s2);
    }
    _mm256_storeu_pd(sums, s0);
    _mm256_storeu_pd(sums + 4, s1);
    _mm256_storeu_pd(sums + 8, s2);
  }
  GRAFT_AVX2 static void subtractTransposed(int k, const double* strip, const double* y,
                                            double* x) {
    const __m256d y0 = _mm256_loadu_pd(y);
    const __m256d y1 = _mm256_loadu_pd(y + 4);
    const __m256d y2 = _mm256_loadu_pd(y + 8);
    for (int p = 0; p < k; ++p, strip += kStrip) {
      __m256d s = _mm256_mul_pd(_mm256_loadu_pd(strip), y0);
      s = _mm256_fmadd_pd(_mm256_loadu_pd(strip + 4), y1, s);
      s = _mm256_fmadd_pd(_mm256_loadu_pd(strip + 8), y2, s);
      const __m128d pair = _mm_add_pd(_mm256_castpd256_pd128(s), _mm256_extractf128_pd(s, 1));
      x[p] -= _mm_cvtsd_f64(_mm_add_sd(pair, _mm_unpackhi_pd(pair, pair)));
    }
  }
};
#undef GRAFT_AVX2

constexpr FrontKernels kAvx2 = {
    "avx2",           &Avx2::subtractProduct, &Avx2::negateProduct,     &Avx2::factorTile,
    &Avx2::solveTile, &Avx2::multiply,        &Avx2::subtractTransposed};
#endif

}  // namespace

const FrontKernels& portableFrontKernels() { return kPortable; }

bool hasFusedVectors() {
#if defined(__x86_64__)
  static const bool fused = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  return fused;
#else
  return false;
#endif
}

const FrontKernels& frontKernels() {
#if defined(__x86_64__)
  if (hasFusedVectors()) return kAvx2;
#endif
  return kPortable;
}

int factorFront(const FrontKernels& kernels, int columns, int row_strips, const double* thresholds,
                double* strips, double* inverses) {
  const std::int64_t stride = std::int64_t{kStrip} * columns;
  const int strip_count = stripsOf(columns) + row_strips;
  for (int begin = 0, strip = 0; begin < columns; begin += kStrip, ++strip) {
    const int width = std::min(kStrip, columns - begin);
    double* own = strips + strip * stride;
    double* tile = own + begin * kStrip;
    kernels.subtractProduct(begin, own, own, width, tile, kStrip);
    const int bad = kernels.factorTile(width, thresholds + begin, tile, inverses + begin);
    if (bad >= 0) return begin + bad;
    for (int i = strip + 1; i < strip_count; ++i) {
      double* other = strips + i * stride;
      double* c = other + begin * kStrip;
      if (begin > 0) kernels.subtractProduct(begin, other, own, width, c, kStrip);
      kernels.solveTile(width, tile, inverses + begin, c);
    }
  }
  return -1;
}

}  // namespace graft
