// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/solve/problem.hpp"
#include "core/types/batch.hpp"

namespace graft {

/// The pointers of a run of edges of one group at a state, as descriptors want
/// them. Lives no longer than the state and the problem.
class EdgeBatch {
 public:
  EdgeBatch(const EdgeGroup& group, std::size_t group_index, const State& state, std::int64_t begin,
            std::int64_t end)
      : EdgeBatch(group, state.values, state.associations[group_index], begin, end) {}
  /// `associations`: of the whole group.
  EdgeBatch(const EdgeGroup& group, const Values& values, const std::vector<double>& associations,
            std::int64_t begin, std::int64_t end);
  const graft_edge_batch& view() const { return view_; }
  /// The same with one edge only.
  graft_edge_batch single(std::int64_t edge) const { return singleEdge(view_, edge); }

 private:
  graft_edge_batch view_ = {};
  std::vector<const double*> vertices_;
  std::vector<const double*> associations_;
  std::vector<const double*> information_;
  std::vector<const void* const*> resources_;
};

}  // namespace graft
