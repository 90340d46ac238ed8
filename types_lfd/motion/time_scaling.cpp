// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/motion/time_scaling.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"

namespace graft::lfd {

void validateLimits(const SpeedLimits& limits) {
  for (const double limit :
       {limits.gripper_speed, limits.gripper_turn_rate, limits.base_speed, limits.base_turn_rate}) {
    if (!(limit > 0) || !std::isfinite(limit)) {
      throw Error(ExitCode::kUsage, "speed limits of a motion must be positive");
    }
  }
}

double leastTime(const JointPose& a, const JointPose& b, const SpeedLimits& limits) {
  const Vec<double, 6> gripper = poseError(a.gripper.inverse() * b.gripper);
  return std::max({gripper.head<3>().norm() / limits.gripper_speed,
                   gripper.tail<3>().norm() / limits.gripper_turn_rate,
                   std::hypot(b.base.x - a.base.x, b.base.y - a.base.y) / limits.base_speed,
                   std::abs(b.base.theta - a.base.theta) / limits.base_turn_rate});
}

std::vector<double> scaleTime(const std::vector<JointPose>& path, double nominal_step, double rate,
                              const SpeedLimits& limits) {
  std::vector<double> times(path.size(), 0.0);
  for (std::size_t i = 1; i < path.size(); ++i) {
    times[i] = times[i - 1] + std::max(nominal_step, leastTime(path[i - 1], path[i], limits));
  }
  if (times.empty() || !(times.back() > 0)) return times;
  // A total that is a whole number of periods but for rounding stays as it is.
  const double periods = std::max(1.0, std::ceil(times.back() * rate * (1 - 1e-12)));
  const double stretch = std::max(1.0, periods / rate / times.back());
  for (double& t : times) t *= stretch;
  return times;
}

JointPose interpolate(const JointPose& a, const JointPose& b, double s) {
  return {graft::interpolate(a.gripper, b.gripper, s),
          Pose2(a.base.x + s * (b.base.x - a.base.x), a.base.y + s * (b.base.y - a.base.y),
                a.base.theta + s * (b.base.theta - a.base.theta))};
}

}  // namespace graft::lfd
