// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/learn/result_restore.hpp"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/file.hpp"
#include "core/base/text.hpp"
#include "types_lfd/learn/result_reader.hpp"
#include "types_lfd/learn/scene_file.hpp"
#include "types_lfd/model/model_file.hpp"

namespace graft::lfd {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Parses a JSON file and runs `use` on it; what is missing or of another type
/// is an error with the file's name.
template <class Use>
void withJson(const std::string& path, const Use& use) {
  try {
    use(Json::parse(readFile(path)));
  } catch (const nlohmann::json::exception& e) {
    throw Error(ExitCode::kInput, {path, 0, 0}, e.what());
  } catch (const Error& e) {
    throw Error(e.code(), {e.where().path.empty() ? path : e.where().path, e.where().line, 0},
                e.what());
  }
}

Pose poseOf(const Json& json) {
  const auto v = json.get<std::vector<double>>();
  if (v.size() != 7) throw Error(ExitCode::kInput, "a pose needs 7 numbers");
  return Pose::fromArray(v.data());
}

std::optional<double> optionalOf(const Json& json) {
  return json.is_null() ? std::optional<double>() : json.get<double>();
}

Table1 tableOf(const Json& json) {
  Table1 t;
  json.at("gripper_grasp_m").get_to(t.gripper_grasp_m);
  json.at("gripper_grasp_rad").get_to(t.gripper_grasp_rad);
  t.gripper_hand_m = optionalOf(json.at("gripper_hand_m"));
  t.gripper_hand_rad = optionalOf(json.at("gripper_hand_rad"));
  json.at("gripper_object_sd_m").get_to(t.gripper_object_sd_m);
  json.at("gripper_object_sd_rad").get_to(t.gripper_object_sd_rad);
  json.at("hand_object_sd_m").get_to(t.hand_object_sd_m);
  json.at("hand_object_sd_rad").get_to(t.hand_object_sd_rad);
  t.map_collision_free = optionalOf(json.at("map_collision_free"));
  json.at("kinematically_achievable").get_to(t.kinematically_achievable);
  t.ik_achievable = optionalOf(json.at("ik_achievable"));
  return t;
}

TrackerAccuracy accuracyOf(const Json& json) {
  return {json.at("sigma_t").get<double>(), json.at("sigma_r").get<double>()};
}

/// What the graph file holds of the recordings: first estimates of the poses, and
/// which of them were measured (have an E1 edge).
struct GraphInput {
  std::map<std::int64_t, Pose> poses;
  std::set<std::int64_t> measured;
};

GraphInput readGraphInput(const std::string& path, const std::string& content) {
  GraphInput input;
  LineReader lines(content);
  std::string_view line;
  while (lines.next(line)) {
    LineTokens tokens(line);
    const std::string_view tag = tokens.next();
    if (tag != "VERTEX_SE3:QUAT" && tag != "LFD_OBSERVATION") continue;
    std::int64_t id = 0;
    bool right = parseInteger(tokens.next(), id) == NumberStatus::kOk;
    if (tag == "LFD_OBSERVATION") {
      input.measured.insert(id);
    } else {
      double v[7];
      for (double& x : v) right = right && parseDouble(tokens.next(), x) == NumberStatus::kOk;
      if (right) input.poses[id] = Pose::fromArray(v);
    }
    if (!right) {
      throw Error(ExitCode::kInput, {path, lines.lineNumber(), 0},
                  "expected an id" + std::string(tag == "LFD_OBSERVATION" ? "" : " and 7 numbers"));
    }
  }
  return input;
}

class Restorer {
 public:
  explicit Restorer(std::string directory) : directory_(std::move(directory)) {
    requireResult();
    result().task.task = readSceneFiles(directory_);
    result().after = readEstimates(directory_, "optimized");
    readGraphs();
    withJson(file("metrics.json"), [&](const Json& json) { readMetrics(json); });
    Diagnostics diagnostics;
    result().scene = loadResultScene(result().task.task, diagnostics);
    withJson(file("grasp.json"), [&](const Json& json) { readGrasp(json); });
    for (const PreparedDemonstration& demo : result().task.demonstrations) {
      result().before.push_back(estimateFromInput(demo));
    }
    readSnapshots();
    result().model = readModel(file("model.json"));
  }

  RestoredResult take() { return std::move(restored_); }

 private:
  LearnResult& result() { return restored_.result; }
  std::string file(const std::string& name) const { return directory_ + "/" + name; }

  void requireResult() const {
    if (fs::exists(file("resources/scene.json"))) return;
    if (fs::exists(file("mode_0"))) {
      throw Error(ExitCode::kInput, {directory_, 0, 0},
                  "holds the results of several ways of holding the object; give one of its "
                  "folders, as " +
                      file("mode_0"));
    }
    throw Error(ExitCode::kInput, {directory_, 0, 0},
                "holds no learned result (resources/scene.json is missing)");
  }

