// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/base/parallel.hpp"
#include "core/linear/block_cholesky.hpp"

namespace graft {

/// A block of the inverse, by the numbers of its block row and block column.
struct BlockPair {
  std::int32_t row;
  std::int32_t column;
};

/// Blocks of A^-1 for the matrix that `cholesky` factored last, one dims(row) x
/// dims(column) matrix per pair. What lies in the pattern of the factor (every
/// diagonal block does) is found by recurrences from the roots of the elimination
/// tree down, all of it for about three times what the factorisation costs; what does
/// not, and a few blocks that solving is predicted to be cheaper for, column by column.
/// The same bits for any number of threads of the pool (may be null). Throws
/// Error(kNoResult) where memory does not suffice.
/// Source: Takahashi, Fagan, Chin, "Formation of a sparse bus impedance matrix", 1973;
/// on fronts: Campbell, Davis, "Computing the sparse inverse subset", 1995.
std::vector<Eigen::MatrixXd> inverseBlocks(const BlockCholesky& cholesky,
                                           const std::vector<BlockPair>& pairs, ThreadPool* pool);

}  // namespace graft
