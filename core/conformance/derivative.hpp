// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

namespace graft::conformance {

/// A derivative by Ridders' extrapolation of central differences.
struct NumericDerivative {
  std::vector<double> value;
  /// Estimated error of the worst entry; large where the function is not smooth.
  double error = 0;
  double scale = 1;  ///< largest entry, at least 1
  bool reliable() const { return error <= 1e-7 * scale; }
  /// True where `exact` cannot be the derivative.
  bool contradicts(double exact, std::size_t entry) const;
};

/// Derivative at 0 of a function of one number; from the better of two initial
/// steps. Source: Ridders, "Accurate computation of F'(x) and F'(x)F''(x)", 1982.
NumericDerivative differentiate(const std::function<std::vector<double>(double)>& f,
                                double step = 1e-2);

}  // namespace graft::conformance
