// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/solve/problem.hpp"

namespace graft {

/// What spreadEstimates() did.
struct SpreadResult {
  Values values;
  std::int64_t placed = 0;    ///< vertices that got an estimate from an edge
  std::int64_t unplaced = 0;  ///< free vertices that no edge could place
};

/// Initial estimates along a spanning tree: breadth first from the problem's
/// roots, so that every vertex is reached over as few edges as possible, each
/// vertex placed by the propagate() of the edge that reaches it; edges of weight 0
/// place only what the others cannot reach. Deterministic.
/// Fixed and held vertices, and those that no edge can place, stay as they are
/// in `state`; edges that look something up use the state's associations.
/// `placed`: free vertices whose estimates in the state are good already; they are
/// roots, too, and not counted.
SpreadResult spreadEstimates(const Problem& problem, const State& state,
                             const std::vector<VertexRef>& placed = {});

}  // namespace graft
