// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "types_lfd/build/scene.hpp"
#include "types_lfd/eval/metrics.hpp"
#include "types_lfd/robot/arm_ik.hpp"

namespace graft::lfd {

/// One set for all tasks; lengths and speeds of a person-sized robot.
struct RefineOptions {
  /// A step with a joint faster than this multiple of its limit is avoided as
  /// far as possible (matched recordings have uneven, short steps).
  double speed_factor = 2;
  std::size_t stride = 5;       ///< tuples between the instants planned first
  std::size_t candidates = 14;  ///< base poses with an arm solution kept per instant
  std::size_t attempts = 60;    ///< base poses tried per instant
  int smoothing_sweeps = 6;
  std::uint64_t seed = 1;  ///< of the search for arm postures
  int threads = 0;         ///< 0 = all; the result is the same for any number
};

/// One demonstration after the last step.
struct RefinedTrack {
  std::vector<Pose2> base;
  IkTrack joints;
  std::size_t moved = 0;          ///< tuples whose base is not where it was
  double moved_distance = 0;      ///< sum of the distances (m) over moved tuples
  double moved_angle = 0;         ///< likewise of the turns (rad)
  double farthest = 0;            ///< largest distance, m
  double farthest_turn = 0;       ///< largest turn, rad
  std::size_t unresolved = 0;     ///< tuples that still collide, or are out of reach
  std::size_t blocked_steps = 0;  ///< neighbours with a collision between them
  /// Neighbours between which a joint needs more than speed_factor, or the base
  /// more than 1.5 m/s or 2 rad/s.
  std::size_t fast_steps = 0;
};

struct RefineResult {
  std::vector<RefinedTrack> tracks;  ///< as the demonstrations
  std::size_t tuples = 0;
  std::size_t moved = 0;
  double mean_distance = 0;  ///< m, over moved tuples
  double mean_turn = 0;      ///< rad
  double farthest = 0;       ///< m
  double farthest_turn = 0;  ///< rad
  std::size_t unresolved = 0;
  std::size_t blocked_steps = 0;
  std::size_t fast_steps = 0;
  std::size_t solved = 0;          ///< tuples with an arm configuration
  std::vector<std::string> notes;  ///< what could not be resolved, by demonstration
};

/// The last step of learning: bases that collide, are out of the arm's reach or
/// stand behind a wall from the gripper move to the nearest place that is none
/// of it, and arm configurations are found together with them. Gripper poses
/// are kept; a demonstration in which nothing is wrong is kept exactly.
///
/// Good are: the footprint free of the map, also between consecutive tuples
/// (FootprintChecker::pathFree); the lines in plan view from the shoulder (first
/// joint after the torso) to the wrist (last joint) and to the gripper free of
/// occupied cells; ReachMap::contains; an arm configuration, continuous along
/// the motion within speed_factor of the joints' speed limits. The height joint
/// is held per demonstration that is changed: torsos are slow.
///
/// Method: per demonstration a layered graph over every stride-th tuple: base
/// offsets from the optimized base, each with arm solutions continued from the
/// layer before; cheapest path by dynamic programming (size of the offsets over
/// time, their change, joint motion, penalties for joints or a base too fast);
/// between, the base goes straight unless both ends are where they were;
/// stretches in which that fails are planned again tuple by tuple. Other torso
/// heights, and then places up to a metre away, are tried where faults are left.
/// Last, offsets are smoothed and shrunk as far as nothing gets worse.
/// Never throws for what cannot be resolved: that is kept, counted and noted.
RefineResult refineBases(const std::vector<DemonstrationEstimate>& demonstrations,
                         const TaskScene& scene, const RefineOptions& options = RefineOptions());

}  // namespace graft::lfd
