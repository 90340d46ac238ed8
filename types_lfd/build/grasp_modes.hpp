// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "types_lfd/build/prepare.hpp"

namespace graft::lfd {

/// Two demonstrations hold the object in the same way if their mean hand poses
/// on it are within these limits: the width of a palm (m), and what a wrist
/// turns about a handle without another hold (rad, 40 degrees).
constexpr double kSameGraspDistance = 0.10;
constexpr double kSameGraspAngle = 0.7;

/// How far two holds (object_T_hand) are apart. A parallel gripper is the same
/// both ways round, so of the second hold and the same turned by half a turn
/// about its approach (x) axis the nearer counts.
struct HoldGap {
  double distance = 0;  ///< m
  double angle = 0;     ///< rad, at most half a turn less what `turned` takes off
  bool turned = false;  ///< the half turn was taken
  bool same() const { return distance <= kSameGraspDistance && angle <= kSameGraspAngle; }
};
HoldGap holdGap(const Pose& object_T_hand_a, const Pose& object_T_hand_b);

/// Where each demonstration's hand holds the object.
struct GraspSpread {
  std::vector<Pose> object_T_hand;  ///< per demonstration, mean over manipulation
  double distance = 0;              ///< largest gap between two demonstrations, m
  double angle = 0;                 ///< likewise, rad
};
GraspSpread graspSpread(const std::vector<PreparedDemonstration>& demonstrations);

/// Demonstrations that hold the object in one way.
struct GraspMode {
  std::vector<std::size_t> demonstrations;  ///< indices, rising
  double distance = 0;                      ///< largest between two of them, m
  double angle = 0;                         ///< likewise, rad
};

/// Groups demonstrations by complete linkage: any two of a mode hold the object in
/// the same way. Sorted by number of demonstrations (most first), then by spread
/// (distance, angle), then by the first demonstration.
std::vector<GraspMode> findGraspModes(const GraspSpread& spread);

/// The ways in which a task's demonstrations hold the object.
struct RecordedHolds {
  std::vector<std::string> names;  ///< of all demonstrations of the task
  GraspSpread spread;
  std::vector<GraspMode> modes;  ///< as findGraspModes() sorts them

  /// There is something to learn: a mode has two demonstrations, or there is
  /// but one demonstration.
  bool common() const { return names.size() == 1 || modes.front().demonstrations.size() > 1; }
};
RecordedHolds recordedHolds(const std::vector<PreparedDemonstration>& demonstrations);

/// The part of a task that one mode demonstrates, with the hands that are
/// turned against the mode's majority marked (ties: the first demonstration is
/// not turned). Marks are notes in `diagnostics` with the demonstrations'
/// lines. `mode` is an index into holds.modes.
PreparedTask taskOfMode(const PreparedTask& task, const RecordedHolds& holds, std::size_t mode,
                        Diagnostics& diagnostics);

/// describeLeftOut() as warnings at the demonstrations' lines.
void warnOfLeftOut(const PreparedTask& task, const RecordedHolds& holds, std::size_t mode,
                   Diagnostics& diagnostics);

/// Reads a task and keeps the mode that most demonstrations show; warns of the
/// demonstrations that are left out. Throws as
/// prepareTask() does, and Error(kNoResult) where no two hold the object alike.
PreparedTask prepareUsualMode(const std::string& task_path, Diagnostics& diagnostics);

/// Which of these demonstrations hold the object turned by half a turn against
/// the majority. All of them are of one mode.
std::vector<char> turnedHands(const std::vector<Pose>& object_T_hand);

/// Which demonstrations are not of the mode, and by how much they differ from
/// those that are; one line each.
std::vector<std::string> describeLeftOut(const RecordedHolds& holds, std::size_t mode);

/// Which demonstrations disagree about the grasp, and by how much; one line a
/// pair that is too far apart.
std::vector<std::string> describeDisagreement(const RecordedHolds& holds);

}  // namespace graft::lfd
