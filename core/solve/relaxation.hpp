// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/base/parallel.hpp"
#include "core/solve/problem.hpp"

namespace graft {

/// What relaxEstimates() did.
struct RelaxResult {
  Values values;
  std::vector<VertexRef> placed;  ///< free vertices whose estimates are new
  std::string failure;            ///< why there is none, else empty
};

/// Initial estimates from the relaxations that types offer (see
/// graft_vertex_relaxation): in each stage one linear least-squares problem over
/// all vertices that equations tie to something known, then what was found is put
/// back on the manifolds. For poses that is the chordal relaxation: rotations as
/// free matrices, projected, and then translations. Fixed and held vertices stay;
/// so do vertices and edges without a relaxation, which play no part. Robust
/// kernels and edges of weight 0 are left out. Deterministic. `only_overdetermined`: fails, early,
/// where a stage has no more equations than unknowns, for then it can tell no more than a spanning
/// tree.
RelaxResult relaxEstimates(const Problem& problem, const State& state, ThreadPool& pool,
                           bool only_overdetermined = false);

}  // namespace graft
