// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/types/abi.h"

namespace graft {

/// Neighbours of every block, both triangles, without the diagonal, rising.
struct BlockGraph {
  std::vector<std::int32_t> dims;
  std::vector<std::int32_t> begin;  ///< one more than blocks
  std::vector<std::int32_t> neighbours;

  BlockGraph() = default;
  /// Throws Error(kNoResult) if indices of 32 bits do not suffice, or memory.
  explicit BlockGraph(const graft_block_pattern& pattern);
  std::int32_t size() const { return std::int32_t(dims.size()); }
};

/// An elimination order and what it leads to.
struct Ordering {
  /// "natural", "amd", "metis", "kept", or such as "schur(1200 of 1250)+amd": so many blocks are
  /// eliminated first, independently of each other, and what is left is ordered by "amd".
  std::string name;
  std::vector<std::int32_t> order;  ///< position -> block
  double flops = 0;                 ///< of one factorisation, multiplications and additions
  double entries = 0;               ///< of the factor
};

/// The order with the fewest predicted flops of approximate minimum degree
/// (Amestoy, Davis, Duff 1996) and, where the factorisation costs enough that it
/// can pay, nested dissection (Karypis, Kumar 1998), both on the block graph. Where most
/// blocks can be eliminated independently, as landmarks can, they go first and what they
/// leave of the others (their Schur complement), a small graph, is ordered by these two;
/// minimum degree on all blocks is then tried only where it can pay.
Ordering chooseOrdering(const BlockGraph& graph);

/// A given order, judged.
Ordering keepOrdering(const BlockGraph& graph, std::vector<std::int32_t> order);

/// Parent of every position in the elimination tree of the permuted graph, -1 = root.
/// Source: Liu, "The role of elimination trees in sparse factorization", 1990.
std::vector<std::int32_t> eliminationTree(const BlockGraph& graph,
                                          const std::vector<std::int32_t>& order);

/// What a Cholesky factorisation in the given order takes.
struct FactorCost {
  double flops = 0;
  double entries = 0;  ///< of the lower triangle
};
FactorCost predictCost(const BlockGraph& graph, const std::vector<std::int32_t>& order);

}  // namespace graft
