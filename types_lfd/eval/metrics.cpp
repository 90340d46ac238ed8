// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/eval/metrics.hpp"

#include <cmath>

#include "types_lfd/build/graph_builder.hpp"

namespace graft::lfd {

namespace {

double distance(const Pose& a, const Pose& b) { return (a.translation - b.translation).norm(); }

double angle(const Pose& a, const Pose& b) {
  return rotationAngle(Eigen::Quaterniond(a.rotation.conjugate() * b.rotation));
}

struct Spread {
  double m = 0;
  double rad = 0;
};

/// Standard deviation around the mean pose.
Spread spreadOf(const std::vector<Pose>& poses) {
  if (poses.empty()) return {};
  const Pose mean = meanPose(poses);
  Spread spread;
  for (const Pose& pose : poses) {
    spread.m += std::pow(distance(mean, pose), 2);
    spread.rad += std::pow(angle(mean, pose), 2);
  }
  spread.m = std::sqrt(spread.m / double(poses.size()));
  spread.rad = std::sqrt(spread.rad / double(poses.size()));
  return spread;
}

/// The hand, turned back where it is turned.
Pose handOf(const DemonstrationEstimate& demo, std::size_t i) {
  return demo.hand_turned ? flippedGrasp(demo.hand[i]) : demo.hand[i];
}

void addGraspRows(const std::vector<DemonstrationEstimate>& demos, const Scene& scene,
                  Table1& table) {
  for (const DemonstrationEstimate& demo : demos) {
    const std::size_t e = demo.segments.grasp;
    const Pose object_T_gripper = demo.object[e].inverse() * demo.gripper[e];
    const auto choice =
        scene.grasps->nearest(object_T_gripper, scene.grasp_metric.t, scene.grasp_metric.r);
    const Pose grasp = scene.grasps->pose(choice);
    table.gripper_grasp_m += distance(object_T_gripper, grasp) / double(demos.size());
    table.gripper_grasp_rad += angle(object_T_gripper, grasp) / double(demos.size());
  }
}

void addSpreadRows(const std::vector<DemonstrationEstimate>& demos, Table1& table) {
  std::vector<Pose> grippers;
  std::vector<Pose> hands;
  for (const DemonstrationEstimate& demo : demos) {
    for (std::size_t i = demo.segments.grasp; i <= demo.segments.release; ++i) {
      const Pose object_T_world = demo.object[i].inverse();
      grippers.push_back(object_T_world * demo.gripper[i]);
      hands.push_back(object_T_world * handOf(demo, i));
    }
  }
  const Spread gripper = spreadOf(grippers);
  const Spread hand = spreadOf(hands);
  table.gripper_object_sd_m = gripper.m;
  table.gripper_object_sd_rad = gripper.rad;
  table.hand_object_sd_m = hand.m;
  table.hand_object_sd_rad = hand.rad;
}

double squaredResidual(const MatchedTrack& track, const std::vector<Pose>& estimates,
                       const TrackerAccuracy& accuracy) {
  double sum = 0;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (!track.measured[i]) continue;
    const Vec<double, 6> e = poseError(track.poses[i].inverse() * estimates[i]);
    sum += e.head<3>().squaredNorm() / (accuracy.sigma_t * accuracy.sigma_t) +
           e.tail<3>().squaredNorm() / (accuracy.sigma_r * accuracy.sigma_r);
  }
  return sum;
}

}  // namespace

DemonstrationEstimate estimateFromInput(const PreparedDemonstration& demo) {
  DemonstrationEstimate estimate;
  estimate.name = demo.matched.name;
  estimate.times = demo.matched.times;
  estimate.hand = demo.matched.hand.poses;
  estimate.object = demo.matched.object.poses;
  estimate.torso = demo.matched.torso.poses;
  for (std::size_t i = 0; i < demo.size(); ++i) {
    estimate.gripper.push_back(demo.gripperLikeHand(i));
  }
  for (const Pose& torso : demo.matched.torso.poses) estimate.base.push_back(uprightBase(torso));
  estimate.segments = demo.segments;
  estimate.hand_turned = demo.hand_turned;
  return estimate;
}

Table1 computeTable1(const std::vector<DemonstrationEstimate>& demos, const Scene& scene,
                     bool before) {
  Table1 table;
  addGraspRows(demos, scene, table);
  addSpreadRows(demos, table);
  std::size_t tuples = 0;
  std::size_t reachable = 0;
  std::size_t free = 0;
  double hand_distance = 0;
  double hand_angle = 0;
  for (const DemonstrationEstimate& demo : demos) {
    for (std::size_t i = 0; i < demo.size(); ++i) {
      ++tuples;
      hand_distance += distance(demo.hand[i], demo.gripper[i]);
      hand_angle += angle(handOf(demo, i), demo.gripper[i]);
      if (scene.reach->contains(demo.gripper[i], demo.base[i])) ++reachable;
      if (scene.footprint != nullptr && !scene.footprint->inCollision(demo.base[i])) ++free;
    }
  }
  const auto count = double(tuples);
  if (!before) {
    table.gripper_hand_m = hand_distance / count;
    table.gripper_hand_rad = hand_angle / count;
  }
  table.kinematically_achievable = double(reachable) / count;
  if (scene.footprint != nullptr) table.map_collision_free = double(free) / count;
  return table;
}

double observationResidualPerDof(const std::vector<PreparedDemonstration>& input,
                                 const std::vector<DemonstrationEstimate>& estimates) {
  double sum = 0;
  std::size_t measured = 0;
  for (std::size_t d = 0; d < input.size(); ++d) {
    const MatchedDemonstration& matched = input[d].matched;
    sum += squaredResidual(matched.hand, estimates[d].hand, input[d].accuracy.hand) +
           squaredResidual(matched.object, estimates[d].object, input[d].accuracy.object);
    measured += matched.hand.measuredCount() + matched.object.measuredCount();
  }
  return measured > 0 ? sum / (6.0 * double(measured)) : 0;
}

}  // namespace graft::lfd
