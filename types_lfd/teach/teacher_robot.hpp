// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace graft::lfd {

/// Names and shape of the teacher's robot, as they go into task.xml.
constexpr const char* kRobotBaseLink = "base_footprint";
constexpr const char* kRobotTipLink = "gripper_tool_frame";
constexpr double kRobotHalfWidth = 0.33;  ///< m; the footprint is a square

/// A URDF of a robot built like a PR2: a square omnidirectional base, a lift of
/// 0.33 m, and a right arm of seven joints (shoulder pan, lift, upper-arm roll,
/// elbow, forearm roll, wrist flex, wrist roll) of 0.1 + 0.4 + 0.32 + 0.18 m.
/// Boxes and cylinders serve as shapes for display and collision.
std::string formatRobotUrdf();

}  // namespace graft::lfd
