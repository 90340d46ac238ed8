// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/prepare.hpp"

#include <algorithm>

#include "types_lfd/demo/accuracy.hpp"
#include "types_lfd/demo/clean.hpp"
#include "types_lfd/demo/demonstration.hpp"
#include "types_lfd/demo/recording_check.hpp"

namespace graft::lfd {

std::size_t PreparedTask::tupleCount() const {
  std::size_t count = 0;
  for (const PreparedDemonstration& demo : demonstrations) count += demo.size();
  return count;
}

namespace {

/// Cleans, matches and segments one demonstration; remarks to `diagnostics`.
PreparedDemonstration prepareDemonstration(const Task& task, std::size_t d, Demonstration& recorded,
                                           const std::map<std::string, TrackerAccuracy>& accuracies,
                                           Diagnostics& diagnostics) {
  const DemonstrationSpec& spec = task.demonstrations[d];
  const SourceLocation where{task.path, spec.where.line, 0};
  const std::string dropped = removeOutliers(recorded).text();
  if (!dropped.empty()) diagnostics.note(where, spec.name + ": " + dropped);
  PreparedDemonstration demo;
  demo.matched = matchTracks(recorded);
  demo.segments =
      segmentDemonstration(demo.matched, SegmentOptions(), spec.grasp_time, spec.release_time);
  demo.accuracy.hand = accuracies.at("hand");
  demo.accuracy.object = accuracies.at("object");
  // An estimated torso has no measurement; its E2 takes the hand's accuracy.
  demo.accuracy.torso = accuracies.at(demo.matched.torso_estimated ? "hand" : "torso");
  if (demo.matched.torso_estimated) {
    diagnostics.note(where, spec.name + ": no torso track; the torso is estimated from the hand");
  }
  // Below this the object was held more than once, or moved by something else.
  constexpr double kEnoughMotion = 0.8;
  if (demo.segments.motion_share < kEnoughMotion) {
    diagnostics.warning(where, spec.name + ": only " +
                                   std::to_string(int(100 * demo.segments.motion_share)) +
                                   " % of the object's motion lies between grasp and release");
  }
  return demo;
}

}  // namespace

PreparedTask prepareTask(const std::string& task_path, Diagnostics& diagnostics) {
  PreparedTask prepared;
  prepared.task = readTask(task_path, diagnostics);
  prepared.weights = weightsFor(prepared.task, diagnostics);
  diagnostics.throwIfErrors();
  std::vector<Demonstration> demonstrations = readDemonstrations(prepared.task, diagnostics);
  diagnostics.throwIfErrors();
  checkRecordings(prepared.task, demonstrations, diagnostics);
  diagnostics.throwIfErrors();
  const auto accuracies = trackerAccuracies(prepared.task, demonstrations, diagnostics);
  for (std::size_t d = 0; d < demonstrations.size(); ++d) {
    // What is wrong with one demonstration must not hide the others'.
    try {
      prepared.demonstrations.push_back(
          prepareDemonstration(prepared.task, d, demonstrations[d], accuracies, diagnostics));
    } catch (const Error& error) {
      if (error.code() != ExitCode::kInput) throw;
      diagnostics.error({prepared.task.path, prepared.task.demonstrations[d].where.line, 0},
                        error.what());
    }
  }
  diagnostics.throwIfErrors();
  return prepared;
}

Pose meanPose(const std::vector<Pose>& poses) {
  Pose mean = poses.front();
  mean.translation.setZero();
  for (const Pose& pose : poses) mean.translation += pose.translation;
  mean.translation /= double(poses.size());
  // Karcher iteration; converges quadratically for rotations within pi/2.
  for (int iteration = 0; iteration < 30; ++iteration) {
    Vec<double, 3> step = Vec<double, 3>::Zero();
    for (const Pose& pose : poses) {
      step += logSO3(Eigen::Quaterniond(mean.rotation.conjugate() * pose.rotation));
    }
    step /= double(poses.size());
    mean.rotation = (mean.rotation * expSO3<double>(step)).normalized();
    if (step.norm() < 1e-14) break;
  }
  return mean;
}

}  // namespace graft::lfd
