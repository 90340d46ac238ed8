// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/learn/result_writer.hpp"

#include "core/base/text.hpp"
#include "core/io/trajectory.hpp"
#include "types_lfd/demo/segments_file.hpp"
#include "types_lfd/learn/result_json.hpp"
#include "types_lfd/model/model_file.hpp"

namespace graft::lfd {

namespace {

std::string tum(const std::vector<double>& times, const std::vector<Pose>& poses) {
  return formatTum({times, poses});
}

void writeTracks(const DemonstrationEstimate& demo, const std::string& folder,
                 StagedDirectory& out) {
  std::vector<Pose> base;
  for (const Pose2& b : demo.base) base.push_back(floorPose(b));
  out.write(folder + "/hand.tum", tum(demo.times, demo.hand));
  out.write(folder + "/object.tum", tum(demo.times, demo.object));
  out.write(folder + "/torso.tum", tum(demo.times, demo.torso));
  out.write(folder + "/gripper.tum", tum(demo.times, demo.gripper));
  out.write(folder + "/base.tum", tum(demo.times, base));
}

}  // namespace

std::vector<std::string> learnOutputs() {
  return {"optimized",  "segments.csv", "grasp.json", "graph.g2o", "graph_optimized.g2o",
          "model.json", "metrics.json", "iterations", "pictures",  "report.html",
          "resources",  "tune.json"};
}

std::string formatJoints(const std::vector<std::string>& names, const std::vector<double>& times,
                         const IkTrack& track) {
  std::string out = "time";
  for (const std::string& name : names) out += "," + name;
  out += '\n';
  for (std::size_t i = 0; i < times.size(); ++i) {
    appendDouble(out, times[i]);
    const Eigen::VectorXd& q = track.joints[i];
    for (std::size_t j = 0; j < names.size(); ++j) {
      out += ',';
      if (q.size() > 0) appendDouble(out, q[Eigen::Index(j)]);
    }
    out += '\n';
  }
  return out;
}

void writeResult(const LearnResult& result, StagedDirectory& out,
                 const std::vector<std::string>& messages) {
  std::vector<MatchedDemonstration> matched;
  std::vector<Segmentation> segments;
  for (const PreparedDemonstration& demo : result.task.demonstrations) {
    matched.push_back(demo.matched);
    segments.push_back(demo.segments);
  }
  out.write("segments.csv", formatSegments(matched, segments));
  out.write("metrics.json", metricsJson(result, messages).dump(2) + "\n");
  if (!result.common_grasp) return;
  for (std::size_t d = 0; d < result.after.size(); ++d) {
    const DemonstrationEstimate& demo = result.after[d];
    const std::string folder = "optimized/" + demo.name;
    writeTracks(demo, folder, out);
    out.write(folder + "/joints.csv",
              formatJoints(result.scene.chain->names(), demo.times, result.joints[d]));
  }
  out.write("grasp.json", graspJson(result).dump(2) + "\n");
  out.write("graph.g2o", result.graph);
  out.write("graph_optimized.g2o", result.graph_optimized);
  out.write("model.json", formatModel(result.model));
  for (const auto& [iteration, demos] : result.snapshots) {
    for (const DemonstrationEstimate& demo : demos) {
      writeTracks(demo, "iterations/" + std::to_string(iteration) + "/" + demo.name, out);
    }
  }
}

}  // namespace graft::lfd
