// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/map/polygon.hpp"

#include <algorithm>
#include <cmath>

namespace graft::lfd {

namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Where the c lies against the line a-b: 1 left, -1 right, 0 on it.
int side(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const double value = cross(b - a, c - a);
  return (value > 0) - (value < 0);
}

bool withinBox(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return c.x() >= std::min(a.x(), b.x()) && c.x() <= std::max(a.x(), b.x()) &&
         c.y() >= std::min(a.y(), b.y()) && c.y() <= std::max(a.y(), b.y());
}

bool segmentsMeet(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                  const Eigen::Vector2d& d) {
  const int abc = side(a, b, c);
  const int abd = side(a, b, d);
  const int cda = side(c, d, a);
  const int cdb = side(c, d, b);
  if (abc * abd < 0 && cda * cdb < 0) return true;
  return (abc == 0 && withinBox(a, b, c)) || (abd == 0 && withinBox(a, b, d)) ||
         (cda == 0 && withinBox(c, d, a)) || (cdb == 0 && withinBox(c, d, b));
}

/// One border of the Liang-Barsky clip; narrows [enter, leave].
bool clipBorder(double slope, double room, double& enter, double& leave) {
  if (slope == 0) return room >= 0;
  const double t = room / slope;
  if (slope < 0) {
    enter = std::max(enter, t);
  } else {
    leave = std::min(leave, t);
  }
  return enter <= leave;
}

}  // namespace

double signedArea(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  }
  return 0.5 * twice;
}

std::string whyNotSimple(const Polygon& polygon) {
  const std::size_t n = polygon.size();
  if (n < 3) return "a polygon needs at least 3 corners, this has " + std::to_string(n);
  for (const Eigen::Vector2d& corner : polygon) {
    if (!corner.allFinite()) return "a corner of the polygon is not finite";
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % n];
    const Eigen::Vector2d& c = polygon[(i + 2) % n];
    if (a == b) return "corner " + std::to_string(i + 1) + " of the polygon is given twice";
    // An edge that runs back over its predecessor encloses nothing.
    if (side(a, b, c) == 0 && (b - a).dot(c - b) < 0) {
      return "the polygon turns back at corner " + std::to_string((i + 1) % n + 1);
    }
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      if (segmentsMeet(a, b, polygon[j], polygon[(j + 1) % n])) {
        return "edges " + std::to_string(i + 1) + " and " + std::to_string(j + 1) +
               " of the polygon cross";
      }
    }
  }
  return signedArea(polygon) == 0 ? "the polygon has no area" : "";
}

bool isConvex(const Polygon& polygon) {
  const std::size_t n = polygon.size();
  const int turn = signedArea(polygon) > 0 ? 1 : -1;
  for (std::size_t i = 0; i < n; ++i) {
    if (side(polygon[i], polygon[(i + 1) % n], polygon[(i + 2) % n]) * turn < 0) return false;
  }
  return true;
}

bool insidePolygon(const Polygon& polygon, const Eigen::Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[j];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    if (point.x() < a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) {
      inside = !inside;
    }
  }
  return inside;
}

double distanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double length2 = along.squaredNorm();
  const double s = length2 > 0 ? std::clamp((point - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (a + s * along - point).norm();
}

bool clipToBox(Eigen::Vector2d& a, Eigen::Vector2d& b, const Eigen::Vector2d& low,
               const Eigen::Vector2d& high) {
  const Eigen::Vector2d d = b - a;
  double enter = 0;
  double leave = 1;
  for (int k = 0; k < 2; ++k) {
    if (!clipBorder(-d[k], a[k] - low[k], enter, leave)) return false;
    if (!clipBorder(d[k], high[k] - a[k], enter, leave)) return false;
  }
  const Eigen::Vector2d start = a;
  if (leave < 1) b = start + leave * d;
  if (enter > 0) a = start + enter * d;
  return true;
}

bool overlapsBox(const Polygon& polygon, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    Eigen::Vector2d a = polygon[j];
    Eigen::Vector2d b = polygon[i];
    if (clipToBox(a, b, low, high)) return true;
  }
  // No edge meets the box: it lies inside as a whole or not at all.
  return insidePolygon(polygon, 0.5 * (low + high));
}

}  // namespace graft::lfd
