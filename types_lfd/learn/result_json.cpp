// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/learn/result_json.hpp"

#include <algorithm>

namespace graft::lfd {

using Json = nlohmann::ordered_json;

namespace {

Json optionalNumber(const std::optional<double>& value) {
  return value.has_value() ? Json(*value) : Json(nullptr);
}

Json poseNumbers(const Pose& pose) {
  std::vector<double> v(7);
  pose.toArray(v.data());
  return v;
}

/// Ways of holding the object; the grasp is known for the one that was learned.
Json graspModes(const LearnResult& result) {
  Json modes = Json::array();
  for (std::size_t m = 0; m < result.holds.modes.size(); ++m) {
    const GraspMode& mode = result.holds.modes[m];
    Json names = Json::array();
    for (const std::size_t d : mode.demonstrations) names.push_back(result.holds.names[d]);
    const bool learned = result.common_grasp && m == result.mode;
    modes.push_back({{"demonstrations", names},
                     {"grasp", learned ? Json(result.grasp.row) : Json(nullptr)},
                     {"spread_m", mode.distance},
                     {"spread_rad", mode.angle}});
  }
  return modes;
}

/// Where each recorded demonstration holds the object.
Json holdsJson(const LearnResult& result) {
  Json holds = Json::object();
  for (std::size_t d = 0; d < result.holds.names.size(); ++d) {
    holds[result.holds.names[d]] = poseNumbers(result.holds.spread.object_T_hand[d]);
  }
  return holds;
}

Json weightsJson(const LearnResult& result) {
  const Weights& weights = result.task.weights;
  Json json;
  json["relative_motion_factor"] = weights.relative_motion_factor;
  json["interpolated_factor"] = weights.interpolated_factor;
  json["smooth_factor"] = weights.smooth_factor;
  for (const auto& [name, sigma] : namedWeights(weights)) {
    json[name] = {{"sigma_t", sigma.t}, {"sigma_r", sigma.r}};
  }
  const auto tracker = [](const TrackerAccuracy& a) {
    return Json{{"sigma_t", a.sigma_t}, {"sigma_r", a.sigma_r}};
  };
  Json observation;
  for (const PreparedDemonstration& demo : result.task.demonstrations) {
    observation[demo.matched.name] = {{"hand", tracker(demo.accuracy.hand)},
                                      {"object", tracker(demo.accuracy.object)},
                                      {"torso", tracker(demo.accuracy.torso)}};
  }
  json["observation"] = observation;
  return json;
}

/// What the last step did: tuples whose base moved, how far (m, rad), and what
/// is still wrong; the shares before it for comparison.
Json refinementJson(const LearnResult& result) {
  const RefineResult& r = result.refinement;
  return {{"moved", r.moved},
          {"mean_m", r.mean_distance},
          {"mean_rad", r.mean_turn},
          {"max_m", r.farthest},
          {"max_rad", r.farthest_turn},
          {"unresolved", r.unresolved},
          {"blocked_steps", r.blocked_steps},
          {"fast_steps", r.fast_steps},
          {"before",
           {{"map_collision_free", optionalNumber(result.table_optimized.map_collision_free)},
            {"kinematically_achievable", result.table_optimized.kinematically_achievable}}}};
}

/// What a report shows and no other file holds.
Json reportJson(const LearnResult& result) {
  Json history = Json::array();
  for (const IterationRecord& record : result.summary.iterations) {
    history.push_back({{"iteration", record.iteration},
                       {"chi2", optionalNumber(record.chi2)},
                       {"accepted", record.accepted}});
  }
  Json too_fast;
  for (std::size_t d = 0; d < result.joints.size(); ++d) {
    too_fast[result.task.demonstrations[d].matched.name] = result.joints[d].too_fast;
  }
  Json trackers = Json::array();
  for (const auto& [entity, accuracy] : result.task.task.trackers) trackers.push_back(entity);
  return {{"history", history},
          {"associations_changed", result.summary.associations_changed},
          {"solver_notes", result.summary.notes},
          {"too_fast_steps", too_fast},
          {"trackers_given", trackers}};
}

}  // namespace

Json table1Json(const Table1& t) {
  return {{"gripper_grasp_m", t.gripper_grasp_m},
          {"gripper_grasp_rad", t.gripper_grasp_rad},
          {"gripper_hand_m", optionalNumber(t.gripper_hand_m)},
          {"gripper_hand_rad", optionalNumber(t.gripper_hand_rad)},
          {"gripper_object_sd_m", t.gripper_object_sd_m},
          {"gripper_object_sd_rad", t.gripper_object_sd_rad},
          {"hand_object_sd_m", t.hand_object_sd_m},
          {"hand_object_sd_rad", t.hand_object_sd_rad},
          {"map_collision_free", optionalNumber(t.map_collision_free)},
          {"kinematically_achievable", t.kinematically_achievable},
          {"ik_achievable", optionalNumber(t.ik_achievable)}};
}

Json metricsJson(const LearnResult& result, const std::vector<std::string>& messages) {
  Json json;
  json["task"] = result.task.task.name;
  json["tuples"] = result.task.tupleCount();
  bool torso_estimated = false;
  for (const PreparedDemonstration& demo : result.task.demonstrations) {
    torso_estimated = torso_estimated || demo.matched.torso_estimated;
  }
  json["torso_estimated"] = torso_estimated;
  if (result.common_grasp) {
    json["table1"] = {{"before", table1Json(result.table_before)},
                      {"after", table1Json(result.table_after)}};
  } else {
    json["table1"] = nullptr;
  }
  json["grasp_modes"] = graspModes(result);
  json["grasp_mode"] = result.common_grasp ? Json(result.mode) : Json(nullptr);
  json["object_T_hand"] = holdsJson(result);
  json["weights"] = weightsJson(result);
  if (result.common_grasp) {
    json["iterations"] = result.summary.iterationCount();
    json["status"] = statusName(result.summary.status);
    json["reason"] = result.summary.reason;
    json["chi2"] = result.summary.chi2_by_tag;
    json["chi2_initial"] = result.summary.chi2_initial;
    json["chi2_final"] = result.summary.chi2_final;
    json["e1_per_dof"] = result.residual_per_dof;
    json["refinement"] = refinementJson(result);
    json["report"] = reportJson(result);
  }
  json["messages"] = messages;
  json["seconds"] = result.seconds;
  return json;
}

Json graspJson(const LearnResult& result) {
  const LearnedGrasp& grasp = result.grasp;
  Json json;
  json["object_T_hand"] = poseNumbers(grasp.object_T_hand);
  json["object_T_gripper"] = poseNumbers(grasp.object_T_gripper);
  Json offsets;
  for (std::size_t d = 0; d < grasp.hand_T_gripper.size(); ++d) {
    offsets[result.task.demonstrations[d].matched.name] = poseNumbers(grasp.hand_T_gripper[d]);
  }
  json["hand_T_gripper"] = offsets;
  json["grasp_row"] = grasp.row;
  json["flipped"] = grasp.choice.flipped;
  json["cost"] = grasp.choice.cost;
  json["runner_up"] = grasp.runner_up.index < 0 ? Json(nullptr)
                                                : Json{{"grasp_row", grasp.runner_up_row},
                                                       {"flipped", grasp.runner_up.flipped},
                                                       {"cost", grasp.runner_up.cost}};
  Json covariances = Json::object();
  for (const auto& [name, matrix] : grasp.covariance) {
    Json rows = Json::array();
    for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
      std::vector<double> row;
      for (Eigen::Index c = 0; c < matrix.cols(); ++c) row.push_back(matrix(r, c));
      rows.push_back(row);
    }
    covariances[name] = rows;
  }
  json["covariance"] = covariances;
  return json;
}

}  // namespace graft::lfd
