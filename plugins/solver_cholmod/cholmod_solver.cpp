// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/solver_cholmod/cholmod_solver.hpp"

#include <cmath>
#include <cstring>
#include <limits>

namespace graft {

namespace {

// Below this many operations AMD alone is good enough: a second ordering would
// cost more than it saves.
constexpr double kDissectionFlops = 2e7;

bool allFinite(const double* numbers, std::size_t count) {
  // x * 0 is 0 for finite x and NaN else; CHOLMOD itself accepts NaN silently.
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += numbers[i] * 0.0;
  return sum == 0;
}

}  // namespace

CholmodSolver::CholmodSolver() {
  cholmod_start(&common_);
  common_.print = 0;
  common_.error_handler = nullptr;
  common_.final_ll = 1;
  common_.nmethods = 1;
  common_.method[0].ordering = CHOLMOD_GIVEN;
  common_.postorder = 1;
}

CholmodSolver::~CholmodSolver() {
  release();
  cholmod_finish(&common_);
}

void CholmodSolver::release() {
  if (factor_ != nullptr) cholmod_free_factor(&factor_, &common_);
  if (matrix_ != nullptr) cholmod_free_sparse(&matrix_, &common_);
  factored_ = false;
}

int CholmodSolver::statusCode(std::string& why) const {
  switch (common_.status) {
    case CHOLMOD_OK:
    case CHOLMOD_DSMALL:
      return GRAFT_OK;
    case CHOLMOD_OUT_OF_MEMORY:
    case CHOLMOD_TOO_LARGE:
      why = "CHOLMOD: out of memory, or the matrix is too large";
      return GRAFT_OUT_OF_MEMORY;
    case CHOLMOD_NOT_POSDEF:
      why = "CHOLMOD: the matrix is not positive definite";
      return GRAFT_NOT_POSITIVE_DEFINITE;
    default:
      why = "CHOLMOD: status " + std::to_string(common_.status);
      return GRAFT_FAILED;
  }
}

bool CholmodSolver::expand(const graft_block_pattern& pattern, std::string& why) {
  const int blocks = pattern.block_count;
  first_.assign(std::size_t(blocks) + 1, 0);
  block_of_.clear();
  std::int64_t entries = 0;
  std::int64_t rows = 0;
  for (int j = 0; j < blocks; ++j) {
    first_[std::size_t(j)] = int(rows);
    rows += pattern.dims[j];
    for (int k = 0; k < pattern.dims[j]; ++k) block_of_.push_back(j);
    for (std::int64_t b = pattern.columns[j]; b < pattern.columns[j + 1]; ++b) {
      const std::int64_t d = pattern.dims[j];
      const std::int64_t r = pattern.dims[pattern.rows[b]];
      entries += pattern.rows[b] == j ? d * (d + 1) / 2 : d * r;
    }
    if (rows > std::numeric_limits<int>::max() || entries > std::numeric_limits<int>::max()) {
      why = "the matrix is too large for 32-bit indices";
      return false;
    }
  }
  first_[std::size_t(blocks)] = int(rows);
  const auto n = std::size_t(rows);
  matrix_ = cholmod_allocate_sparse(n, n, std::size_t(entries), 1, 1, -1, CHOLMOD_REAL, &common_);
  if (matrix_ == nullptr) {
    why = "out of memory";
    return false;
  }
  source_.clear();
  source_.reserve(std::size_t(entries));
  diagonal_.clear();
  auto* column_begin = static_cast<int*>(matrix_->p);
  auto* row_of = static_cast<int*>(matrix_->i);
  int position = 0;
  for (int j = 0; j < blocks; ++j) {
    for (int c = 0; c < pattern.dims[j]; ++c) {
      column_begin[first_[std::size_t(j)] + c] = position;
      diagonal_.push_back(std::size_t(position));
      for (std::int64_t b = pattern.columns[j]; b < pattern.columns[j + 1]; ++b) {
        const int i = pattern.rows[b];
        const int height = pattern.dims[i];
        for (int r = i == j ? c : 0; r < height; ++r) {
          row_of[position++] = first_[std::size_t(i)] + r;
          source_.push_back(pattern.offsets[b] + std::int64_t(c) * height + r);
        }
      }
    }
  }
  column_begin[rows] = position;
  return true;
}

std::vector<int> CholmodSolver::blockOrdering(const graft_block_pattern& pattern, bool dissection) {
  const int blocks = pattern.block_count;
  const std::int64_t count = pattern.columns[blocks];
  cholmod_sparse* skeleton =
      cholmod_allocate_sparse(std::size_t(blocks), std::size_t(blocks), std::size_t(count), 1, 1,
                              -1, CHOLMOD_PATTERN, &common_);
  if (skeleton == nullptr) return {};
  for (int j = 0; j <= blocks; ++j) {
    static_cast<int*>(skeleton->p)[j] = int(pattern.columns[j]);
  }
  std::memcpy(skeleton->i, pattern.rows, std::size_t(count) * sizeof(int));
  std::vector<int> order(static_cast<std::size_t>(blocks));
  const int done = dissection ? cholmod_metis(skeleton, nullptr, 0, 1, order.data(), &common_)
                              : cholmod_amd(skeleton, nullptr, 0, order.data(), &common_);
  cholmod_free_sparse(&skeleton, &common_);
  if (done == 0) order.clear();
  return order;
}

cholmod_factor* CholmodSolver::analyzeWith(const std::vector<int>& block_order,
                                           const graft_block_pattern& pattern) {
  std::vector<int> order;
  order.reserve(matrix_->nrow);
  for (const int block : block_order) {
    for (int k = 0; k < pattern.dims[block]; ++k) order.push_back(first_[std::size_t(block)] + k);
  }
  return cholmod_analyze_p(matrix_, order.data(), nullptr, 0, &common_);
}

int CholmodSolver::analyze(const graft_block_pattern& pattern, std::string& why) {
  release();
  if (!expand(pattern, why)) return GRAFT_OUT_OF_MEMORY;
  const std::vector<int> amd = blockOrdering(pattern, false);
  if (amd.empty() && pattern.block_count > 0) return statusCode(why);
  factor_ = analyzeWith(amd, pattern);
  if (factor_ == nullptr) return statusCode(why);
  const double flops = common_.fl;
  if (flops < kDissectionFlops) return GRAFT_OK;
  const std::vector<int> metis = blockOrdering(pattern, true);
  cholmod_factor* other = metis.empty() ? nullptr : analyzeWith(metis, pattern);
  if (other == nullptr) return GRAFT_OK;
  if (common_.fl < flops) std::swap(factor_, other);
  cholmod_free_factor(&other, &common_);
  return GRAFT_OK;
}

double CholmodSolver::factorBytes() const {
  if (factor_ == nullptr) return 0;
  constexpr double kEntry = sizeof(double) + sizeof(int);
  const double copy = kEntry * double(source_.size());
  if (factor_->is_super != 0) {
    // Dense trapezoids, and the largest update of one.
    return copy + sizeof(double) * (double(factor_->xsize) + double(factor_->maxcsize));
  }
  const auto* counts = static_cast<const int*>(factor_->ColCount);
  double entries = 0;
  for (std::size_t j = 0; j < factor_->n; ++j) entries += counts[j];
  return copy + kEntry * entries;
}

int CholmodSolver::factorize(const double* values, const double* damping,
                             std::int32_t* failed_block, std::string& why) {
  factored_ = false;
  if (factor_ == nullptr) {
    why = "factorize() before analyze()";
    return GRAFT_FAILED;
  }
  auto* x = static_cast<double*>(matrix_->x);
  for (std::size_t k = 0; k < source_.size(); ++k) x[k] = values[source_[k]];
  if (damping != nullptr) {
    for (std::size_t c = 0; c < diagonal_.size(); ++c) x[diagonal_[c]] += damping[c];
  }
  if (!allFinite(x, source_.size())) {
    why = "the matrix has entries that are not finite";
    return GRAFT_FAILED;
  }
  cholmod_factorize(matrix_, factor_, &common_);
  const int code = statusCode(why);
  if (code == GRAFT_NOT_POSITIVE_DEFINITE && failed_block != nullptr) {
    const std::size_t column = std::min(factor_->minor, factor_->n - 1);
    const auto row = std::size_t(static_cast<const int*>(factor_->Perm)[column]);
    *failed_block = block_of_[row];
  }
  factored_ = code == GRAFT_OK;
  return code;
}

int CholmodSolver::solve(const double* b, double* x, std::string& why) {
  if (!factored_) {
    why = "solve() without a factor";
    return GRAFT_FAILED;
  }
  const std::size_t n = factor_->n;
  cholmod_dense right = {};
  right.nrow = right.d = right.nzmax = n;
  right.ncol = 1;
  right.x = const_cast<double*>(b);
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor_, &right, &common_);
  if (solution == nullptr) {
    const int code = statusCode(why);
    return code == GRAFT_OK ? GRAFT_FAILED : code;
  }
  std::memcpy(x, solution->x, n * sizeof(double));
  cholmod_free_dense(&solution, &common_);
  if (allFinite(x, n)) return GRAFT_OK;
  why = "the solution is not finite";
  return GRAFT_FAILED;
}

}  // namespace graft
