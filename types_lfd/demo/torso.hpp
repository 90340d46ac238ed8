// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "types_lfd/demo/match.hpp"

namespace graft::lfd {

struct TorsoOptions {
  double distance = 0.6;   ///< planar distance from the hand, m: a comfortable reach
  double height = 1.0;     ///< nominal height of the torso over the floor, m
  double smoothing = 0.5;  ///< sigma of the Gaussian over time, s: a body sways slower
};

/// Torso of a person whose torso was not tracked, from hand and object (one
/// pose per tuple, all flagged interpolated):
///  - approach direction: planar mean over all tuples of the way that the hand
///    has yet to go to where it touches the object (the contact point, a fixed
///    point of the object, is where the hand is nearest to rest relative to
///    it). Reach and retreat both lie on the person's side, so both count
///    equally, tracker noise averages out, and the direction is one per
///    demonstration: it cannot spin. Where the hand keeps within 5 cm of the
///    contact point, the mean planar direction of the fingers (x axis).
///  - position: `distance` behind the hand along that direction, the hand's
///    path smoothed in time; height nominal.
///  - orientation: upright, x axis along the approach direction, so facing the
///    hand.
MatchedTrack estimateTorso(const MatchedDemonstration& matched, const TorsoOptions& options = {});

}  // namespace graft::lfd
