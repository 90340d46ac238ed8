// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "types_lfd/demo/demonstration.hpp"

namespace graft::lfd {

/// Fastest motion that is believed.
struct SpeedLimit {
  double linear = 0;   ///< m/s
  double angular = 0;  ///< rad/s
};

struct CleanOptions {
  // What people do at most while they handle furniture, with a margin of two:
  // a hand reaches at 1 to 1.5 m/s, a walking body at 1 m/s turns by 180 deg/s.
  SpeedLimit hand{3.0, 12.57};
  SpeedLimit object{2.0, 6.28};
  SpeedLimit torso{2.0, 6.28};
  std::size_t window = 7;  ///< samples of a local line; it stands up to 3 bad ones
  /// Limit in sigmas of a 3-D vector: 2e-4 of clean normal ones are longer.
  double sigmas = 4.5;
  // Smaller errors are the optimizer's business; people also accelerate.
  double least_shift = 0.05;  ///< m
  double least_turn = 0.26;   ///< rad (15 degrees)
};

/// How many samples of a track were dropped, and by what.
struct CleanCounts {
  std::size_t samples = 0;  ///< before
  std::size_t speed = 0;    ///< not reachable at the believed speed
  std::size_t spikes = 0;   ///< off the local line
  std::size_t dropped() const { return speed + spikes; }
};

struct CleanReport {
  CleanCounts hand;
  CleanCounts object;
  CleanCounts torso;
  std::size_t dropped() const { return hand.dropped() + object.dropped() + torso.dropped(); }
  /// "hand: 3 of 130 poses dropped (2 too fast, 1 spike); ...": tracks that lost
  /// nothing are left out; empty if none did.
  std::string text() const;
};

/// Drops samples of one track in place, in two steps:
///  1. Speed: the longest chain of samples in which each can be reached from
///     the one before at the speed limit (plus five sigma of the track's own
///     noise) is kept. So a first sample or a burst that is wrong cannot throw
///     out the right ones.
///  2. Spikes: a sample is dropped where it is off the line of its neighbours
///     (repeated medians over `window` samples, at an occlusion those on one side
///     of it; rotation as vectors about the window's medoid) by more than `sigmas`
///     times the track's, or if that is more the window's, own scatter, and by
///     more than the least sizes: a Hampel filter that follows motion.
/// Throws Error(kInput) where the chain holds less than half of the samples: it
/// is then unknown which part is right.
CleanCounts removeOutliers(Trajectory& track, const SpeedLimit& limit,
                           const CleanOptions& options = {});

/// The same for the tracks of a demonstration, which keeps the dropped stamps;
/// errors name it and the track.
/// The caller prints `text()` of the report: nothing is dropped silently.
CleanReport removeOutliers(Demonstration& demonstration, const CleanOptions& options = {});

}  // namespace graft::lfd
