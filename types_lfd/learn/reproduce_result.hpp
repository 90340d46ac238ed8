// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "types_lfd/learn/result_reader.hpp"
#include "types_lfd/motion/reproduce.hpp"
#include "types_lfd/robot/arm_ik.hpp"

namespace graft::lfd {

/// A generated motion with the arm's joints and what was checked about it.
struct ReproducedMotion {
  std::vector<MotionPoint> points;
  IkTrack joints;
  std::vector<std::string> joint_names;
  std::size_t in_collision = 0;  ///< points whose footprint hits the map
  bool has_map = false;
};

/// Generates the motion of one or more learned results in a row (paper, section
/// V). `objects` holds one pose per result; where it is empty the objects stand
/// as in the first demonstration of each.
ReproducedMotion reproduceResults(const std::vector<std::string>& directories,
                                  const std::vector<Pose>& objects,
                                  const ReproduceOptions& options);

/// Text of motion/joints.csv: time, joints of the chain (empty where no arm
/// configuration was found), base_x, base_y, base_yaw.
std::string formatMotionJoints(const ReproducedMotion& motion);

}  // namespace graft::lfd
