// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/solver_pcg/incomplete_pattern.hpp"

#include <amd.h>

#include <algorithm>
#include <iterator>
#include <new>
#include <numeric>

namespace graft {

namespace {

using Index = std::int32_t;

/// Blocks below the diagonal, by column in the order of elimination.
using Columns = std::vector<std::vector<Index>>;

Columns columnsIn(const graft_block_pattern& pattern, const std::vector<Index>& position) {
  Columns columns(position.size());
  for (Index j = 0; j < pattern.block_count; ++j) {
    for (std::int64_t b = pattern.columns[j]; b < pattern.columns[j + 1]; ++b) {
      const Index a = position[std::size_t(j)];
      const Index c = position[std::size_t(pattern.rows[b])];
      if (a != c) columns[std::size_t(std::min(a, c))].push_back(std::max(a, c));
    }
  }
  for (std::vector<Index>& column : columns) std::sort(column.begin(), column.end());
  return columns;
}

/// Minimum degree; empty where AMD refuses the pattern.
std::vector<Index> orderByDegree(const graft_block_pattern& pattern) {
  std::vector<int> begin(pattern.columns, pattern.columns + pattern.block_count + 1);
  std::vector<Index> order(std::size_t(pattern.block_count));
  const int status =
      amd_order(pattern.block_count, begin.data(), pattern.rows, order.data(), nullptr, nullptr);
  if (status == AMD_OUT_OF_MEMORY) throw std::bad_alloc();
  if (status != AMD_OK && status != AMD_OK_BUT_JUMBLED) order.clear();
  return order;
}

/// Adds what elimination fills in; false once there are more than `most` blocks.
bool fillCompletely(Columns& columns, std::int64_t most) {
  std::int64_t count = 0;
  std::vector<Index> merged;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const std::vector<Index>& column = columns[j];
    count += std::int64_t(column.size());
    if (count > most) return false;
    if (column.size() < 2) continue;
    // The first row is the parent in the elimination tree.
    std::vector<Index>& parent = columns[std::size_t(column.front())];
    merged.clear();
    std::set_union(column.begin() + 1, column.end(), parent.begin(), parent.end(),
                   std::back_inserter(merged));
    parent = merged;
  }
  return true;
}

void keep(const Columns& columns, IncompletePattern& result) {
  result.columns.assign(1, 0);
  for (std::size_t j = 0; j < columns.size(); ++j) {
    result.rows.push_back(Index(j));
    result.rows.insert(result.rows.end(), columns[j].begin(), columns[j].end());
    result.columns.push_back(std::int64_t(result.rows.size()));
  }
}

}  // namespace

IncompletePattern incompletePattern(const graft_block_pattern& pattern) {
  IncompletePattern result;
  const auto blocks = std::size_t(pattern.block_count);
  const std::int64_t entries = pattern.columns[blocks];
  const auto most = std::int64_t(kMostFill * double(entries)) - std::int64_t(blocks);
  result.order = orderByDegree(pattern);
  result.position.resize(blocks);
  if (result.order.size() == blocks) {
    for (std::size_t i = 0; i < blocks; ++i) {
      result.position[std::size_t(result.order[i])] = Index(i);
    }
    Columns columns = columnsIn(pattern, result.position);
    result.complete = fillCompletely(columns, most);
    if (result.complete) {
      keep(columns, result);
      return result;
    }
  }
  result.order.resize(blocks);
  std::iota(result.order.begin(), result.order.end(), 0);
  result.position = result.order;
  keep(columnsIn(pattern, result.position), result);
  return result;
}

}  // namespace graft
