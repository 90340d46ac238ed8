// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>

namespace graft::testing {

/// Numeric Jacobian of f at 0 by Ridders' extrapolation of central differences:
/// the truth that exact derivatives are tested against.
/// Source: Ridders, "Accurate computation of F'(x) and F'(x)F''(x)", 1982.
/// f maps n numbers to m; the result is m x n, good to about 1e-10 relative
/// for smooth f of order one.
Eigen::MatrixXd riddersJacobian(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& f,
                                int n, double initial_step = 0.02);

}  // namespace graft::testing
