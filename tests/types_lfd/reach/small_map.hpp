// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tests/types_lfd/robot/small_robot.hpp"
#include "types_lfd/reach/reach_map.hpp"

namespace graft::lfd::testing {

/// Options that build a map of the small robot in a fraction of a second.
inline ReachOptions smallOptions() {
  ReachOptions options;
  options.resolution = 0.1;
  options.max_samples = std::uint64_t{1} << 17;
  return options;
}

/// The map of the small robot, built once per test program.
inline const ReachMap& smallMap() {
  static const ReachMap map = ReachMap::build(smallRobotChain(), smallOptions());
  return map;
}

inline Pose onFloor(const Pose2& base) {
  return Pose(Eigen::Vector3d(base.x, base.y, 0),
              expSO3<double>(Eigen::Vector3d(0, 0, base.theta)));
}

template <class Random>
double uniform(Random& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

}  // namespace graft::lfd::testing
