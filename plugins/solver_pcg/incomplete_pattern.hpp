// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/types/abi.h"

namespace graft {

/// Which blocks an incomplete Cholesky factor has, and in which order blocks are eliminated.
struct IncompletePattern {
  std::vector<std::int32_t> order;     ///< position -> block
  std::vector<std::int32_t> position;  ///< block -> position
  std::vector<std::int64_t> columns;   ///< by position, one more
  std::vector<std::int32_t> rows;      ///< positions, rising; the diagonal first
  bool complete = false;               ///< nothing of the complete factor is left out
};

/// The complete factor, by approximate minimum degree, where it has at most kMostFill times the
/// blocks of the matrix (long thin graphs); else the blocks of the matrix and no others, in the
/// order given. What lies between, levels of fill, costs about what it gains.
IncompletePattern incompletePattern(const graft_block_pattern& pattern);

constexpr double kMostFill = 4;

}  // namespace graft
