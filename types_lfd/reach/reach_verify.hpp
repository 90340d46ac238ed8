// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "types_lfd/reach/reach_map.hpp"

namespace graft::lfd {

/// Tells truly, but slowly, whether the arm reaches a gripper pose in the base
/// frame. Called from one thread.
using ReachOracle = std::function<bool(const Pose& base_T_gripper)>;

/// Own inverse kinematics with this many restarts.
ReachOracle ikOracle(const Chain& chain, int restarts = 200);

/// How a map is tried.
struct ReachTrial {
  std::vector<Pose> reachable;    ///< forward kinematics of random joint vectors
  std::vector<Pose> unreachable;  ///< the oracle says so; next to reachable ones
};

/// `count` poses of each kind, in the base frame. The unreachable ones are poses
/// of random joint vectors moved in a random direction by up to `away` (m,
/// uniform), the gripper keeping its orientation, so that each lies within
/// `away` of the border of what is reachable with this very orientation.
ReachTrial sampleReachTrial(const Chain& chain, const ReachOracle& oracle, int count,
                            std::uint64_t seed, double away = 0.3);

struct ReachRates {
  double true_positive = 0;  ///< share of the reachable poses that the map holds
  double true_negative = 0;  ///< share of the unreachable ones that it does not
};

ReachRates measureRates(const ReachMap& map, const ReachTrial& trial);

}  // namespace graft::lfd
