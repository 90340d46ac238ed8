// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/geometry/se2.hpp"
#include "core/geometry/se3.hpp"

namespace graft::lfd {

/// Highest speeds of gripper and base in the world frame.
struct SpeedLimits {
  double gripper_speed = 1.0;      ///< m/s
  double gripper_turn_rate = 2.0;  ///< rad/s
  double base_speed = 0.5;         ///< m/s
  double base_turn_rate = 0.8;     ///< rad/s
};

/// Joint poses along a path; the base's yaw is continuous (not wrapped).
struct JointPose {
  Pose gripper;
  Pose2 base;
};

/// Throws Error(kUsage) unless all limits are positive and finite.
void validateLimits(const SpeedLimits& limits);

/// The least time (s) in which the limits allow the way from a to b.
double leastTime(const JointPose& a, const JointPose& b, const SpeedLimits& limits);

/// Times (s, from 0) of the nodes of a path whose steps should take
/// `nominal_step` each: a step that would be too fast takes as long as the limits
/// ask for. The total is then stretched to a whole number of periods of 1/rate,
/// so that a motion sampled at `rate` holds first and last node exactly.
std::vector<double> scaleTime(const std::vector<JointPose>& path, double nominal_step, double rate,
                              const SpeedLimits& limits);

/// The joint pose at fraction s in [0, 1] between two: every quantity at
/// constant speed.
JointPose interpolate(const JointPose& a, const JointPose& b, double s);

}  // namespace graft::lfd
