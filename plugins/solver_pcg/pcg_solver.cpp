// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/solver_pcg/pcg_solver.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace graft {

namespace {

constexpr double kTolerance = 1e-10;
constexpr double kLeastReduction = 1e-6;
constexpr int kMostIterations = 5000;
/// How often the diagonal is raised, ten times as much each time, from the first share on.
constexpr int kRaises = 6;
constexpr double kFirstRaise = 1e-4;

/// Lower triangle of a, n x n, becomes its Cholesky factor.
bool choleskyInPlace(int n, double* a) {
  for (int j = 0; j < n; ++j) {
    double* column = a + j * n;
    for (int k = 0; k < j; ++k) {
      const double factor = a[k * n + j];
      for (int i = j; i < n; ++i) column[i] -= a[k * n + i] * factor;
    }
    const double pivot = column[j];
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    const double inverse = 1 / std::sqrt(pivot);
    for (int i = j; i < n; ++i) column[i] *= inverse;
  }
  return true;
}

/// b = b inv(L)', b is m x n.
void solveFromRight(int m, int n, const double* l, double* b) {
  for (int j = 0; j < n; ++j) {
    double* column = b + j * m;
    for (int k = 0; k < j; ++k) {
      const double factor = l[k * n + j];
      for (int i = 0; i < m; ++i) column[i] -= b[k * m + i] * factor;
    }
    for (int i = 0; i < m; ++i) column[i] /= l[j * n + j];
  }
}

/// c (m x n) -= a (m x k) b' (n x k).
void subtractProduct(int m, int n, int k, const double* a, const double* b, double* c) {
  for (int j = 0; j < n; ++j) {
    for (int p = 0; p < k; ++p) {
      const double factor = b[p * n + j];
      for (int i = 0; i < m; ++i) c[j * m + i] -= a[p * m + i] * factor;
    }
  }
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

int PcgSolver::analyze(const graft_block_pattern& pattern, std::string& why) {
  factored_ = false;
  const std::int32_t count = pattern.block_count;
  dims_.assign(pattern.dims, pattern.dims + count);
  columns_.assign(pattern.columns, pattern.columns + count + 1);
  rows_.assign(pattern.rows, pattern.rows + columns_.back());
  sources_.assign(pattern.offsets, pattern.offsets + columns_.back());
  first_.assign(1, 0);
  offsets_.assign(1, 0);
  for (std::int32_t j = 0; j < count; ++j) {
    first_.push_back(first_.back() + dims_[std::size_t(j)]);
    for (std::int64_t b = columns_[std::size_t(j)]; b < columns_[std::size_t(j) + 1]; ++b) {
      const std::int64_t rows = dims_[std::size_t(rows_[std::size_t(b)])];
      offsets_.push_back(offsets_.back() + rows * dims_[std::size_t(j)]);
    }
  }
  if (columns_.back() > std::numeric_limits<int>::max()) {
    why = "the matrix has too many blocks";
    return GRAFT_OUT_OF_MEMORY;
  }
  fill_ = incompletePattern(pattern);
  layOutFactor();
  matrix_.assign(std::size_t(offsets_.back()), 0.0);
  factor_.assign(std::size_t(factor_offsets_.back()), 0.0);
  place_.assign(std::size_t(count), -1);
  return GRAFT_OK;
}

void PcgSolver::layOutFactor() {
  factor_offsets_.assign(1, 0);
  for (std::size_t j = 0; j + 1 < fill_.columns.size(); ++j) {
    for (std::int64_t b = fill_.columns[j]; b < fill_.columns[j + 1]; ++b) {
      const std::int64_t rows = dimAt(std::size_t(fill_.rows[std::size_t(b)]));
      factor_offsets_.push_back(factor_offsets_.back() + rows * dimAt(j));
    }
  }
  targets_.resize(rows_.size());
  for (std::int32_t j = 0; j < blockCount(); ++j) {
    for (std::int64_t b = columns_[std::size_t(j)]; b < columns_[std::size_t(j) + 1]; ++b) {
      const std::int32_t own = fill_.position[std::size_t(j)];
      const std::int32_t other = fill_.position[std::size_t(rows_[std::size_t(b)])];
      const auto column = std::size_t(std::min(own, other));
      const auto begin = fill_.rows.begin() + fill_.columns[column];
      const auto place = std::lower_bound(begin, fill_.rows.begin() + fill_.columns[column + 1],
                                          std::max(own, other));
      targets_[std::size_t(b)] = {factor_offsets_[std::size_t(place - fill_.rows.begin())],
                                  other < own};
    }
  }
}

int PcgSolver::factorize(const double* values, const double* damping, std::int32_t* failed_block,
                         std::string& why) {
  factored_ = false;
  double sum = 0;
  for (std::size_t b = 0; b < rows_.size(); ++b) {
    const std::int64_t size = offsets_[b + 1] - offsets_[b];
    const double* in = values + sources_[b];
    double* out = matrix_.data() + offsets_[b];
    for (std::int64_t i = 0; i < size; ++i) sum += 0.0 * (out[i] = in[i]);
  }
  for (std::int32_t j = 0; j < blockCount(); ++j) {
    const int dim = dims_[std::size_t(j)];
    double* block = matrix_.data() + offsets_[std::size_t(columns_[std::size_t(j)])];
    for (int c = 0; damping != nullptr && c < dim; ++c) {
      sum += 0.0 * (block[c * dim + c] += damping[first_[std::size_t(j)] + c]);
    }
  }
  if (sum != 0) {  // NaN is not 0 either
    why = "the matrix has entries that are not finite";
    return GRAFT_FAILED;
  }
  for (std::int32_t j = 0; j < blockCount(); ++j) {
    const int dim = dims_[std::size_t(j)];
    const double* block = matrix_.data() + offsets_[std::size_t(columns_[std::size_t(j)])];
    std::vector<double> copy(block, block + dim * dim);
    if (choleskyInPlace(dim, copy.data())) continue;
    if (failed_block != nullptr) *failed_block = j;
    why = "a diagonal block is not positive definite";
    return GRAFT_NOT_POSITIVE_DEFINITE;
  }
  std::int32_t failed = factorizeIncompletely(0);
  double raise = kFirstRaise;
  for (int i = 0; failed >= 0 && i < kRaises; ++i, raise *= 10) {
    failed = factorizeIncompletely(raise);
  }
  if (failed >= 0) {
    if (failed_block != nullptr) *failed_block = failed;
    why = "no incomplete factor exists even with a raised diagonal";
    return GRAFT_NOT_POSITIVE_DEFINITE;
  }
  factored_ = true;
  return GRAFT_OK;
}

std::int32_t PcgSolver::factorizeIncompletely(double raise) {
  std::fill(factor_.begin(), factor_.end(), 0.0);
  for (std::int32_t j = 0; j < blockCount(); ++j) {
    const int n = dims_[std::size_t(j)];
    for (std::int64_t b = columns_[std::size_t(j)]; b < columns_[std::size_t(j) + 1]; ++b) {
      const std::int32_t row = rows_[std::size_t(b)];
      const int m = dims_[std::size_t(row)];
      const Target& target = targets_[std::size_t(b)];
      const double* in = matrix_.data() + offsets_[std::size_t(b)];
      double* out = factor_.data() + target.offset;
      for (int c = 0; c < n; ++c) {
        for (int r = 0; r < m; ++r) out[target.transposed ? r * n + c : c * m + r] = in[c * m + r];
        if (row == j) out[c * n + c] *= 1 + raise;
      }
    }
  }
  for (std::size_t j = 0; j + 1 < fill_.columns.size(); ++j) {
    const std::int64_t begin = fill_.columns[j];
    const std::int64_t end = fill_.columns[j + 1];
    const int dim = dimAt(j);
    double* diagonal = factor_.data() + factor_offsets_[std::size_t(begin)];
    if (!choleskyInPlace(dim, diagonal)) return fill_.order[j];
    for (std::int64_t b = begin + 1; b < end; ++b) {
      const auto row = std::size_t(fill_.rows[std::size_t(b)]);
      solveFromRight(dimAt(row), dim, diagonal, factor_.data() + factor_offsets_[std::size_t(b)]);
      place_[row] = b;
    }
    // What this column does to those blocks of later columns that exist.
    for (std::int64_t b = begin + 1; b < end; ++b) {
      const auto column = std::size_t(fill_.rows[std::size_t(b)]);
      for (std::int64_t t = fill_.columns[column]; t < fill_.columns[column + 1]; ++t) {
        const auto row = std::size_t(fill_.rows[std::size_t(t)]);
        if (place_[row] < begin || place_[row] >= end) continue;
        subtractProduct(dimAt(row), dimAt(column), dim,
                        factor_.data() + factor_offsets_[std::size_t(place_[row])],
                        factor_.data() + factor_offsets_[std::size_t(b)],
                        factor_.data() + factor_offsets_[std::size_t(t)]);
      }
    }
  }
  return -1;
}

void PcgSolver::multiply(const double* x, double* y) const {
  std::fill(y, y + first_.back(), 0.0);
  for (std::int32_t j = 0; j < blockCount(); ++j) {
    const int n = dims_[std::size_t(j)];
    const double* xj = x + first_[std::size_t(j)];
    double* yj = y + first_[std::size_t(j)];
    for (std::int64_t b = columns_[std::size_t(j)]; b < columns_[std::size_t(j) + 1]; ++b) {
      const std::int32_t row = rows_[std::size_t(b)];
      const int m = dims_[std::size_t(row)];
      const double* a = matrix_.data() + offsets_[std::size_t(b)];
      const double* xi = x + first_[std::size_t(row)];
      double* yi = y + first_[std::size_t(row)];
      for (int c = 0; c < n; ++c, a += m) {
        double sum = 0;
        for (int r = 0; r < m; ++r) {
          yi[r] += a[r] * xj[c];
          sum += a[r] * xi[r];
        }
        if (row != j) yj[c] += sum;
      }
    }
  }
}

void PcgSolver::precondition(const double* r, double* z) const {
  std::copy(r, r + first_.back(), z);
  const std::size_t count = dims_.size();
  for (std::size_t j = 0; j < count; ++j) {
    const std::int64_t begin = fill_.columns[j];
    const int n = dimAt(j);
    const double* l = factor_.data() + factor_offsets_[std::size_t(begin)];
    double* zj = z + firstAt(j);
    for (int c = 0; c < n; ++c) {
      zj[c] /= l[c * n + c];
      for (int i = c + 1; i < n; ++i) zj[i] -= l[c * n + i] * zj[c];
    }
    for (std::int64_t b = begin + 1; b < fill_.columns[j + 1]; ++b) {
      const auto row = std::size_t(fill_.rows[std::size_t(b)]);
      const int m = dimAt(row);
      const double* a = factor_.data() + factor_offsets_[std::size_t(b)];
      double* zi = z + firstAt(row);
      for (int c = 0; c < n; ++c) {
        for (int i = 0; i < m; ++i) zi[i] -= a[c * m + i] * zj[c];
      }
    }
  }
  for (std::size_t j = count; j-- > 0;) {
    const std::int64_t begin = fill_.columns[j];
    const int n = dimAt(j);
    const double* l = factor_.data() + factor_offsets_[std::size_t(begin)];
    double* zj = z + firstAt(j);
    for (std::int64_t b = begin + 1; b < fill_.columns[j + 1]; ++b) {
      const auto row = std::size_t(fill_.rows[std::size_t(b)]);
      const int m = dimAt(row);
      const double* a = factor_.data() + factor_offsets_[std::size_t(b)];
      const double* zi = z + firstAt(row);
      for (int c = 0; c < n; ++c) {
        for (int i = 0; i < m; ++i) zj[c] -= a[c * m + i] * zi[i];
      }
    }
    for (int c = n - 1; c >= 0; --c) {
      for (int i = c + 1; i < n; ++i) zj[c] -= l[c * n + i] * zj[i];
      zj[c] /= l[c * n + c];
    }
  }
}

int PcgSolver::solve(const double* b, double* x, std::string& why) {
  iterations_ = 0;
  if (!factored_) {
    why = "solve() without a factor";
    return GRAFT_FAILED;
  }
  const auto size = std::size_t(first_.back());
  std::vector<double> r(b, b + size);
  std::vector<double> z(size);
  std::vector<double> q(size);
  precondition(r.data(), z.data());
  std::vector<double> p = z;
  double now = dot(r, z);
  const double start = now;
  if (!std::isfinite(start)) {
    why = "the right-hand side is not finite";
    return GRAFT_FAILED;
  }
  std::fill(x, x + size, 0.0);
  // The best iterate is kept: near what rounding allows, the residual goes up and down.
  std::vector<double> iterate(size, 0.0);
  double best = start;
  for (; iterations_ < kMostIterations && now > kTolerance * kTolerance * start; ++iterations_) {
    multiply(p.data(), q.data());
    const double curvature = dot(p, q);
    if (!(curvature > 0)) {
      why = "the matrix is not positive definite";
      return GRAFT_FAILED;
    }
    const double length = now / curvature;
    for (std::size_t i = 0; i < size; ++i) {
      iterate[i] += length * p[i];
      r[i] -= length * q[i];
    }
    precondition(r.data(), z.data());
    const double next = dot(r, z);
    const double growth = next / now;
    for (std::size_t i = 0; i < size; ++i) p[i] = z[i] + growth * p[i];
    now = next;
    if (now < best) {
      best = now;
      std::copy(iterate.begin(), iterate.end(), x);
    }
  }
  if (!(best > kLeastReduction * kLeastReduction * start)) return GRAFT_OK;
  char text[128];
  std::snprintf(text, sizeof text, "after %d iterations the residual has fallen to %.1e only",
                iterations_, std::sqrt(best / start));
  why = text;
  return GRAFT_FAILED;
}

}  // namespace graft
