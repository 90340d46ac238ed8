// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/footprint.hpp"

#include <algorithm>
#include <cmath>

namespace graft::lfd {

namespace {

using Point = Eigen::Vector2d;

/// Twice the signed area of the triangle a b c.
double cross(const Point& a, const Point& b, const Point& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool inBox(const Point& a, const Point& b, const Point& p) {
  return std::min(a.x(), b.x()) <= p.x() && p.x() <= std::max(a.x(), b.x()) &&
         std::min(a.y(), b.y()) <= p.y() && p.y() <= std::max(a.y(), b.y());
}

int sign(double value) { return (value > 0) - (value < 0); }

/// True if the closed segments a b and c d share a point.
bool meet(const Point& a, const Point& b, const Point& c, const Point& d) {
  const int s1 = sign(cross(a, b, c));
  const int s2 = sign(cross(a, b, d));
  const int s3 = sign(cross(c, d, a));
  const int s4 = sign(cross(c, d, b));
  if (s1 * s2 < 0 && s3 * s4 < 0) return true;
  return (s1 == 0 && inBox(a, b, c)) || (s2 == 0 && inBox(a, b, d)) ||
         (s3 == 0 && inBox(c, d, a)) || (s4 == 0 && inBox(c, d, b));
}

std::string edgeName(std::size_t i, std::size_t n) {
  return std::to_string(i + 1) + "-" + std::to_string((i + 1) % n + 1);
}

}  // namespace

std::string footprintDefect(const std::vector<Eigen::Vector2d>& corners) {
  const std::size_t n = corners.size();
  if (n < 3) return "needs at least 3 corners, got " + std::to_string(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (corners[i] == corners[(i + 1) % n]) {
      return "corner " + std::to_string((i + 1) % n + 1) + " repeats the one before";
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Point& a = corners[i];
    const Point& b = corners[(i + 1) % n];
    // Neighbours share a corner; they may not fold back onto each other.
    const Point& c = corners[(i + 2) % n];
    if (cross(a, b, c) == 0 && (b - a).dot(c - b) < 0) {
      return "the edge after corner " + std::to_string((i + 1) % n + 1) + " folds back";
    }
    for (std::size_t j = i + 2; j < n; ++j) {
      if ((j + 1) % n == i) continue;
      if (meet(a, b, corners[j], corners[(j + 1) % n])) {
        return "the edges " + edgeName(i, n) + " and " + edgeName(j, n) + " cross";
      }
    }
  }
  return "";
}

}  // namespace graft::lfd
