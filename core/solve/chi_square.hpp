// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace graft {

/// Probability that a chi-square variable with `freedom` > 0 degrees of freedom is at
/// most x: the regularised incomplete gamma function P(freedom / 2, x / 2), to about
/// 1e-14 (series and continued fraction as in Abramowitz and Stegun, 6.5.29 and 6.5.31).
double chiSquareProbability(double x, int freedom);

/// The x that a chi-square variable with `freedom` > 0 degrees of freedom stays below
/// with a probability in [0, 1): the inverse of the above.
double chiSquareQuantile(double probability, int freedom);

}  // namespace graft
