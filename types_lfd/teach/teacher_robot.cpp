// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/teacher_robot.hpp"

#include "core/base/text.hpp"

namespace graft::lfd {

namespace {

/// A link's one solid: a box (x y z) or a cylinder along x (radius, length).
struct Shape {
  const char* geometry;
  const char* origin;
};

struct LinkRow {
  const char* name;
  Shape shape;  ///< geometry is null for a bare frame
};

struct JointRow {
  const char* name;
  const char* type;
  const char* parent;
  const char* child;
  const char* xyz;    ///< m, in the parent
  const char* axis;   ///< null for fixed joints
  const char* limit;  ///< attributes of <limit>
};

constexpr const char* kAlongX = "rpy=\"0 1.5707963267948966 0\" ";

constexpr LinkRow kLinks[] = {
    {"base_footprint", {nullptr, nullptr}},
    {"base_link", {"<box size=\"0.65 0.65 0.27\"/>", "xyz=\"0 0 0.135\""}},
    {"torso_lift_link", {"<box size=\"0.22 0.36 0.60\"/>", "xyz=\"-0.13 0 -0.20\""}},
    {"shoulder_pan_link", {"<cylinder radius=\"0.10\" length=\"0.28\"/>", "xyz=\"0 0 -0.05\""}},
    {"shoulder_lift_link", {"<box size=\"0.15 0.14 0.14\"/>", "xyz=\"0.03 0 0\""}},
    {"upper_arm_link", {"<cylinder radius=\"0.065\" length=\"0.32\"/>", "xyz=\"0.20 0 0\""}},
    {"elbow_link", {"<box size=\"0.12 0.11 0.11\"/>", "xyz=\"0 0 0\""}},
    {"forearm_link", {"<cylinder radius=\"0.055\" length=\"0.24\"/>", "xyz=\"0.17 0 0\""}},
    {"wrist_flex_link", {"<box size=\"0.08 0.07 0.07\"/>", "xyz=\"0 0 0\""}},
    {"gripper_palm_link", {"<box size=\"0.13 0.13 0.05\"/>", "xyz=\"0.08 0 0\""}},
    {"gripper_tool_frame", {nullptr, nullptr}}};

constexpr JointRow kJoints[] = {
    {"base_footprint_joint", "fixed", "base_footprint", "base_link", "0 0 0.05", nullptr, nullptr},
    {"torso_lift_joint", "prismatic", "base_link", "torso_lift_link", "-0.05 0 0.74", "0 0 1",
     "lower=\"0\" upper=\"0.33\" effort=\"5000\" velocity=\"0.02\""},
    {"shoulder_pan_joint", "revolute", "torso_lift_link", "shoulder_pan_link", "0 -0.19 0", "0 0 1",
     "lower=\"-2.2\" upper=\"0.7\" effort=\"30\" velocity=\"2.0\""},
    {"shoulder_lift_joint", "revolute", "shoulder_pan_link", "shoulder_lift_link", "0.1 0 0",
     "0 1 0", "lower=\"-0.5\" upper=\"1.35\" effort=\"30\" velocity=\"2.0\""},
    {"upper_arm_roll_joint", "revolute", "shoulder_lift_link", "upper_arm_link", "0 0 0", "1 0 0",
     "lower=\"-3.8\" upper=\"0.75\" effort=\"30\" velocity=\"3.0\""},
    {"elbow_flex_joint", "revolute", "upper_arm_link", "elbow_link", "0.4 0 0", "0 1 0",
     "lower=\"-2.25\" upper=\"-0.05\" effort=\"30\" velocity=\"3.0\""},
    {"forearm_roll_joint", "continuous", "elbow_link", "forearm_link", "0 0 0", "1 0 0",
     "effort=\"30\" velocity=\"3.5\""},
    {"wrist_flex_joint", "revolute", "forearm_link", "wrist_flex_link", "0.32 0 0", "0 1 0",
     "lower=\"-2.1\" upper=\"-0.05\" effort=\"10\" velocity=\"3.0\""},
    {"wrist_roll_joint", "continuous", "wrist_flex_link", "gripper_palm_link", "0 0 0", "1 0 0",
     "effort=\"10\" velocity=\"3.5\""},
    {"gripper_tool_joint", "fixed", "gripper_palm_link", "gripper_tool_frame", "0.18 0 0", nullptr,
     nullptr}};

/// A cylinder's axis is z in URDF; the arm's run along x.
bool liesAlongX(const LinkRow& link) {
  const std::string name = link.name;
  return name == "upper_arm_link" || name == "forearm_link";
}

void appendLink(std::string& out, const LinkRow& link) {
  out += std::string("  <link name=\"") + link.name + "\"";
  if (link.shape.geometry == nullptr) {
    out += "/>\n";
    return;
  }
  out += ">\n";
  for (const char* use : {"visual", "collision"}) {
    out += std::string("    <") + use + ">\n      <origin " + (liesAlongX(link) ? kAlongX : "") +
           link.shape.origin + "/>\n      <geometry>" + link.shape.geometry +
           "</geometry>\n    </" + use + ">\n";
  }
  out += "  </link>\n";
}

void appendJoint(std::string& out, const JointRow& joint) {
  out += std::string("  <joint name=\"") + joint.name + "\" type=\"" + joint.type +
         "\">\n    <parent link=\"" + joint.parent + "\"/>\n    <child link=\"" + joint.child +
         "\"/>\n    <origin xyz=\"" + joint.xyz + "\" rpy=\"0 0 0\"/>\n";
  if (joint.axis != nullptr) {
    out +=
        std::string("    <axis xyz=\"") + joint.axis + "\"/>\n    <limit " + joint.limit + "/>\n";
  }
  out += "  </joint>\n";
}

}  // namespace

std::string formatRobotUrdf() {
  std::string out = "<?xml version=\"1.0\"?>\n<robot name=\"teacher_robot\">\n";
  for (const LinkRow& link : kLinks) appendLink(out, link);
  for (const JointRow& joint : kJoints) appendJoint(out, joint);
  return out + "</robot>\n";
}

}  // namespace graft::lfd
