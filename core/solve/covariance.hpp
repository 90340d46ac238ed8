// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/graph/graph.hpp"
#include "core/types/registry.hpp"

namespace graft {

/// Marginal covariances of chosen vertices at the given values: the diagonal
/// blocks of (J' Omega J)^-1, one tangent_dim x tangent_dim matrix per vertex,
/// in the tangent's order and units. A vertex that is held fixed has zeros. Exact
/// for a linear problem, first order otherwise. Throws Error(kNoResult) where the
/// Hessian is singular or an edge cannot be evaluated.
std::vector<Eigen::MatrixXd> marginalCovariances(const Graph& graph, const Values& values,
                                                 Registry& registry,
                                                 const std::vector<VertexRef>& vertices);

}  // namespace graft
