// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace graft::lfd {

/// Fraction of a minimum-jerk motion at fraction `s` of its time: 0 before, 1
/// after. Source: Flash and Hogan, "The coordination of arm movements", 1985.
double minimumJerkFraction(double s);

/// A point on a cubic Bezier curve, s in [0, 1].
Eigen::Vector3d bezier(const Eigen::Vector3d& p0, const Eigen::Vector3d& p1,
                       const Eigen::Vector3d& p2, const Eigen::Vector3d& p3, double s);

/// A path through points in the plane at given times, with a heading: piecewise
/// cubic, continuous velocity, at rest at both ends and outside.
class PlanarPath {
 public:
  /// Times must rise; `value` is [x; y; heading].
  void add(double time, const Eigen::Vector3d& value);
  Eigen::Vector3d at(double time) const;

 private:
  Eigen::Vector3d slope(std::size_t i) const;

  std::vector<double> times_;
  std::vector<Eigen::Vector3d> values_;
};

}  // namespace graft::lfd
