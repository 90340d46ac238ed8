// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "types_lfd/build/weights.hpp"
#include "types_lfd/demo/match.hpp"
#include "types_lfd/demo/motion_noise.hpp"
#include "types_lfd/demo/segment.hpp"
#include "types_lfd/demo/task.hpp"
#include "types_lfd/grasp/grasp_set.hpp"

namespace graft::lfd {

/// Accuracy of the three trackers of a demonstration, given or estimated.
struct DemonstrationAccuracy {
  TrackerAccuracy hand;
  TrackerAccuracy object;
  TrackerAccuracy torso;
};

/// One demonstration, ready for the graph.
struct PreparedDemonstration {
  MatchedDemonstration matched;
  Segmentation segments;
  DemonstrationAccuracy accuracy;
  /// The hand holds the object turned by half a turn about the approach axis
  /// against the other demonstrations (grasp_modes.hpp): the same grasp for a
  /// parallel gripper.
  bool hand_turned = false;

  std::size_t size() const { return matched.size(); }
  bool manipulating(std::size_t i) const { return i >= segments.grasp && i <= segments.release; }
  MotionPhase phase(std::size_t i) const {
    return motionPhase(matched.times, segments.grasp, segments.release, i);
  }
  /// object_T_hand of tuple i as matched.
  Pose objectToHand(std::size_t i) const {
    return matched.object.poses[i].inverse() * matched.hand.poses[i];
  }
  /// The matched hand of tuple i as a gripper would take its place: turned back
  /// where the hand is turned.
  Pose gripperLikeHand(std::size_t i) const {
    return hand_turned ? flippedGrasp(matched.hand.poses[i]) : matched.hand.poses[i];
  }
};

/// A task after the stages read, clean, match and segment.
struct PreparedTask {
  Task task;
  Weights weights;
  std::vector<PreparedDemonstration> demonstrations;
  std::size_t tupleCount() const;
};

/// Runs the stages up to the graph. Remarks (estimated torso, removed outliers,
/// estimated accuracy) and defects go to `diagnostics`; throws where the task
/// cannot be used.
PreparedTask prepareTask(const std::string& task_path, Diagnostics& diagnostics);

/// Mean of poses: arithmetic in translation, Frechet mean (geodesic) in
/// rotation. At least one pose.
Pose meanPose(const std::vector<Pose>& poses);

}  // namespace graft::lfd