  void readGraphs() {
    result().graph = readFile(file("graph.g2o"));
    result().graph_optimized = readFile(file("graph_optimized.g2o"));
    const GraphInput input = readGraphInput(file("graph.g2o"), result().graph);
    for (const DemonstrationEstimate& demo : result().after) {
      PreparedDemonstration prepared;
      prepared.matched.name = demo.name;
      prepared.matched.times = demo.times;
      prepared.segments = demo.segments;
      prepared.hand_turned = demo.hand_turned;
      result().task.demonstrations.push_back(std::move(prepared));
      result().task.task.demonstrations.emplace_back().name = demo.name;
    }
    const GraphLayout layout(result().task.demonstrations);
    for (std::size_t d = 0; d < result().after.size(); ++d) {
      MatchedDemonstration& matched = result().task.demonstrations[d].matched;
      for (std::size_t i = 0; i < matched.size(); ++i) {
        const auto take = [&](GraphLayout::Entity entity, MatchedTrack& track) {
          const std::int64_t id = layout.vertex(d, i, entity);
          const auto found = input.poses.find(id);
          if (found == input.poses.end()) {
            throw Error(ExitCode::kInput, {file("graph.g2o"), 0, 0},
                        "has no vertex " + std::to_string(id) + ", a pose of " + matched.name);
          }
          track.poses.push_back(found->second);
          track.measured.push_back(input.measured.count(id) > 0 ? 1 : 0);
        };
        take(GraphLayout::kHand, matched.hand);
        take(GraphLayout::kObject, matched.object);
        take(GraphLayout::kTorso, matched.torso);
      }
      // An estimated torso has no measured pose.
      matched.torso_estimated = matched.torso.measuredCount() == 0;
    }
  }

  void readMetrics(const Json& json) {
    LearnResult& r = result();
    r.table_before = tableOf(json.at("table1").at("before"));
    r.table_after = tableOf(json.at("table1").at("after"));
    readModes(json);
    readWeights(json.at("weights"));
    json.at("seconds").get_to(r.seconds);
    json.at("e1_per_dof").get_to(r.residual_per_dof);
    json.at("messages").get_to(restored_.messages);

    Summary& summary = r.summary;
    const auto status = json.at("status").get<std::string>();
    for (const Status s : {Status::kConverged, Status::kIterationLimit, Status::kTimeLimit,
                           Status::kInterrupted, Status::kFailed}) {
      if (status == statusName(s)) summary.status = s;
    }
    json.at("reason").get_to(summary.reason);
    json.at("chi2").get_to(summary.chi2_by_tag);
    json.at("chi2_initial").get_to(summary.chi2_initial);
    json.at("chi2_final").get_to(summary.chi2_final);
    const Json& report = json.at("report");
    for (const Json& one : report.at("history")) {
      IterationRecord record;
      one.at("iteration").get_to(record.iteration);
      record.chi2 = optionalOf(one.at("chi2")).value_or(0);
      one.at("accepted").get_to(record.accepted);
      summary.iterations.push_back(record);
    }
    report.at("associations_changed").get_to(summary.associations_changed);
    report.at("solver_notes").get_to(summary.notes);
    for (const Json& entity : report.at("trackers_given")) {
      r.task.task.trackers[entity.get<std::string>()] = {};
    }
    for (const DemonstrationEstimate& demo : r.after) {
      r.joints.push_back(readJoints(demo));
      report.at("too_fast_steps").at(demo.name).get_to(r.joints.back().too_fast);
    }
  }

  void readModes(const Json& json) {
    RecordedHolds& holds = result().holds;
    for (const auto& [name, pose] : json.at("object_T_hand").items()) {
      holds.names.push_back(name);
      holds.spread.object_T_hand.push_back(poseOf(pose));
    }
    json.at("grasp_mode").get_to(result().mode);
    for (const Json& one : json.at("grasp_modes")) {
      GraspMode mode;
      for (const Json& name : one.at("demonstrations")) {
        const auto found =
            std::find(holds.names.begin(), holds.names.end(), name.get<std::string>());
        if (found == holds.names.end()) {
          throw Error(ExitCode::kInput, {file("metrics.json"), 0, 0},
                      "object_T_hand has no " + graft::quoted(name.get<std::string>()));
        }
        mode.demonstrations.push_back(std::size_t(found - holds.names.begin()));
      }
      one.at("spread_m").get_to(mode.distance);
      one.at("spread_rad").get_to(mode.angle);
      holds.modes.push_back(std::move(mode));
    }
    if (result().mode >= holds.modes.size()) {
      throw Error(ExitCode::kInput, {file("metrics.json"), 0, 0},
                  "grasp_mode is none of its modes");
    }
  }

