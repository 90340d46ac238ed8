// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/map/footprint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace graft::lfd {

namespace {

/// Centre of a nearly smallest bounding circle: steps of falling size towards
/// the farthest corner. Source: Badoiu and Clarkson, "Smaller core-sets for
/// balls", 2003.
Eigen::Vector2d boundingCenter(const Polygon& polygon) {
  constexpr int kSteps = 400;
  Eigen::Vector2d low = polygon.front();
  Eigen::Vector2d high = low;
  for (const Eigen::Vector2d& corner : polygon) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  Eigen::Vector2d center = 0.5 * (low + high);
  const auto radius = [&polygon](const Eigen::Vector2d& c) {
    double farthest = 0;
    for (const Eigen::Vector2d& corner : polygon)
      farthest = std::max(farthest, (corner - c).norm());
    return farthest;
  };
  Eigen::Vector2d best = center;
  double best_radius = radius(center);
  for (int i = 1; i <= kSteps; ++i) {
    const auto farthest =
        std::max_element(polygon.begin(), polygon.end(), [&center](const auto& a, const auto& b) {
          return (a - center).squaredNorm() < (b - center).squaredNorm();
        });
    center += (*farthest - center) / (i + 1);
    const double r = radius(center);
    if (r < best_radius) {
      best_radius = r;
      best = center;
    }
  }
  return best;
}

/// Extent in x of the polygon within the strip low <= y <= high; false if it
/// does not reach into it. Extremes lie on edges, so edges are enough.
bool extentInStrip(const Polygon& polygon, double low, double high, double& left, double& right) {
  constexpr double kFar = std::numeric_limits<double>::max();
  left = kFar;
  right = -kFar;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    Eigen::Vector2d a = polygon[j];
    Eigen::Vector2d b = polygon[i];
    if (a.y() > b.y()) std::swap(a, b);
    if (a.y() > high || b.y() < low) continue;
    const double slope = b.y() > a.y() ? (b.x() - a.x()) / (b.y() - a.y()) : 0.0;
    const double start = a.y() < low ? a.x() + slope * (low - a.y()) : a.x();
    const double stop = b.y() > high ? a.x() + slope * (high - a.y()) : b.x();
    left = std::min({left, start, stop});
    right = std::max({right, start, stop});
  }
  return left <= right;
}

}  // namespace

FootprintChecker::FootprintChecker(const OccupancyMap& map, Polygon polygon)
    : map_(&map), polygon_(std::move(polygon)) {
  const std::string defect = whyNotSimple(polygon_);
  if (!defect.empty()) throw Error(ExitCode::kInput, "footprint: " + defect);
  convex_ = isConvex(polygon_);
  center_ = boundingCenter(polygon_);
  inner_ = std::numeric_limits<double>::max();
  for (std::size_t i = 0, j = polygon_.size() - 1; i < polygon_.size(); j = i++) {
    outer_ = std::max(outer_, (polygon_[i] - center_).norm());
    reach_ = std::max(reach_, polygon_[i].norm());
    inner_ = std::min(inner_, distanceToSegment(center_, polygon_[j], polygon_[i]));
  }
  if (!insidePolygon(polygon_, center_)) inner_ = 0;
}

bool FootprintChecker::inCollision(const Pose2& world_T_base) const {
  if (map_->occupiedCount() == 0) return false;
  const Eigen::Vector2d center = world_T_base * center_;
  const OccupancyMap::Bounds bounds = map_->clearanceBounds(center.x(), center.y());
  if (bounds.low > outer_) return false;
  if (bounds.high < inner_) return true;
  return exactCollision(world_T_base);
}

bool FootprintChecker::exactCollision(const Pose2& world_T_base) const {
  // One buffer per thread: no allocation in the loops of a planner.
  thread_local Polygon turned;
  turned.resize(polygon_.size());
  double bottom = std::numeric_limits<double>::max();
  double top = -bottom;
  const double c = std::cos(world_T_base.theta);
  const double s = std::sin(world_T_base.theta);
  for (std::size_t i = 0; i < polygon_.size(); ++i) {
    const Eigen::Vector2d& p = polygon_[i];
    turned[i] = map_->toGrid(world_T_base.x + c * p.x() - s * p.y(),
                             world_T_base.y + s * p.x() + c * p.y());
    bottom = std::min(bottom, turned[i].y());
    top = std::max(top, turned[i].y());
  }
  // Closed cells: a border that lies on a grid line touches both its rows.
  if (!(top >= 0 && bottom <= map_->height())) return false;
  const int first_row = static_cast<int>(std::max(0.0, std::ceil(bottom) - 1));
  const int last_row = static_cast<int>(std::min(map_->height() - 1.0, std::floor(top)));
  for (int row = first_row; row <= last_row; ++row) {
    double left = 0;
    double right = 0;
    if (!extentInStrip(turned, row, row + 1.0, left, right)) continue;
    if (right < 0 || left > map_->width()) continue;
    const int last = static_cast<int>(std::min(map_->width() - 1.0, std::floor(right)));
    int column = static_cast<int>(std::max(0.0, std::ceil(left) - 1));
    if (column > last) continue;
    for (column = map_->nextOccupied(column, row); column <= last;
         column = column < last ? map_->nextOccupied(column + 1, row) : last + 1) {
      // A convex polygon fills its extent in the strip without a gap.
      if (convex_ || overlapsBox(turned, {column, row}, {column + 1, row + 1})) return true;
    }
  }
  return false;
}

double FootprintChecker::clearanceLowerBound(const Pose2& world_T_base) const {
  const Eigen::Vector2d center = world_T_base * center_;
  return std::max(0.0, map_->clearance(center.x(), center.y()) - outer_);
}

bool FootprintChecker::pathFree(const Pose2& a, const Pose2& b) const {
  const double turn = wrapAngle(b.theta - a.theta);
  const double motion = std::hypot(b.x - a.x, b.y - a.y) + reach_ * std::abs(turn);
  const double steps = std::max(1.0, std::ceil(motion / (0.5 * map_->resolution())));
  double i = 0;  // a number that may exceed what an int holds
  while (i <= steps) {
    const double f = i / steps;
    const Pose2 base =
        i == steps ? b : Pose2(a.x + f * (b.x - a.x), a.y + f * (b.y - a.y), a.theta + f * turn);
    if (inCollision(base)) return false;
    ++i;
  }
  return true;
}

}  // namespace graft::lfd
