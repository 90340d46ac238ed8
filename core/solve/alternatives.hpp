// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/solve/solve_context.hpp"

namespace graft {

/// Another association that an edge could have.
struct Alternative {
  std::size_t group = 0;
  std::int64_t edge = 0;
  std::vector<double> association;
  double predicted_chi2 = 0;  ///< once all else has followed

  bool isSameAs(const Alternative& other) const {
    return group == other.group && edge == other.edge && association == other.association;
  }
};

/// All alternatives of all edges that have any (GRAFT_EDGE_HAS_ALTERNATIVES) and no
/// robust kernel, by rising predicted chi2. An edge that takes what is nearest to the
/// estimates keeps it, for the estimates come to it; whether another would have cost
/// less shows only after all else has followed. That is predicted from the linear model
/// at the context's state, with the edge's vertices' marginal covariance: with M its
/// inverse less the edge's own part, F(d) = d'Md + |r_k(d)|^2 is minimised over the
/// vertices' tangents d for each alternative k. One solution of the normal equations
/// per tangent dimension of such an edge. Empty if the linear model cannot be factored.
std::vector<Alternative> findAlternatives(SolveContext& context);

/// Whether any edge of the problem has alternatives.
bool hasAlternatives(const Problem& problem);

/// What the edge of an alternative has chosen at the context's state.
Alternative currentChoice(const SolveContext& context, Alternative of);

}  // namespace graft