  void readWeights(const Json& json) {
    Weights& weights = result().task.weights;
    json.at("relative_motion_factor").get_to(weights.relative_motion_factor);
    json.at("interpolated_factor").get_to(weights.interpolated_factor);
    json.at("smooth_factor").get_to(weights.smooth_factor);
    Task given;
    for (const auto& [name, sigma] : namedWeights(weights)) {
      const TrackerAccuracy a = accuracyOf(json.at(name));
      const WeightOverride one{name, a.sigma_t, a.sigma_r, {file("metrics.json"), 0, 0}};
      // It sets those of all phases, which follow.
      given.weights.insert(name == "steady_motion" ? given.weights.begin() : given.weights.end(),
                           one);
    }
    const Weights factors = weights;
    Diagnostics diagnostics;
    weights = weightsFor(given, diagnostics);
    weights.relative_motion_factor = factors.relative_motion_factor;
    weights.interpolated_factor = factors.interpolated_factor;
    weights.smooth_factor = factors.smooth_factor;
    for (PreparedDemonstration& demo : result().task.demonstrations) {
      const Json& one = json.at("observation").at(demo.matched.name);
      demo.accuracy = {accuracyOf(one.at("hand")), accuracyOf(one.at("object")),
                       accuracyOf(one.at("torso"))};
    }
  }

  GraspSet::Choice choiceOf(const Json& json, int& row) {
    GraspSet::Choice choice;
    json.at("grasp_row").get_to(row);
    json.at("flipped").get_to(choice.flipped);
    json.at("cost").get_to(choice.cost);
    const auto& valid = result().scene.grasps->valid();
    for (std::size_t i = 0; i < valid.size(); ++i) {
      if (valid[i].row == row) choice.index = int(i);
    }
    return choice;
  }

  void readGrasp(const Json& json) {
    LearnedGrasp& grasp = result().grasp;
    grasp.object_T_hand = poseOf(json.at("object_T_hand"));
    grasp.object_T_gripper = poseOf(json.at("object_T_gripper"));
    for (const DemonstrationEstimate& demo : result().after) {
      grasp.hand_T_gripper.push_back(poseOf(json.at("hand_T_gripper").at(demo.name)));
    }
    grasp.choice = choiceOf(json, grasp.row);
    if (!json.at("runner_up").is_null()) {
      grasp.runner_up = choiceOf(json.at("runner_up"), grasp.runner_up_row);
    }
    for (const auto& [name, rows] : json.at("covariance").items()) {
      const auto values = rows.get<std::vector<std::vector<double>>>();
      const auto n = Eigen::Index(values.size());
      for (const std::vector<double>& row : values) {
        if (row.size() == values.size()) continue;
        throw Error(ExitCode::kInput,
                    "the covariance of " + graft::quoted(name) + " is not square");
      }
      Eigen::MatrixXd& matrix = grasp.covariance[name];
      matrix.resize(n, n);
      for (Eigen::Index r = 0; r < n; ++r) {
        for (Eigen::Index c = 0; c < n; ++c) {
          matrix(r, c) = values[std::size_t(r)][std::size_t(c)];
        }
      }
    }
  }

  /// Which rows of joints.csv are filled.
  IkTrack readJoints(const DemonstrationEstimate& demo) const {
    const std::string path = file("optimized/" + demo.name + "/joints.csv");
    const std::string content = readFile(path);
    LineReader lines(content);
    std::string_view line;
    IkTrack track;
    while (lines.next(line)) {
      if (lines.lineNumber() == 1 || line.empty()) continue;
      Eigen::VectorXd joints;
      for (std::size_t at = line.find(','); at != line.npos; at = line.find(',', at + 1)) {
        double value = 0;
        const std::string_view field =
            line.substr(at + 1, std::min(line.find(',', at + 1), line.size()) - at - 1);
        const NumberStatus status = parseDouble(field, value);
        if (status == NumberStatus::kEmpty) continue;
        if (status != NumberStatus::kOk) {
          throw Error(ExitCode::kInput, {path, lines.lineNumber(), 0}, describe(status, field));
        }
        joints.conservativeResize(joints.size() + 1);
        joints[joints.size() - 1] = value;
      }
      if (joints.size() > 0) ++track.solved;
      track.joints.push_back(std::move(joints));
    }
    if (track.joints.size() != demo.size()) {
      throw Error(ExitCode::kInput, {path, 0, 0},
                  "has " + std::to_string(track.joints.size()) + " rows for " +
                      std::to_string(demo.size()) + " tuples");
    }
    return track;
  }

  void readSnapshots() {
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(file("iterations"), none)) {
      const std::string name = entry.path().filename().string();
      std::int64_t iteration = 0;
      if (parseInteger(name, iteration) != NumberStatus::kOk) continue;
      result().snapshots[int(iteration)] = readEstimates(directory_, "iterations/" + name);
    }
  }

  std::string directory_;
  RestoredResult restored_;
};

}  // namespace

RestoredResult restoreResult(const std::string& directory) { return Restorer(directory).take(); }

}  // namespace graft::lfd
