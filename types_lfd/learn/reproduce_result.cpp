// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/learn/reproduce_result.hpp"

#include "core/base/text.hpp"
#include "types_lfd/model/model_file.hpp"

namespace graft::lfd {

ReproducedMotion reproduceResults(const std::vector<std::string>& directories,
                                  const std::vector<Pose>& objects,
                                  const ReproduceOptions& options) {
  if (!objects.empty() && objects.size() != directories.size()) {
    throw Error(ExitCode::kUsage, "give one object pose per learned folder, or none");
  }
  std::vector<PlacedModel> chain;
  Task task;
  for (std::size_t k = 0; k < directories.size(); ++k) {
    const LearnedFolder folder = readLearnedFolder(directories[k]);
    const DemonstrationEstimate& first = folder.demonstrations.front();
    chain.push_back({readModel(directories[k] + "/model.json"),
                     objects.empty() ? first.object[first.segments.grasp] : objects[k]});
    if (k == 0) task = folder.task;
  }
  ReproducedMotion motion;
  motion.points = reproduceChain(chain, options);
  Diagnostics diagnostics;
  const TaskScene scene = loadResultScene(task, diagnostics);
  std::vector<Pose> base_T_gripper;
  std::vector<double> times;
  motion.has_map = scene.footprint != nullptr;
  for (const MotionPoint& point : motion.points) {
    base_T_gripper.push_back(floorPose(point.base).inverse() * point.gripper);
    times.push_back(point.time);
    if (motion.has_map && scene.footprint->inCollision(point.base)) ++motion.in_collision;
  }
  motion.joints = solveIkAlong(*scene.chain, base_T_gripper, times);
  motion.joint_names = scene.chain->names();
  return motion;
}

std::string formatMotionJoints(const ReproducedMotion& motion) {
  std::string out = "time";
  for (const std::string& name : motion.joint_names) out += "," + name;
  out += ",base_x,base_y,base_yaw\n";
  for (std::size_t i = 0; i < motion.points.size(); ++i) {
    appendDouble(out, motion.points[i].time);
    const Eigen::VectorXd& q = motion.joints.joints[i];
    for (std::size_t j = 0; j < motion.joint_names.size(); ++j) {
      out += ',';
      if (q.size() > 0) appendDouble(out, q[Eigen::Index(j)]);
    }
    const Pose2& base = motion.points[i].base;
    for (const double value : {base.x, base.y, base.theta}) {
      out += ',';
      appendDouble(out, value);
    }
    out += '\n';
  }
  return out;
}

}  // namespace graft::lfd
