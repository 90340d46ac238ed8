// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/types/abi.h"
#include "plugins/solver_pcg/incomplete_pattern.hpp"

namespace graft {

/// Conjugate gradients on a symmetric positive definite block matrix, preconditioned by an
/// incomplete block Cholesky factor of at most kMostFill times the blocks of the matrix, where a
/// complete factor of a large three-dimensional graph takes a hundred times as much. That of a
/// long thin graph is complete, and a solution takes a step or two. One thread, so that results
/// never depend on how many there are.
/// Sources: Hestenes, Stiefel, "Methods of conjugate gradients", 1952; Meijerink, van der
/// Vorst, "An iterative solution method for linear systems", 1977; where that factor does
/// not exist, the diagonal is raised: Manteuffel, "An incomplete factorization technique for
/// positive definite linear systems", 1980.
class PcgSolver {
 public:
  /// Each returns a code of the ABI; `why` receives the reason of a failure.
  int analyze(const graft_block_pattern& pattern, std::string& why);
  /// A matrix is refused as not positive definite where a diagonal block is not, or where no
  /// preconditioner is found; solve() finds the rest.
  int factorize(const double* values, const double* damping, std::int32_t* failed_block,
                std::string& why);
  /// Until the residual, in the norm of the preconditioner, has fallen by 1e10; as much as
  /// rounding leaves of that, but at least 1e6.
  int solve(const double* b, double* x, std::string& why);

  int iterations() const { return iterations_; }

 private:
  std::int32_t blockCount() const { return std::int32_t(dims_.size()); }
  /// Factors the matrix with its diagonal raised by a share; the block that fails, or -1.
  std::int32_t factorizeIncompletely(double raise);
  int dimAt(std::size_t position) const { return dims_[std::size_t(fill_.order[position])]; }
  std::int64_t firstAt(std::size_t position) const {
    return first_[std::size_t(fill_.order[position])];
  }
  void layOutFactor();
  void multiply(const double* x, double* y) const;
  void precondition(const double* r, double* z) const;

  std::vector<std::int32_t> dims_;
  std::vector<std::int64_t> first_;    ///< entry of a block in a vector, one more
  std::vector<std::int64_t> columns_;  ///< as in graft_block_pattern, one more
  std::vector<std::int32_t> rows_;
  std::vector<std::int64_t> sources_;  ///< of the blocks in the caller's values
  std::vector<std::int64_t> offsets_;  ///< of the blocks here, one after the other; one more
  std::vector<double> matrix_;
  /// Where a block of the matrix stands in the factor.
  struct Target {
    std::int64_t offset = 0;
    bool transposed = false;
  };
  IncompletePattern fill_;
  std::vector<std::int64_t> factor_offsets_;  ///< of the factor's blocks, one more
  std::vector<Target> targets_;               ///< per block of the matrix
  std::vector<double> factor_;                ///< blocks of L, diagonal ones as lower triangles
  std::vector<std::int64_t> place_;
  int iterations_ = 0;
  bool factored_ = false;
};

}  // namespace graft
