// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/graph/graph.hpp"
#include "core/solve/options.hpp"
#include "core/solve/summary.hpp"
#include "core/types/registry.hpp"

namespace graft {

/// Minimises F(x) = sum rho(e' Omega e) over the free vertices of the graph.
/// `values` are the start and receive the result. Throws Error(kUsage) for bad
/// options or an unknown solver, Error(kInput) for an information matrix that is
/// not positive semidefinite (naming the edge's tag, line and smallest
/// eigenvalue); numerical failure is a Summary with Status::kFailed, whose
/// reason names the edge or vertex.
Summary optimize(const Graph& graph, Values& values, Registry& registry,
                 const SolveOptions& options = {});

/// F at the values, without solving. `by_tag`, if given, receives the share of
/// every edge type. `level` as in SolveOptions.
double evaluateChi2(const Graph& graph, const Values& values,
                    std::map<std::string, double>* by_tag = nullptr, std::int32_t level = 0);

}  // namespace graft
