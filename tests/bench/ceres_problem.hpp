// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/graph/graph.hpp"

namespace graft::bench {

struct PeerResult {
  double chi2 = 0;  ///< e' Omega e, without Ceres' factor 1/2
  int iterations = 0;
  double seconds = 0;  ///< preprocessing and minimisation
  bool usable = false;
};

/// Solves a graph with Ceres from the given values; held vertices are those fixed in
/// the graph and `held`. Throws std::runtime_error for a type that is not known here.
PeerResult solveWithCeres(const Graph& graph, const Values& values, std::int64_t held, int threads);

}  // namespace graft::bench
