// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/parallel.hpp"
#include "core/linear/front_kernels.hpp"
#include "core/linear/symbolic.hpp"

namespace graft {

/// The built-in sparse Cholesky solver: multifrontal on supernodes of blocks.
/// Source: Liu, "The multifrontal method for sparse matrix solution: theory and
/// practice", SIAM Review 1992.
class BlockCholesky {
 public:
  /// With a pool, subtrees and large fronts are shared out; the factor has the
  /// same bits for any number of threads. The pool must outlive the solver.
  explicit BlockCholesky(ThreadPool* pool = nullptr, const FrontKernels& kernels = frontKernels())
      : pool_(pool), kernels_(&kernels) {}

  /// Symbolic work, once per pattern. Throws Error(kNoResult) where memory does not suffice.
  /// `order`: as in analyzePattern().
  void analyze(const graft_block_pattern& pattern, const std::vector<std::int32_t>& order = {});
  /// Factors A + diag(damping) (damping may be null). Returns -1, or the block
  /// whose pivot is not positive (beyond rounding) or not finite.
  std::int32_t factorize(const double* values, const double* damping);
  /// x = A^-1 b with the last factor; b may be x.
  void solve(const double* b, double* x) const;

  const SymbolicFactor& symbolic() const { return symbolic_; }
  const FrontKernels& kernels() const { return *kernels_; }
  const std::vector<std::int32_t>& dims() const { return dims_; }
  /// First entry of every block in a vector.
  const std::vector<std::int64_t>& offsets() const { return offsets_; }
  /// L by fronts; see Supernode::factor_offset. Above the diagonal it is not zero.
  const std::vector<double>& factor() const { return factor_; }
  /// 1 / diag(L), by position.
  const std::vector<double>& inverses() const { return inverses_; }

 private:
  /// Each of these factors what it says and returns -1 or the block that failed.
  std::int32_t factorSupernode(std::size_t index, const double* values, const double* damping,
                               bool share);
  std::int32_t factorColumns(std::size_t index);
  std::int32_t factorAbsorbed(const Supernode& s, const double* values, const double* damping,
                              bool share);
  void assembleMatrix(std::size_t index, const double* values, const double* damping);
  void assembleColumns(const Supernode& s, const Supernode& child);
  void assembleUpdate(const Supernode& s, const Supernode& child);
  void assembleAbsorbed(const Supernode& s, bool share);
  void addAbsorbed(const Supernode& s, const Supernode& child, int begin, int end);
  void formUpdate(const Supernode& s, bool share);
  std::int32_t blockAt(const Supernode& s, int column) const;

  ThreadPool* pool_;
  const FrontKernels* kernels_;
  SymbolicFactor symbolic_;
  std::vector<std::int32_t> dims_;
  std::vector<std::int64_t> offsets_;  ///< of the blocks in vectors
  std::vector<double> factor_;
  std::vector<double> inverses_;
  std::vector<double> thresholds_;  ///< pivots must be larger, by position
  std::vector<double> updates_;
};

}  // namespace graft
