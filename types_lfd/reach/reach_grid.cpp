// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_grid.hpp"

#include <algorithm>
#include <cmath>

namespace graft::lfd {

GripperView ReachGrid::view(const Eigen::Matrix3d& r, const Eigen::Vector3d& position) {
  GripperView v;
  v.position = position;
  v.heading = std::atan2(r(1, 0), r(0, 0));
  const double length = std::hypot(r(1, 0), r(0, 0));
  const double c = length > 0 ? r(0, 0) / length : 1;
  const double s = length > 0 ? r(1, 0) / length : 0;
  // Unlike the arcsine, exact near straight up and down.
  v.elevation = std::atan2(r(2, 0), length);
  // Second row of Rz(-heading) R = Ry(-elevation) Rx(roll): [0 cos(roll) -sin(roll)].
  v.roll = std::atan2(s * r(0, 2) - c * r(1, 2), c * r(1, 1) - s * r(0, 1));
  return v;
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
