// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/linear/ordering.hpp"

namespace graft {

/// Blocks no two of which are neighbours, rising, chosen greedily by the number of
/// neighbours. Blocks of one edge of any arity are neighbours, so that eliminating one
/// of these changes no other.
std::vector<std::int32_t> independentSet(const BlockGraph& graph);

/// The pattern of a Schur complement.
struct SchurPattern {
  std::vector<std::int32_t> blocks;  ///< of the graph that stay, rising
  BlockGraph graph;                  ///< over their numbers in `blocks`
};

/// The graph that is left once the blocks of `set`, which must be independent, are
/// eliminated: the neighbours of each of them become neighbours of each other.
SchurPattern eliminateBlocks(const BlockGraph& graph, const std::vector<std::int32_t>& set);

}  // namespace graft
