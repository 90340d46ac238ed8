// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "types_lfd/build/prepare.hpp"
#include "types_lfd/grasp/grasp_set.hpp"
#include "types_lfd/reach/reach_map.hpp"

namespace graft::lfd {

/// Consecutive tuples of one demonstration that no base could ever reach, for one
/// reason.
struct UnreachableRange {
  enum class Reason { kTooHigh, kTooLow, kTilt };
  Reason reason = Reason::kTilt;
  std::size_t first = 0;  ///< tuples
  std::size_t last = 0;
  double by = 0;  ///< largest over the range: m above or below reach, rad of tilt
};

/// The gripper as far as it can be told before anything is optimized: it takes
/// the grasp nearest to how the hands hold the object, and keeps its offset to
/// the hand (the paper's E6 and E7).
struct ExpectedGrasp {
  GraspSet::Choice choice;
  int row = 0;
  double distance = 0;  ///< from the hands' mean hold to the grasp, m
  double angle = 0;     ///< likewise, rad
};

/// What of a task the arm could reach if the base stood anywhere, obstacles or
/// not.
struct ReachCheck {
  ExpectedGrasp grasp;
  std::vector<std::vector<UnreachableRange>> ranges;  ///< per demonstration
  std::size_t tuples = 0;
  std::size_t unreachable = 0;
  ReachMap::Heights heights;  ///< of the gripper that any base reaches, m
};

/// All demonstrations hold the object in one way (taskOfMode). A tuple is out of
/// reach if no base pose has its gripper pose in the map; too high or low where
/// that holds for any orientation at this height, else tilted out of range, by
/// the least turn to an orientation in reach.
ReachCheck checkReach(const PreparedTask& task, const GraspSet& grasps, const ReachMap& reach);

/// "demo_07: 2.13 to 5.40 s (98 tuples): ..." with what to change, for people.
std::string describeRange(const PreparedDemonstration& demo, const UnreachableRange& range,
                          const ReachCheck& check);

}  // namespace graft::lfd
