// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "types_lfd/robot/urdf.hpp"

namespace graft::lfd {

/// A simple solid somewhere in space: a box, a cylinder (axis along its z) or a
/// sphere around `center`.
struct PlacedSolid {
  UrdfSolid::Type type = UrdfSolid::Type::kSphere;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  /// Box: half edges; cylinder: radius, half length, 0; sphere: radius, 0, 0. m.
  Eigen::Vector3d half = Eigen::Vector3d::Zero();

  /// Radius of the sphere around `center` that holds it, m.
  double bound() const;
};

/// Smallest distance (m) between two solids, 0 where they touch or overlap.
/// To 1e-6 m. Source: Gilbert, Johnson, Keerthi, "A fast procedure for
/// computing the distance between complex objects in three-dimensional space",
/// IEEE J-RA 1988.
double solidDistance(const PlacedSolid& a, const PlacedSolid& b);

/// Whether two solids are less than 1e-7 m apart; ends as soon as a plane between
/// them is found.
bool solidsOverlap(const PlacedSolid& a, const PlacedSolid& b);

}  // namespace graft::lfd
