// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/pattern_memory.hpp"

#include <algorithm>
#include <utility>

namespace graft {

namespace {

constexpr double kFlopsWorthNewOrder = 2;

std::vector<std::int64_t> blockIds(const Problem& problem) {
  std::vector<std::int64_t> ids;
  ids.reserve(problem.freeVertices().size());
  for (const VertexRef v : problem.freeVertices()) ids.push_back(problem.graph().id(v));
  return ids;
}

}  // namespace

bool PatternMemory::sameAs(const graft_block_pattern& pattern,
                           const std::vector<std::int64_t>& ids) const {
  const auto blocks = std::size_t(pattern.block_count);
  return known_ && ids == ids_ && std::equal(dims_.begin(), dims_.end(), pattern.dims) &&
         std::equal(columns_.begin(), columns_.end(), pattern.columns) &&
         rows_.size() == std::size_t(pattern.columns[blocks]) &&
         std::equal(rows_.begin(), rows_.end(), pattern.rows) &&
         std::equal(offsets_.begin(), offsets_.end(), pattern.offsets);
}

void PatternMemory::keep(const graft_block_pattern& pattern, std::vector<std::int64_t> ids) {
  const auto blocks = std::size_t(pattern.block_count);
  const auto entries = std::size_t(pattern.columns[blocks]);
  ids_ = std::move(ids);
  dims_.assign(pattern.dims, pattern.dims + blocks);
  columns_.assign(pattern.columns, pattern.columns + blocks + 1);
  rows_.assign(pattern.rows, pattern.rows + entries);
  offsets_.assign(pattern.offsets, pattern.offsets + entries);
  pattern_ = pattern;
  pattern_.dims = dims_.data();
  pattern_.columns = columns_.data();
  pattern_.rows = rows_.data();
  pattern_.offsets = offsets_.data();
}

/// The blocks in the order of last time, those that are new last; empty if none is known.
std::vector<std::int32_t> PatternMemory::orderFor(const std::vector<std::int64_t>& ids) const {
  std::vector<std::int32_t> order;
  std::vector<char> taken(ids.size(), 0);
  for (const std::int64_t id : order_) {
    const auto place = std::lower_bound(ids.begin(), ids.end(), id);
    if (place == ids.end() || *place != id) continue;
    order.push_back(std::int32_t(place - ids.begin()));
    taken[std::size_t(order.back())] = 1;
  }
  if (order.empty()) return order;
  for (std::size_t block = 0; block < ids.size(); ++block) {
    if (taken[block] == 0) order.push_back(std::int32_t(block));
  }
  return order;
}

SymbolicReuse PatternMemory::analyze(const Problem& problem, const NormalEquations& equations,
                                     LinearSolver& solver) {
  const graft_block_pattern& pattern = equations.pattern();
  std::vector<std::int64_t> ids = blockIds(problem);
  if (sameAs(pattern, ids)) return SymbolicReuse::kEverything;
  const std::vector<std::int32_t> kept = known_ ? orderFor(ids) : std::vector<std::int32_t>();
  known_ = false;
  keep(pattern, std::move(ids));
  SymbolicReuse reuse = kept.empty() ? SymbolicReuse::kNothing : SymbolicReuse::kOrdering;
  solver.analyze(pattern_, kept);
  if (reuse == SymbolicReuse::kOrdering &&
      solver.flops() > kFlopsWorthNewOrder * flops_when_ordered_) {
    solver.analyze(pattern_);
    reuse = SymbolicReuse::kNothing;
  }
  if (reuse == SymbolicReuse::kNothing) flops_when_ordered_ = solver.flops();
  order_.clear();
  if (const std::vector<std::int32_t>* order = solver.order()) {
    for (const std::int32_t block : *order) order_.push_back(ids_[std::size_t(block)]);
  }
  known_ = true;
  return reuse;
}

}  // namespace graft
