// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/geometry/se3.hpp"

namespace graft::lfd {

/// This joint follows another: q = multiplier * q_joint + offset.
struct UrdfMimic {
  std::string joint;
  double multiplier = 1;
  double offset = 0;
};

/// A joint of a URDF: parent_T_child = parent_T_joint * motion(q), where the
/// motion turns about (rad) or slides along (m) the unit vector `axis`, given
/// in the joint's frame.
struct UrdfJoint {
  enum class Type { kFixed, kRevolute, kContinuous, kPrismatic, kOther };

  std::string name;
  std::string parent;
  std::string child;
  Type type = Type::kFixed;
  Pose parent_T_joint;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  double lower = 0;     ///< rad or m; 0 for a continuous joint
  double upper = 0;     ///< rad or m; 0 for a continuous joint
  double velocity = 0;  ///< rad/s or m/s; 0 = the file states none
  std::optional<UrdfMimic> mimic;
  int line = 0;

  bool moves() const { return type != Type::kFixed; }
};

/// A simple solid of a link's <collision>. Meshes are never opened.
struct UrdfSolid {
  enum class Type { kBox, kCylinder, kSphere };
  Type type = Type::kBox;
  Pose link_T_solid;
  /// Box: edge lengths; cylinder: radius, length (along z), 0; sphere: radius, 0, 0. m.
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
};

struct UrdfLink {
  std::string name;
  std::vector<UrdfSolid> collision;
  int meshes = 0;  ///< <collision> elements with a mesh
  int line = 0;
};

/// A robot as its URDF describes it, in the order of the file.
struct UrdfModel {
  std::string name;
  std::string path;
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;

  /// Index of a link, or -1.
  int findLink(const std::string& link) const;
  /// Index of the joint whose child is `link`, or -1 for a root.
  int jointAbove(const std::string& link) const;
};

/// Reads a URDF (http://wiki.ros.org/urdf/XML). Defects of joints, links and of
/// the tree as a whole go to `diagnostics` with their lines, all in one run; the
/// model is usable only if no error was added. Throws Error(kInput) where the
/// file is no XML, no <robot>, or an unexpanded xacro file.
UrdfModel readUrdf(const std::string& path, Diagnostics& diagnostics);

/// The same for a text in memory; `path` is for messages.
UrdfModel readUrdfText(const std::string& path, const std::string& content,
                       Diagnostics& diagnostics);

/// Second half of reading: is this one tree, with each name once? Adds what is
/// wrong to `diagnostics`.
void checkUrdfTree(const UrdfModel& model, Diagnostics& diagnostics);

}  // namespace graft::lfd
