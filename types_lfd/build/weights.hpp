// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "types_lfd/demo/task.hpp"

namespace graft::lfd {

/// Standard deviation of an edge's error: m and rad (for steady motion m/s and
/// rad/s per square root of a second).
struct Sigma {
  double t = 0;
  double r = 0;
};

/// The kinds of edges, by the names that <weights edge="..."> and metrics.json
/// use. E1's weight is the tracker's accuracy and not listed.
struct Weights {
  /// E2, as a multiple of the tracker's sigma: the observed motion between two
  /// tuples has sqrt(2) of the noise of a pose, and that noise is in E1 already;
  /// three times keeps E2 from carrying it along.
  double relative_motion_factor = 3;
  /// E2 between interpolated poses is trusted this much less again.
  double interpolated_factor = 2;
  /// Change of velocity in one second (white-noise acceleration): people move
  /// furniture, and reach for it, smoothly at the rate of a tracker. How
  /// smoothly is found from the tracks, around this and separately for what
  /// moves free, makes or loses contact, and is held; given in the task, it holds
  /// for all of these. Not across the instants of grasp and release, where a hand
  /// stops or starts at once: held there, too, its momentum pushes the learned
  /// grasp off by up to a centimetre.
  Sigma steady_motion{0.05, 0.2};
  Sigma steady_hand_free = steady_motion;
  Sigma steady_hand_contact = steady_motion;
  Sigma steady_hand_held = steady_motion;
  Sigma steady_object_free = steady_motion;
  Sigma steady_object_contact = steady_motion;
  Sigma steady_object_held = steady_motion;
  /// E3: a step may be as long as the demonstrated one, times this (paper:
  /// "scaled by the distance between the poses"), and at least the floor below.
  double smooth_factor = 1;
  Sigma smooth_floor{0.02, 0.05};
  /// E4, E5: a rigid grasp; the level of the paper's spreads after optimization
  /// (0.1 to 0.5 cm) needs well below a millimetre per edge.
  Sigma human_grasp{0.0005, 0.0044};
  Sigma robot_grasp{0.0005, 0.0044};
  /// E6 against E8 and E9: a sampled grasp is one that holds, so the gripper goes
  /// right there; base and offset to the hand adapt.
  Sigma grasp_quality{0.0001, 0.00057};
  /// E7: how closely the gripper follows the hand from tuple to tuple.
  Sigma hand_gripper{0.02, 0.14};
  /// E8: one edge speaks for a whole demonstration, while what a grasp changes for
  /// the gripper's path and the base is summed over all tuples. At a centimetre the
  /// valid grasp nearest to the person's is mostly the cheapest one, too; at five the
  /// sums often outweigh it, at 0.7 it pulls the hand off its track. In E6's proportion of
  /// m to rad, so that both call the same grasp near.
  Sigma resemblance{0.01, 0.057};
  /// E9: high weight; an arm misses what is a centimetre out of reach.
  Sigma reachability{0.01, 0.05};
  /// E10: grasp poses of two demonstrations.
  Sigma grasp_agreement{0.01, 0.087};
  /// Base's absolute position: low weight; an arm's length and a radian.
  Sigma base_prior{0.5, 1.0};
};

/// Defaults with the task's overrides. `edge` may be a name of metrics.json
/// ("grasp_quality") or the paper's number ("E6"). An unknown name is an error
/// with its line that lists the names.
Weights weightsFor(const Task& task, Diagnostics& diagnostics);

/// All weights by name, for metrics.json.
std::map<std::string, Sigma> namedWeights(const Weights& weights);

}  // namespace graft::lfd
