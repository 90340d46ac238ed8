// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace graft::lfd {

/// Median of the length of a 3-D vector whose components are unit normal (chi
/// distribution, 3 degrees of freedom): divides a median length into a sigma.
constexpr double kMedianChi3 = 1.5381722544550522;

/// Median of values; must not be empty.
double medianOf(std::vector<double> values);

/// Value at `at` of the line through (times[k], values[k]) by repeated medians:
/// half of the points may be anywhere. At least 2 points with distinct times.
/// Source: Siegel, "Robust regression using repeated medians", 1982.
double repeatedMedianLine(const std::vector<double>& times, const std::vector<double>& values,
                          double at);

}  // namespace graft::lfd
