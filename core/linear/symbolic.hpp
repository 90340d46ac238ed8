// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/linear/ordering.hpp"

namespace graft {

/// Rows of a front are kept in strips of this many: a multiple of all vector
/// lengths in use, and of the block sizes 2, 3, 4 and 6.
constexpr int kStrip = 12;
constexpr int stripsOf(int rows) { return (rows + kStrip - 1) / kStrip; }

/// A run of block columns with (nearly) the same rows below, factored as one
/// dense front of `columns` + `rows` scalars. Scalars of the front are numbered
/// locally: first its columns, then its rows.
struct Supernode {
  std::int32_t parent = -1;
  std::vector<std::int32_t> children;  ///< rising
  std::int32_t first_block = 0;        ///< position of the first block column
  std::int32_t last_block = 0;         ///< one past the last
  std::int64_t first_scalar = 0;       ///< position of the first scalar column
  int columns = 0;
  int rows = 0;
  std::vector<std::int32_t> row_blocks;   ///< positions, rising
  std::vector<std::int32_t> row_scalars;  ///< position of every row
  /// Local number of every row in the front of the parent.
  std::vector<std::int32_t> in_parent;
  /// Where the factor's strips begin: strips x columns x kStrip numbers.
  std::int64_t factor_offset = 0;
  /// Where the update matrix begins; its columns are updateStride() apart.
  std::int64_t update_offset = 0;
  std::int32_t task = -1;  ///< the task it belongs to, -1 = none
  /// A leaf of few columns, e.g. a landmark: it is factored with its parent, and its
  /// update goes there at once, without a matrix of its own.
  bool absorbed = false;
  int absorbed_children = 0;

  int columnStrips() const { return stripsOf(columns); }
  int rowStrips() const { return stripsOf(rows); }
  int updateStride() const { return rowStrips() * kStrip; }
  /// Where row `local` of the front begins within the factor's strips.
  std::int64_t stripOffset(int local) const {
    const int r = local < columns ? local : local - columns + columnStrips() * kStrip;
    return std::int64_t{r / kStrip} * kStrip * columns + r % kStrip;
  }
};

/// One block of the matrix in the front that it is assembled into.
struct BlockTarget {
  std::int64_t values = 0;  ///< offset in the matrix
  std::int32_t rows = 0;    ///< of the block as stored in the matrix
  std::int32_t columns = 0;
  std::int32_t local_row = 0;
  std::int32_t local_column = 0;
  bool transposed = false;
};

/// Texts for requireMemory() about a factor.
constexpr const char* kFactorOfEquations = "the factor of the normal equations";
constexpr const char* kWithoutFactor = "; an iterative linear solver, such as pcg, makes no factor";

/// Everything about a factorisation that the pattern alone tells.
struct SymbolicFactor {
  Ordering ordering;
  std::vector<std::int32_t> blocks;           ///< position -> block
  std::vector<std::int64_t> scalar_position;  ///< first position of every block
  std::vector<Supernode> supernodes;          ///< children before parents
  std::vector<std::int64_t> target_begin;     ///< per supernode, one more
  std::vector<BlockTarget> targets;
  /// Separate subtrees that may be factored at the same time, each a rising list
  /// of supernodes; what is in none of them comes after. Empty unless asked for.
  std::vector<std::vector<std::int32_t>> tasks;
  std::int64_t factor_size = 0;
  std::int64_t update_size = 0;
  std::int64_t dim = 0;

  /// What the numbers of a factorisation take.
  double bytes() const { return sizeof(double) * (double(factor_size) + double(update_size)); }
};

/// Orders, finds the elimination tree, merges columns into supernodes where the
/// zeros that come in cost less than what a front of its own costs, and lays out
/// memory. `parallel`: also finds tasks, if there is enough to do; the factor has
/// the same bits either way. `order`, if not empty: the elimination order (position ->
/// block) to take instead of choosing one. Throws Error(kNoResult) where the factor is
/// larger than what memory is free.
SymbolicFactor analyzePattern(const graft_block_pattern& pattern, bool parallel = false,
                              const std::vector<std::int32_t>& order = {});

}  // namespace graft
