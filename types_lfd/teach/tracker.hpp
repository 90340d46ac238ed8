// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/io/trajectory.hpp"
#include "types_lfd/teach/random.hpp"

namespace graft::lfd {

/// How a camera sees a marker.
struct TrackerModel {
  double sigma_t = 0;        ///< standard deviation per axis, m, white and slow part together
  double sigma_r = 0;        ///< per axis of the rotation vector in the marker's frame, rad
  double white_share = 0.6;  ///< of the variance; the rest is slow (Gauss-Markov)
  double slow_time = 1.0;    ///< s, correlation time of the slow part
  int skip_every = 0;        ///< every n-th camera frame is not processed (0 = all are)
  double miss = 0;           ///< probability that a single frame is lost
  int bursts = 0;            ///< at most so many occlusions of 4 to 10 frames, at least 1
};

/// What the tracker reports of a true track: noise on translation (in the world)
/// and rotation (in the marker's frame), frames left out. Up to three frames at
/// either end are missing, so that tracks differ in length.
Trajectory observe(const Trajectory& truth, const TrackerModel& tracker, Random& random);

}  // namespace graft::lfd
