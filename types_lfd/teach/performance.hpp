// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/io/trajectory.hpp"
#include "types_lfd/teach/scenario.hpp"

namespace graft::lfd {

/// One demonstration as it truly was, in the world's frame; all three tracks
/// have a pose at each camera frame.
struct Performance {
  Trajectory hand;
  Trajectory object;
  Trajectory torso;
  double grasp_time = 0;    ///< stamp of the first frame with the handle in hand
  double release_time = 0;  ///< stamp of the last one
  Pose world_T_furniture;
};

/// The teacher's `index`-th demonstration: rest, minimum-jerk approach from
/// 0.7 to 1.2 m, manipulation with the hand on the handle up to the scenario's
/// slip, retreat; the torso follows, through the doorway where there is one.
Performance perform(const Scenario& scenario, int index, std::uint64_t seed,
                    const TeachOptions& options);

}  // namespace graft::lfd
