// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/types/abi.h"

namespace graft::testing {

/// One edge, evaluated through the C ABI as the engine does it.
struct EdgeUnderTest {
  const graft_edge_type* type = nullptr;
  std::vector<const graft_vertex_type*> slots;
  std::vector<double> measurement;
  std::vector<const void*> resources;

  std::int32_t errorDim() const;
  Eigen::VectorXd error(const std::vector<std::vector<double>>& vertices) const;
  /// error dim x sum of the tangent dims.
  Eigen::MatrixXd jacobian(const std::vector<std::vector<double>>& vertices) const;
  /// The same by Ridders' extrapolation over the vertices' plus().
  Eigen::MatrixXd numericJacobian(const std::vector<std::vector<double>>& vertices) const;
  /// The estimate that propagate() gives slot `to`; empty if it cannot tell.
  std::vector<double> propagate(const std::vector<std::vector<double>>& vertices, int to) const;
};

}  // namespace graft::testing
