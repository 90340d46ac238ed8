// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "types_lfd/build/prepare.hpp"
#include "types_lfd/grasp/grasp_set.hpp"
#include "types_lfd/map/footprint.hpp"
#include "types_lfd/reach/reach_map.hpp"

namespace graft::lfd {

/// All trajectories of one demonstration at the matched stamps, in the fixed
/// frame: human, object and robot.
struct DemonstrationEstimate {
  std::string name;
  std::vector<double> times;
  std::vector<Pose> hand;
  std::vector<Pose> object;
  std::vector<Pose> torso;
  std::vector<Pose> gripper;
  std::vector<Pose2> base;
  Segmentation segments;
  bool hand_turned = false;  ///< see PreparedDemonstration
  std::size_t size() const { return times.size(); }
};

/// What is given: gripper = hand (turned back where it is turned), base = torso made upright
/// ("before").
DemonstrationEstimate estimateFromInput(const PreparedDemonstration& demo);

/// Rows of the paper's Table I; empty where a row is undefined.
struct Table1 {
  /// Mean over demonstrations of the distance (m) and angle (rad) between the
  /// gripper at the grasp tuple, seen from the object, and the valid grasp
  /// nearest to it by E6's metric.
  double gripper_grasp_m = 0;
  double gripper_grasp_rad = 0;
  /// Mean over all tuples of distance and angle between gripper and hand. Here
  /// and below the hand of a demonstration that is turned counts turned back.
  std::optional<double> gripper_hand_m;
  std::optional<double> gripper_hand_rad;
  /// Spread of the gripper (hand) seen from the object over all manipulation
  /// tuples of all demonstrations: sqrt of the mean squared distance to the
  /// mean, in translation and (geodesic) rotation.
  double gripper_object_sd_m = 0;
  double gripper_object_sd_rad = 0;
  double hand_object_sd_m = 0;
  double hand_object_sd_rad = 0;
  /// Shares 0..1 of all tuples.
  std::optional<double> map_collision_free;
  double kinematically_achievable = 0;
  std::optional<double> ik_achievable;
};

/// What the metrics are measured against. `footprint` null = no map.
struct Scene {
  const GraspSet* grasps = nullptr;
  const ReachMap* reach = nullptr;
  const FootprintChecker* footprint = nullptr;
  Sigma grasp_metric;  ///< sigmas of E6
};

/// `before`: gripper and hand are the same thing, their distance is undefined.
Table1 computeTable1(const std::vector<DemonstrationEstimate>& demonstrations, const Scene& scene,
                     bool before);

/// Weighted squared E1 residual per degree of freedom over all measured poses
/// of hand and object: near 1 if the estimates agree with the trackers' stated
/// accuracy.
double observationResidualPerDof(const std::vector<PreparedDemonstration>& input,
                                 const std::vector<DemonstrationEstimate>& estimates);

}  // namespace graft::lfd
