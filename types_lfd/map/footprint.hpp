// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/se2.hpp"
#include "types_lfd/map/occupancy_map.hpp"
#include "types_lfd/map/polygon.hpp"

namespace graft::lfd {

/// Tests a robot's base against a map. The test is exact: the closed footprint
/// polygon (concave ones included) against every occupied cell as a closed
/// square; touching counts as collision. The distance field answers most
/// queries before any polygon is turned. The map must outlive the checker; the
/// checker may be used by many threads.
class FootprintChecker {
 public:
  /// `polygon`: corners (m) of a simple polygon in base_link, in either sense.
  /// Throws Error(kInput) where it is not simple.
  FootprintChecker(const OccupancyMap& map, Polygon polygon);

  bool inCollision(const Pose2& world_T_base) const;

  /// At most the distance (m) between footprint and nearest occupied cell:
  /// clearance of the bounding circle's centre less its radius, from below 0.
  double clearanceLowerBound(const Pose2& world_T_base) const;

  /// True if no base on the way from a to b collides: straight in x and y, the
  /// shorter way round in yaw, sampled so densely that no point of the
  /// footprint moves by more than half a cell between samples (both ends are
  /// sampled). A corner can thus cut into a cell by at most a quarter cell
  /// unseen.
  bool pathFree(const Pose2& a, const Pose2& b) const;

  /// Largest distance (m) of a footprint point from base_link.
  double reach() const { return reach_; }
  /// Radius (m) of the bounding circle used, and of the circle about the same
  /// centre that lies inside the polygon (0 if the centre is outside).
  double circumscribedRadius() const { return outer_; }
  double inscribedRadius() const { return inner_; }
  const Polygon& polygon() const { return polygon_; }

 private:
  bool exactCollision(const Pose2& world_T_base) const;

  const OccupancyMap* map_;
  Polygon polygon_;
  bool convex_ = false;
  Eigen::Vector2d center_ = Eigen::Vector2d::Zero();
  double outer_ = 0;
  double inner_ = 0;
  double reach_ = 0;
};

}  // namespace graft::lfd
