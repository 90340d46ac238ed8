// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "core/graph/graph.hpp"
#include "core/graph/information_policy.hpp"

namespace graft {

/// How covariances are computed. Results do not depend on `threads` (0 = all).
struct CovarianceOptions {
  InformationPolicy information = InformationPolicy::kError;
  int threads = 0;
};

/// Blocks of (J' Omega J)^-1 at the given values, the covariance of the first vertex
/// with the second: tangent_dim x tangent_dim of them, in the tangents' order and units.
/// A vertex that is held fixed or has no edge has zeros. Exact for a linear problem,
/// first order otherwise. All marginals and all pairs that an edge joins cost about as
/// much as three factorisations together; other pairs two solutions per column. Throws
/// Error(kNoResult) where the Hessian is singular, with the vertex that its edges do not
/// determine, or where an edge cannot be evaluated.
std::vector<Eigen::MatrixXd> jointCovariances(
    const Graph& graph, const Values& values,
    const std::vector<std::pair<VertexRef, VertexRef>>& pairs,
    const CovarianceOptions& options = {});

/// The same for chosen vertices with themselves; symmetric to the last bit.
std::vector<Eigen::MatrixXd> marginalCovariances(const Graph& graph, const Values& values,
                                                 const std::vector<VertexRef>& vertices,
                                                 const CovarianceOptions& options = {});

}  // namespace graft
