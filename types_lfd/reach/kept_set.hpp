// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "types_lfd/reach/reach_distance.hpp"
#include "types_lfd/reach/tilt_slice.hpp"

namespace graft::lfd {

/// The base poses, in the gripper's view, that reach one gripper pose and keep the
/// map's margins. The slice must outlive it.
class KeptSet {
 public:
  KeptSet(const TiltSlice& slice, double resolution, double margin_t, double margin_r)
      : slice_(slice),
        // Rounding of transforms between world and view must not leave the set.
        margin_(std::max(margin_t, kLeastMargin) * (ReachDistance::kDistanceUnits / resolution)),
        margin_r_(margin_r) {}

  /// How far inside, in the units of TiltSlice; negative outside. Continuous.
  double excess(const Pose2& b) const {
    double least = slice_.at(b);
    if (margin_r_ > 0) {
      least = std::min({least, slice_.at(Pose2(b.x, b.y, b.theta - margin_r_)),
                        slice_.at(Pose2(b.x, b.y, b.theta + margin_r_))});
    }
    return least - margin_;
  }
  bool keeps(const Pose2& b) const { return excess(b) >= 0; }
  /// The margin in the units of TiltSlice.
  double margin() const { return margin_; }

 private:
  static constexpr double kLeastMargin = 1e-6;
  const TiltSlice& slice_;
  double margin_;
  double margin_r_;
};

}  // namespace graft::lfd
