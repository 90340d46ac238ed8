// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/geometry/se3.hpp"
#include "types_lfd/demo/demonstration.hpp"

namespace graft::lfd {

/// One track at the matched stamps.
struct MatchedTrack {
  std::vector<Pose> poses;
  std::vector<char> measured;  ///< 1 = the track has this stamp, 0 = interpolated

  std::size_t measuredCount() const;
};

/// The tracks of a demonstration as tuples: entry i of each belongs to times[i].
struct MatchedDemonstration {
  std::string name;
  std::vector<double> times;  ///< s, rising strictly
  MatchedTrack hand;
  MatchedTrack object;
  MatchedTrack torso;
  bool torso_estimated = false;

  std::size_t size() const { return times.size(); }
};

/// Poses of a track at given stamps (rising, within the track's span): those it
/// has are copied bit by bit, others are interpolated between the neighbours,
/// linearly in translation and by slerp on the shorter arc in rotation.
MatchedTrack resample(const Trajectory& track, const std::vector<double>& times);

/// Brings the tracks of a demonstration to common stamps (paper, section III):
/// the sorted union of all tracks' stamps within the span that all of them
/// cover (stamps of dropped outliers included, so that cleaning changes no
/// tuple's time); stamps that are exactly equal become one. Nothing is extrapolated.
/// A missing torso is estimated from the hand (torso.hpp) and flagged.
/// Throws Error(kInput) naming the demonstration and the tracks' intervals
/// where fewer than 2 tuples result.
MatchedDemonstration matchTracks(const Demonstration& demonstration);

}  // namespace graft::lfd
