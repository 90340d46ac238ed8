// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "types_lfd/build/prepare.hpp"

namespace graft::lfd {

/// Two demonstrations hold the object in the same way if their mean hand poses
/// on it are within these limits: the width of a palm (m), and what a wrist
/// turns about a handle without another hold (rad, 40 degrees).
constexpr double kSameGraspDistance = 0.10;
constexpr double kSameGraspAngle = 0.7;

/// Demonstrations that hold the object in one way.
struct GraspMode {
  std::vector<std::size_t> demonstrations;  ///< indices, rising
  double distance = 0;                      ///< largest between two of them, m
  double angle = 0;                         ///< likewise, rad
};

/// Whether two demonstrations hold the object in the same way.
bool sameGrasp(const GraspSpread& spread, std::size_t a, std::size_t b);

/// Groups demonstrations by complete linkage: any two of a mode hold the object in
/// the same way. Sorted by number of demonstrations, then by spread.
std::vector<GraspMode> findGraspModes(const GraspSpread& spread);

}  // namespace graft::lfd
