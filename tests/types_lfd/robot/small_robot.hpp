// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "types_lfd/robot/chain.hpp"

namespace graft::lfd::testing {

/// A mobile robot with a torso and an arm of six joints, shaped like the common
/// ones but made up here. Chain: base to tool.
inline std::string smallRobotText() {
  return R"(<?xml version="1.0"?>
<robot name="small">
  <link name="base"/> <link name="torso"/> <link name="shoulder"/> <link name="upper_arm"/>
  <link name="forearm"/> <link name="wrist"/> <link name="hand"/> <link name="palm"/>
  <link name="tool"/>
  <joint name="lift" type="prismatic">
    <parent link="base"/> <child link="torso"/> <origin xyz="0.05 0 0.6"/> <axis xyz="0 0 1"/>
    <limit lower="0" upper="0.3" velocity="0.05" effort="1"/>
  </joint>
  <joint name="pan" type="revolute">
    <parent link="torso"/> <child link="shoulder"/> <origin xyz="0.1 -0.1 0"/> <axis xyz="0 0 1"/>
    <limit lower="-2.2" upper="1.4" velocity="2" effort="1"/>
  </joint>
  <joint name="shoulder_lift" type="revolute">
    <parent link="shoulder"/> <child link="upper_arm"/> <origin xyz="0.05 0 0"/> <axis xyz="0 1 0"/>
    <limit lower="-1.2" upper="1.4" velocity="2" effort="1"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper_arm"/> <child link="forearm"/> <origin xyz="0.35 0 0"/> <axis xyz="0 1 0"/>
    <limit lower="-2.3" upper="2.3" velocity="3" effort="1"/>
  </joint>
  <joint name="forearm_roll" type="continuous">
    <parent link="forearm"/> <child link="wrist"/> <axis xyz="1 0 0"/>
    <limit velocity="3" effort="1"/>
  </joint>
  <joint name="wrist_flex" type="revolute">
    <parent link="wrist"/> <child link="hand"/> <origin xyz="0.3 0 0"/> <axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="3" effort="1"/>
  </joint>
  <joint name="wrist_roll" type="continuous">
    <parent link="hand"/> <child link="palm"/> <axis xyz="1 0 0"/>
    <limit velocity="3" effort="1"/>
  </joint>
  <joint name="tool_joint" type="fixed">
    <parent link="palm"/> <child link="tool"/> <origin xyz="0.12 0 0"/>
  </joint>
</robot>
)";
}

inline Chain smallRobotChain(const Pose& tool_T_gripper = Pose()) {
  Diagnostics diagnostics;
  const UrdfModel model = readUrdfText("small.urdf", smallRobotText(), diagnostics);
  diagnostics.throwIfErrors();
  return Chain(model, "base", "tool", tool_T_gripper);
}

}  // namespace graft::lfd::testing
