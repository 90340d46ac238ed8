// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "types_lfd/demo/demonstration.hpp"

namespace graft::lfd {

/// A recording with known truth: a hand reaches for a drawer with minimum jerk,
/// holds it still, pulls it, holds it still, lets go and retreats.
struct SyntheticRecording {
  double start = 1000;    ///< stamp of the first sample, s
  double reach = 2.0;     ///< duration of reach, s
  double rest = 0.6;      ///< hand on the handle before and after the pull, s
  double pull = 3.0;      ///< duration of the pull, s
  double retreat = 1.2;   ///< duration of the retreat, s
  double lead = 0.5;      ///< hand at rest before reach and after retreat, s
  double hand_rate = 15;  ///< samples a second
  double object_rate = 12;
  double sigma_t = 0;  ///< white noise of the hand, m; the object has half of it
  double sigma_r = 0;  ///< the same, rad
  double way = 0.3;    ///< length of the pull, m
  double yaw = 0;      ///< direction from which the person comes, rad
  std::uint64_t seed = 1;

  double graspTime() const { return start + lead + reach; }
  double releaseTime() const { return graspTime() + 2 * rest + pull; }
  double endTime() const { return releaseTime() + retreat + lead; }
  Pose handAt(double time) const;
  Pose objectAt(double time) const;
  Demonstration record() const;
};

}  // namespace graft::lfd
