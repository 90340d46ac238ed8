// SPDX-License-Identifier: BSD-3-Clause
#include "tests/apps/report/synthetic_result.hpp"

#include <cmath>

#include "tests/types_lfd/robot/small_robot.hpp"
#include "types_lfd/build/graph_builder.hpp"

namespace graft::report::testing {

namespace {

using lfd::DemonstrationEstimate;
using lfd::LearnResult;
using lfd::PreparedDemonstration;

constexpr std::size_t kTuples = 40;
constexpr std::size_t kGrasp = 12;
constexpr std::size_t kRelease = 30;

Pose at(double x, double y, double z) { return Pose(Vec<double, 3>(x, y, z), {1, 0, 0, 0}); }

/// A wall at x = 1.6 with an opening, as a map of 5 cm cells.
lfd::OccupancyMap room() {
  const int size = 80;
  std::vector<lfd::Cell> cells(size * size, lfd::Cell::kFree);
  for (int row = 0; row < size; ++row) {
    if (row > 30 && row < 50) continue;
    for (int column = 72; column < 75; ++column) {
      cells[std::size_t(row * size + column)] = lfd::Cell::kOccupied;
    }
    cells[std::size_t(row * size)] = lfd::Cell::kUnknown;
  }
  return lfd::OccupancyMap(size, size, 0.05, Pose2(-2, -2, 0.1), cells);
}

PreparedDemonstration demonstration(const std::string& name, int d, bool torso_estimated) {
  PreparedDemonstration demo;
  demo.matched.name = name;
  demo.matched.torso_estimated = torso_estimated;
  for (std::size_t i = 0; i < kTuples; ++i) {
    const double t = 0.1 * double(i);
    const double pulled =
        0.3 * std::clamp((double(i) - double(kGrasp)) / double(kRelease - kGrasp), 0.0, 1.0);
    const double away = std::max(0.0, double(kGrasp) - double(i)) * 0.02;
    const double back = std::max(0.0, double(i) - double(kRelease)) * 0.02;
    const double jitter = 0.004 * std::sin(7.3 * double(i) + d);
    demo.matched.times.push_back(100 + t);
    demo.matched.object.poses.push_back(at(1 - pulled + 0.5 * jitter, 0.02 * d, 0.8));
    demo.matched.hand.poses.push_back(
        at(1 - pulled - away - back - 0.03, 0.02 * d + jitter, 0.81 + 0.1 * back));
    demo.matched.torso.poses.push_back(at(0.3 - pulled - back, 0.1 + 0.02 * d, 1.1));
    demo.matched.hand.measured.push_back(i % 7 != 3);
    demo.matched.object.measured.push_back(i % 3 != 1);
    demo.matched.torso.measured.push_back(torso_estimated ? 0 : 1);
  }
  demo.segments = {kGrasp, kRelease};
  demo.accuracy = {{0.004, 0.05}, {0.005, 0.06}, {0.012, 0.04}};
  return demo;
}

/// Bases move back by `shift`, grippers forward to the grasp.
std::vector<DemonstrationEstimate> moved(std::vector<DemonstrationEstimate> demos, double shift) {
  for (DemonstrationEstimate& demo : demos) {
    for (std::size_t i = 0; i < demo.size(); ++i) {
      demo.base[i].x -= shift;
      demo.gripper[i].translation[0] += 0.1 * shift;
    }
  }
  return demos;
}

void fillTables(LearnResult& result, bool map) {
  lfd::Table1& before = result.table_before;
  before.gripper_grasp_m = 0.0633;
  before.gripper_grasp_rad = 0.0942;
  before.gripper_object_sd_m = before.hand_object_sd_m = 0.0266;
  before.gripper_object_sd_rad = before.hand_object_sd_rad = 0.0154;
  before.kinematically_achievable = 0.873;
  lfd::Table1& after = result.table_after;
  after.gripper_grasp_m = 0.0031;
  after.gripper_grasp_rad = 0.0212;
  after.gripper_hand_m = 0.0554;
  after.gripper_hand_rad = 0.0489;
  after.gripper_object_sd_m = 0.0018;
  after.gripper_object_sd_rad = 0.0037;
  after.hand_object_sd_m = 0.0028;
  after.hand_object_sd_rad = 0.0052;
  after.kinematically_achievable = 0.9985;
  after.ik_achievable = 0.9875;
  if (!map) return;
  before.map_collision_free = 0.892;
  after.map_collision_free = 0.9974;
}

void fillSummary(LearnResult& result) {
  Summary& summary = result.summary;
  summary.status = Status::kIterationLimit;
  summary.reason = "20 iterations were made";
  summary.chi2_initial = summary.chi2_start = 123456;
  double chi2 = summary.chi2_initial;
  for (int i = 0; i <= 20; ++i) {
    IterationRecord record;
    record.iteration = i;
    record.accepted = i != 4;
    if (i > 0 && record.accepted) chi2 = 700 + 0.4 * (chi2 - 700);
    record.chi2 = chi2;
    summary.iterations.push_back(record);
  }
  summary.chi2_final = chi2;
  summary.notes = {"a note of the solver"};
  summary.chi2_by_tag = {{"LFD_OBSERVATION", 410.5}, {"LFD_RELATIVE_MOTION", 120.25},
                         {"LFD_HAND_GRIPPER", 88.0}, {"LFD_REACHABILITY", 0.031},
                         {"LFD_GRASP_QUALITY", 1.5}, {"LFD_SOMETHING_NEW", 12.0}};
}

void fillLearned(LearnResult& result, const ResultOptions& options) {
  const lfd::GraspSet& grasps = *result.scene.grasps;
  result.grasp.object_T_gripper = at(-0.002, 0.001, 0);
  result.grasp.choice =
      grasps.nearest(result.grasp.object_T_gripper, 0.001, 0.01, &result.grasp.runner_up);
  result.grasp.row = grasps.valid()[std::size_t(result.grasp.choice.index)].row;
  result.grasp.runner_up_row = grasps.valid()[std::size_t(result.grasp.runner_up.index)].row;
  result.grasp.hand_T_gripper.assign(std::size_t(options.demonstrations), at(0.03, 0, 0));
  result.grasp.covariance["object_T_gripper"] = 1e-6 * Eigen::MatrixXd::Identity(6, 6);
  lfd::IkTrack track;
  track.joints.assign(kTuples, Eigen::VectorXd());
  track.solved = kTuples - 1;
  result.joints.assign(std::size_t(options.demonstrations), track);
  lfd::SegmentModel reach;
  reach.name = "reach";
  reach.duration = 1.2;
  reach.mixture.components.resize(5);
  result.model.segments = {reach};
  result.residual_per_dof = 0.97;
}

}  // namespace

LearnResult syntheticResult(const ResultOptions& options) {
  LearnResult result;
  result.task.task.name = options.task;
  result.task.task.map = options.map ? "map.yaml" : "";
  result.task.task.robot.footprint = {{0.3, 0.3}, {-0.3, 0.3}, {-0.3, -0.3}, {0.3, -0.3}};
  for (int d = 0; d < options.demonstrations; ++d) {
    result.task.demonstrations.push_back(
        demonstration(options.demo_prefix + std::to_string(d + 1), d, options.torso_estimated));
    result.task.task.demonstrations.emplace_back();
  }
  result.seconds = {{"prepare", 0.21}, {"optimize", 1.5}, {"total", 2.25}};
  result.holds = lfd::recordedHolds(result.task.demonstrations);
  result.common_grasp = options.common_grasp;
  if (!options.common_grasp) {
    result.holds.spread.object_T_hand.back().translation[0] += 0.4;
    result.holds.spread.distance = 0.4;
    result.holds.modes = lfd::findGraspModes(result.holds.spread);
    return result;
  }
  if (options.left_out) {
    result.holds.names.push_back(options.demo_prefix + "other");
    result.holds.spread.object_T_hand.emplace_back(at(0.3, 0.1, 0));
    result.holds.modes = lfd::findGraspModes(result.holds.spread);
  }
  lfd::TaskScene& scene = result.scene;
  scene.chain = std::make_unique<lfd::Chain>(lfd::testing::smallRobotChain());
  lfd::ReachOptions reach;
  reach.resolution = 0.2;
  reach.angular_step = 3.14159265358979323846 / 2;
  reach.max_samples = 1 << 14;
  reach.threads = 1;
  scene.reach = std::make_unique<lfd::ReachMap>(lfd::ReachMap::build(*scene.chain, reach));
  scene.grasps = std::make_unique<lfd::GraspSet>(std::vector<lfd::Grasp>{
      {at(0, 0, 0), 0.9, 0}, {at(0.01, 0.02, 0.01), 0.8, 2}, {at(0, -0.05, 0.03), 0.7, 5}});
  if (options.map) {
    scene.map = std::make_unique<lfd::OccupancyMap>(room());
    scene.footprint =
        std::make_unique<lfd::FootprintChecker>(*scene.map, result.task.task.robot.footprint);
  }
  for (const PreparedDemonstration& demo : result.task.demonstrations) {
    result.before.push_back(lfd::estimateFromInput(demo));
  }
  // Some of the first bases stand in the wall.
  result.before = moved(result.before, -0.9);
  result.after = moved(result.before, 0.9);
  if (options.snapshots) {
    result.snapshots = {{0, result.before}, {5, moved(result.before, 0.6)}, {20, result.after}};
  }
  result.graph =
      "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nLFD_OBSERVATION 0 1\nLFD_OBSERVATION 0 2\n"
      "LFD_GRASP_QUALITY 0\n";
  fillTables(result, options.map);
  fillSummary(result);
  fillLearned(result, options);
  return result;
}

}  // namespace graft::report::testing
