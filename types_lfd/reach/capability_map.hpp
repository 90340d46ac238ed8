// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

namespace graft::lfd {

/// A cube of space, and the shape that the directions of approach from which
/// its centre can be reached form there.
struct Capability {
  enum class Shape : std::uint8_t {
    kEmpty = 0,      ///< none
    kSphere = 1,     ///< all
    kCone = 2,       ///< within half_angle of the axis
    kCylinder1 = 3,  ///< within half_angle of the axis or of its opposite
    kCylinder2 = 4,  ///< within half_angle of the plane across the axis
  };
  Shape shape = Shape::kEmpty;
  double phi = 0;                                    ///< azimuth of the axis, rad
  double theta = 0;                                  ///< angle of the axis from z, rad
  double half_angle = 0;                             ///< rad
  double shape_fit_error = 0;                        ///< percent
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< m, in the base frame
  double edge = 0;                                   ///< of the cube, m

  Eigen::Vector3d axis() const;
  /// Is the approach direction (gripper's x axis in the base frame) covered?
  bool covers(const Eigen::Vector3d& direction) const;
  /// Share of all directions that is covered, 0 .. 1.
  double share() const;
};

/// A capability map as published by the paper's group (capability_map, `.cpm`):
/// an octree of Capability in the frame of the arm's base link.
/// Source: Zacharias, Borst, Hirzinger, "Capturing robot workspace structure:
/// representing robot capabilities", IROS 2007.
class CapabilityMap {
 public:
  /// Throws Error(kInput) with the path (and the line, in the text header) for
  /// a file that is no such map.
  static CapabilityMap load(const std::string& path);

  double resolution() const { return resolution_; }
  const std::string& groupName() const { return group_; }
  const std::string& baseLink() const { return base_; }
  const std::string& tipLink() const { return tip_; }
  /// All leaves that are not empty; equal neighbours may be one larger cube.
  const std::vector<Capability>& capabilities() const { return capabilities_; }

  /// What is at a place (m, base frame); null where nothing can be reached.
  const Capability* find(const Eigen::Vector3d& position) const;

 private:
  friend class CapabilityReader;

  double resolution_ = 0;
  std::string group_;
  std::string base_;
  std::string tip_;
  std::vector<Capability> capabilities_;
  std::unordered_map<std::uint64_t, std::size_t> index_;  // depth and key -> capability
};

}  // namespace graft::lfd
