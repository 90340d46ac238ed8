// SPDX-License-Identifier: BSD-3-Clause
#include "core/linear/schur_pattern.hpp"

#include <algorithm>
#include <numeric>

namespace graft {

std::vector<std::int32_t> independentSet(const BlockGraph& graph) {
  const auto degree = [&](std::int32_t block) {
    return graph.begin[std::size_t(block) + 1] - graph.begin[std::size_t(block)];
  };
  std::vector<std::int32_t> candidates(std::size_t(graph.size()));
  std::iota(candidates.begin(), candidates.end(), 0);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](std::int32_t a, std::int32_t b) { return degree(a) < degree(b); });
  std::vector<std::uint8_t> excluded(candidates.size(), 0);
  std::vector<std::int32_t> set;
  for (const std::int32_t block : candidates) {
    if (excluded[std::size_t(block)] != 0) continue;
    set.push_back(block);
    for (std::int32_t n = graph.begin[std::size_t(block)]; n < graph.begin[std::size_t(block) + 1];
         ++n) {
      excluded[std::size_t(graph.neighbours[std::size_t(n)])] = 1;
    }
  }
  std::sort(set.begin(), set.end());
  return set;
}

SchurPattern eliminateBlocks(const BlockGraph& graph, const std::vector<std::int32_t>& set) {
  constexpr std::int32_t kEliminated = -1;
  SchurPattern result;
  std::vector<std::int32_t> number(std::size_t(graph.size()), 0);
  for (const std::int32_t block : set) number[std::size_t(block)] = kEliminated;
  for (std::int32_t block = 0; block < graph.size(); ++block) {
    if (number[std::size_t(block)] == kEliminated) continue;
    number[std::size_t(block)] = std::int32_t(result.blocks.size());
    result.blocks.push_back(block);
    result.graph.dims.push_back(graph.dims[std::size_t(block)]);
  }
  std::vector<std::int32_t> mark(result.blocks.size(), -1);
  result.graph.begin.push_back(0);
  const auto visit = [&](std::int32_t block, auto&& body) {
    const std::int32_t end = graph.begin[std::size_t(block) + 1];
    for (std::int32_t n = graph.begin[std::size_t(block)]; n < end; ++n) {
      body(graph.neighbours[std::size_t(n)]);
    }
  };
  for (std::int32_t i = 0; i < std::int32_t(result.blocks.size()); ++i) {
    std::vector<std::int32_t>& neighbours = result.graph.neighbours;
    mark[std::size_t(i)] = i;
    const auto add = [&](std::int32_t block) {
      const std::int32_t other = number[std::size_t(block)];
      if (other == kEliminated || mark[std::size_t(other)] == i) return;
      mark[std::size_t(other)] = i;
      neighbours.push_back(other);
    };
    visit(result.blocks[std::size_t(i)], [&](std::int32_t block) {
      if (number[std::size_t(block)] == kEliminated) {
        visit(block, add);
      } else {
        add(block);
      }
    });
    std::sort(neighbours.begin() + result.graph.begin.back(), neighbours.end());
    result.graph.begin.push_back(std::int32_t(neighbours.size()));
  }
  return result;
}

}  // namespace graft
