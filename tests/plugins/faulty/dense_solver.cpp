// SPDX-License-Identifier: BSD-3-Clause
#include "tests/plugins/faulty/dense_solver.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace graft::testing {

namespace {

const char* chosen = nullptr;
void (*spoil)(const char* where) = nullptr;

bool fault(const char* name) { return chosen != nullptr && std::strcmp(chosen, name) == 0; }

class DenseSolver {
 public:
  void analyze(const graft_block_pattern& pattern) {
    pattern_ = &pattern;
    first_.assign(1, 0);
    for (int j = 0; j < pattern.block_count; ++j) {
      first_.push_back(first_.back() + std::size_t(pattern.dims[j]));
    }
  }

  int factorize(const double* values, const double* damping) {
    spoil("solver");
    const std::size_t n = first_.back();
    lower_.assign(n * n, 0.0);
    for (int j = 0; j < pattern_->block_count; ++j) {
      for (std::int64_t b = pattern_->columns[j]; b < pattern_->columns[j + 1]; ++b) {
        const int i = pattern_->rows[b];
        const std::size_t height = std::size_t(pattern_->dims[i]);
        for (std::size_t k = 0; k < height * std::size_t(pattern_->dims[j]); ++k) {
          at(first_[std::size_t(i)] + k % height, first_[std::size_t(j)] + k / height) =
              values[pattern_->offsets[b] + std::int64_t(k)];
        }
      }
    }
    for (std::size_t r = 0; damping != nullptr && !fault("solver_damping") && r < n; ++r) {
      at(r, r) += damping[r];
    }
    for (std::size_t c = 0; c < n; ++c) {
      double pivot = at(c, c);
      for (std::size_t k = 0; k < c; ++k) pivot -= at(c, k) * at(c, k);
      if (fault("solver_indefinite")) pivot = std::abs(pivot);
      if (!(pivot > 0) && !(fault("solver_nan") && std::isnan(pivot))) {
        return GRAFT_NOT_POSITIVE_DEFINITE;
      }
      at(c, c) = std::sqrt(pivot);
      for (std::size_t r = c + 1; r < n; ++r) {
        for (std::size_t k = 0; k < c; ++k) at(r, c) -= at(r, k) * at(c, k);
        at(r, c) /= at(c, c);
      }
    }
    return GRAFT_OK;
  }

  void solve(const double* b, double* x) {
    const std::size_t n = first_.back();
    std::vector<double> y(b, b + n);
    for (std::size_t r = 0; r < n; ++r) {
      for (std::size_t k = 0; k < r; ++k) y[r] -= at(r, k) * y[k];
      y[r] /= at(r, r);
    }
    for (std::size_t r = n; r-- > 0;) {
      for (std::size_t k = r + 1; k < n; ++k) y[r] -= at(k, r) * y[k];
      y[r] /= at(r, r);
    }
    if (fault("solver_state")) y[0] += 1e-12 * double(++solved_);
    std::memcpy(x, y.data(), n * sizeof(double));
    if (fault("solver_overrun")) x[n] = 0;
  }

 private:
  double& at(std::size_t r, std::size_t c) { return lower_[r * first_.back() + c]; }
  const graft_block_pattern* pattern_ = nullptr;
  std::vector<std::size_t> first_;
  std::vector<double> lower_;
  int solved_ = 0;
};

DenseSolver& of(void* self) { return *static_cast<DenseSolver*>(self); }

const graft_solver_type kType = {
    sizeof kType,
    "faulty_dense",
    "dense Cholesky",
    "BSD-3-Clause",
    [](std::int32_t) -> void* { return new DenseSolver; },
    [](void* self) { delete &of(self); },
    [](void* self, const graft_block_pattern* pattern, graft_message*) -> int {
      of(self).analyze(*pattern);
      return GRAFT_OK;
    },
    [](void* self, const double* values, const double* damping, std::int32_t* failed_block,
       graft_message*) -> int {
      if (fault("solver_block")) {
        *failed_block = 1000000000;
        return GRAFT_NOT_POSITIVE_DEFINITE;
      }
      return of(self).factorize(values, damping);
    },
    [](void* self, const double* b, double* x, graft_message*) -> int {
      of(self).solve(b, x);
      return GRAFT_OK;
    },
    [](void*) {
      return fault("solver_bytes_nan") ? std::nan("") : fault("solver_bytes") ? 1e18 : 0;
    }};

}  // namespace

const graft_solver_type& denseSolver(const char* fault_name,
                                     void (*spoil_function)(const char* where)) {
  chosen = fault_name;
  spoil = spoil_function;
  return kType;
}

}  // namespace graft::testing
