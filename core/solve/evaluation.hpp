// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <string>
#include <vector>

#include "core/graph/graph.hpp"
#include "core/graph/information_policy.hpp"
#include "core/solve/options.hpp"

namespace graft {

/// One edge at given estimates.
struct EdgeEvaluation {
  const graft_edge_type* type = nullptr;
  std::vector<VertexRef> vertices;  ///< by slot
  std::int64_t line = 0;            ///< of the file it came from, 0 = none
  Eigen::VectorXd error;            ///< e as the type defines it
  Eigen::VectorXd whitened;         ///< r = S e with S'S = Omega, so that |r|^2 = e' Omega e
  double squared = 0;               ///< s = e' Omega e
  double chi2 = 0;                  ///< rho(s): the edge's share of F; s without a kernel
  double weight = 1;                ///< rho'(s); 1 without a kernel
  /// d e / d tangent of the vertex, one matrix a slot (error dim x tangent dim), fixed
  /// vertices included; empty unless asked for.
  std::vector<Eigen::MatrixXd> jacobians;

  /// "EDGE_SE3:QUAT 3 4 (line 17)".
  std::string describe(const Graph& graph) const;
};

struct EvaluationOptions {
  bool jacobians = false;
  InformationPolicy information = InformationPolicy::kError;
  std::int32_t level = 0;  ///< edges of this level take part; kAllLevels = all
};

/// Every edge of a graph at the values, without solving and without changing anything.
/// The order is canonical: by tag, vertex ids and content, however the graph was put
/// together. Edges that choose what they measure to do so at the values. Throws
/// Error(kInput) for an information matrix that is not positive semidefinite, and
/// Error(kNoResult), with the edge, where something is not finite.
std::vector<EdgeEvaluation> evaluateEdges(const Graph& graph, const Values& values,
                                          const EvaluationOptions& options = {});

/// The least-squares problem that a Gauss-Newton step solves at the values:
/// F(x [+] d) = |r + J d|^2 to first order in the errors. Rows are whitened and, under a
/// robust kernel, scaled by sqrt(rho'(s)), so that 2 J'r is the exact gradient of F.
struct Linearization {
  std::vector<VertexRef> vertices;    ///< free ones by rising id: the columns of J
  std::vector<std::int64_t> columns;  ///< first column of each, and the number of columns
  Eigen::VectorXd residual;           ///< r, edges in the order of evaluateEdges()
  Eigen::SparseMatrix<double> jacobian;
  Eigen::VectorXd gradient;  ///< dF/dd = 2 J'r
  double chi2 = 0;           ///< F; differs from |r|^2 under robust kernels
  /// Vertices without an edge, fixed ones, and those held because nothing else fixes
  /// their component (see notes) have no columns.
  std::vector<std::string> notes;
};

/// Throws as evaluateEdges().
Linearization linearize(const Graph& graph, const Values& values,
                        const EvaluationOptions& options = {});

}  // namespace graft
