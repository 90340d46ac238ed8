// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "types_lfd/demo/segment.hpp"

namespace graft::lfd {

/// Positions (m) of a hand that arrives somewhere and rests, by clock (s,
/// rising). The caller cuts them so that they begin after peak speed, or says
/// that they may begin anywhere on the way.
struct ArrivalSamples {
  std::vector<double> times;
  std::vector<Eigen::Vector3d> points;
  /// Distance (m) from where it rests at all tuples, interpolated ones too, by clock.
  std::vector<double> all_times;
  std::vector<double> distances;
  double edge = 0;    ///< clock at which the hand is at rest up to noise
  double latest = 0;  ///< latest arrival considered
  bool after_peak = true;
};

/// Share of the way still to go, `rest` (0 to 1) of the duration before the end
/// of a minimum-jerk movement: 10 r^3 - 15 r^4 + 6 r^5.
double minimumJerkToGo(double rest);

/// Clock of the arrival: least squares fit of
///   p(t) = c + a minimumJerkToGo((g - t) / T) before g, c from g on
/// over g, T, c and a. Of all g that fit as well as the best up to two
/// standard deviations the earliest at which the hand is within options.near of its rest:
/// of one that does not come with minimum jerk (it walks, it hesitates) every g fits badly,
/// and many as well as the best.
double fitArrival(const ArrivalSamples& samples, const SegmentOptions& options);

}  // namespace graft::lfd
