// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace graft::lfd {

using Polygon = std::vector<Eigen::Vector2d>;

/// Empty if the polygon is simple (at least three finite corners, area above
/// zero, no edge meets another but at the shared corner); else what is wrong.
std::string whyNotSimple(const Polygon& polygon);

/// Twice the area is above zero for counter-clockwise corners.
double signedArea(const Polygon& polygon);

/// True for a simple polygon without a corner that turns inwards.
bool isConvex(const Polygon& polygon);

/// Even-odd rule; points on the border may fall on either side.
bool insidePolygon(const Polygon& polygon, const Eigen::Vector2d& point);

double distanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b);

/// Cuts the closed segment a-b to the closed box; false if nothing is left.
/// Source: Liang and Barsky, "A new concept and method for line clipping", 1984.
bool clipToBox(Eigen::Vector2d& a, Eigen::Vector2d& b, const Eigen::Vector2d& low,
               const Eigen::Vector2d& high);

/// True if the closed polygon and the closed box share a point.
bool overlapsBox(const Polygon& polygon, const Eigen::Vector2d& low, const Eigen::Vector2d& high);

}  // namespace graft::lfd
