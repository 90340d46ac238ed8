// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "types_lfd/grasp/grasp_set.hpp"
#include "types_lfd/teach/scenario.hpp"

namespace graft::lfd {

constexpr int kGraspSamples = 40;
constexpr double kTaughtMinQuality = 0.5;

/// Grasps of a two-finger gripper on the handle bar: up to 4 cm along the bar,
/// a centimetre around it, turned about the bar by up to 25 degrees and less
/// otherwise. Quality falls from 1 to 0 with the distance from a centred, straight grasp; at
/// least ten reach kTaughtMinQuality.
std::vector<Grasp> sampleGrasps(const Scenario& scenario, std::uint64_t seed);

/// The text of a grasps.csv.
std::string formatGrasps(const std::vector<Grasp>& grasps);

}  // namespace graft::lfd
