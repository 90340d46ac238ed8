// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_grid.hpp"

#include <algorithm>
#include <cmath>

namespace graft::lfd {

namespace {

/// floor() as an int that never overflows.
int floorToInt(double x) { return static_cast<int>(std::floor(std::clamp(x, -1e9, 1e9))); }

}  // namespace

int ReachGrid::ring(double up) const {
  return static_cast<int>(std::lround(std::asin(std::clamp(up, -1.0, 1.0)) / step()));
}

int ReachGrid::tiltOf(int ring, int roll_bin) const {
  const int cap = turn / 4;
  if (ring <= -cap) return tiltCount() - 2;
  if (ring >= cap) return tiltCount() - 1;
  return (ring + cap - 1) * turn + roll_bin;
}

void ReachGrid::split(const Eigen::Matrix3d& r, double& azimuth, double& roll) {
  azimuth = std::atan2(r(1, 0), r(0, 0));
  const double length = std::hypot(r(1, 0), r(0, 0));
  const double c = length > 0 ? r(0, 0) / length : 1;
  const double s = length > 0 ? r(1, 0) / length : 0;
  // Second row of Rz(-azimuth) R = Ry(-elevation) Rx(roll): [0 cos(roll) -sin(roll)].
  roll = std::atan2(s * r(0, 2) - c * r(1, 2), c * r(1, 1) - s * r(0, 1));
}

GripperView ReachGrid::view(const Eigen::Matrix3d& r, const Eigen::Vector3d& position) const {
  GripperView v;
  v.position = position;
  double roll = 0;
  split(r, v.heading, roll);
  const int k = ring(r(2, 0));
  const int cap = turn / 4;
  if (k >= cap) v.heading = wrapAngle(v.heading + roll);
  if (k <= -cap) v.heading = wrapAngle(v.heading - roll);
  v.tilt = tiltOf(k, angleBin(roll));
  return v;
}

int ReachGrid::heightBin(double z) const { return floorToInt(z / resolution) - z0; }

int ReachGrid::angleBin(double angle) const {
  const int bin = floorToInt(wrapAngle(angle) / step() + 0.5);
  return bin < 0 ? bin + turn : bin % turn;
}

Pose2 baseInView(const GripperView& view, const Pose2& world_T_base) {
  const double c = std::cos(view.heading);
  const double s = std::sin(view.heading);
  const double dx = world_T_base.x - view.position[0];
  const double dy = world_T_base.y - view.position[1];
  return Pose2(c * dx + s * dy, c * dy - s * dx, wrapAngle(world_T_base.theta - view.heading));
}

Pose2 baseInWorld(const GripperView& view, const Pose2& b) {
  const double c = std::cos(view.heading);
  const double s = std::sin(view.heading);
  return Pose2(view.position[0] + c * b.x - s * b.y, view.position[1] + s * b.x + c * b.y,
               wrapAngle(b.theta + view.heading));
}

}  // namespace graft::lfd
