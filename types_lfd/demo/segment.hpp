// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "types_lfd/demo/match.hpp"

namespace graft::lfd {

/// Tuple indices: reaching is i < grasp, manipulation grasp <= i <= release,
/// retreat i > release; the grasp pose is the tuple at grasp.
struct Segmentation {
  std::size_t grasp = 0;
  std::size_t release = 0;
  /// Share of the tuples from the object's first to its last motion that lie in
  /// manipulation. Well below 1: the object was held more than once, or moved
  /// by something else; worth a warning.
  double motion_share = 1;
};

/// None of these is a property of a tracker; what depends on noise is taken
/// from the demonstration itself.
struct SegmentOptions {
  double moved_distance = 0.03;  ///< least way of an object that was moved, m
  double moved_angle = 0.087;    ///< or least turn, rad (5 degrees)
  double reach = 0.3;            ///< half the reach of an arm, m: beyond, the body walks
  double settle = 1.0;           ///< time in which the hand's place on the object is constant, s
  double shortest = 0.4;         ///< shortest and longest duration of a reach, s
  double longest = 4.0;
  double near = 0.025;      ///< further off (beyond noise) a hand holds nothing, m: a thick handle
  double softness = 0.005;  ///< what a palm gives way on a handle, sigma, m
  double step = 0.02;       ///< step of the search for the moment of contact, s
};

/// Finds when the hand takes and lets go of the object.
///
/// Coarsely: the run of tuples in which the hand stays at one point of the
/// object while the object is moved (findContact). Finely, at both ends: the
/// object rests or is about to, so its motion tells nothing; but hands reach
/// with minimum jerk (Flash and Hogan, "The coordination of arm movements",
/// 1985), which ends so gently that the last 0.3 to 0.7 s drown in tracker
/// noise. So the distance profile of such a movement (its second half, after
/// peak speed), followed by rest, is fitted to the hand's position in the
/// object frame by least squares over the moment of contact and the duration;
/// the earliest moment within two standard deviations of the best is taken, as
/// a grasp too late costs accuracy and one too early does not.
///
/// `grasp_time` and `release_time` (s), where given, override: the nearest tuple
/// is taken (they must lie in the matched span); with both given the object may
/// also stand still.
/// Throws Error(kInput) naming the demonstration where the object never moves,
/// the hand touches it from the first tuple on, or a given time does not fit.
Segmentation segmentDemonstration(const MatchedDemonstration& matched,
                                  const SegmentOptions& options = {},
                                  std::optional<double> grasp_time = {},
                                  std::optional<double> release_time = {});

}  // namespace graft::lfd
