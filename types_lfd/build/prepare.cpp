// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/prepare.hpp"

#include <algorithm>
#include <array>

#include "types_lfd/demo/accuracy.hpp"
#include "types_lfd/demo/clean.hpp"
#include "types_lfd/demo/demonstration.hpp"

namespace graft::lfd {

std::size_t PreparedTask::tupleCount() const {
  std::size_t count = 0;
  for (const PreparedDemonstration& demo : demonstrations) count += demo.size();
  return count;
}

namespace {

/// The motion prior of hand and object from the tracks, where the task does not
/// give it.
void findSteadiness(PreparedTask& prepared) {
  Weights& w = prepared.weights;
  struct Found {
    MatchedTrack MatchedDemonstration::*track;
    TrackerAccuracy accuracy;
    const char* name;
    std::array<Sigma*, kMotionPhases> weights;
  };
  const DemonstrationAccuracy& accuracy = prepared.demonstrations.front().accuracy;
  const Found entities[] = {
      {&MatchedDemonstration::hand,
       accuracy.hand,
       "steady_hand",
       {&w.steady_hand_free, &w.steady_hand_contact, &w.steady_hand_held}},
      {&MatchedDemonstration::object,
       accuracy.object,
       "steady_object",
       {&w.steady_object_free, &w.steady_object_contact, &w.steady_object_held}}};
  for (const Found& entity : entities) {
    const bool given = std::any_of(
        prepared.task.weights.begin(), prepared.task.weights.end(), [&](const WeightOverride& o) {
          return o.edge == "steady_motion" || o.edge.rfind(entity.name, 0) == 0;
        });
    if (given) continue;
    std::vector<PhasedTrack> tracks;
    for (const PreparedDemonstration& d : prepared.demonstrations) {
      PhasedTrack track{&d.matched.times, &(d.matched.*entity.track), {}};
      for (std::size_t i = 0; i < d.size(); ++i) track.phases.push_back(d.phase(i));
      tracks.push_back(std::move(track));
    }
    const auto noise =
        estimateMotionNoise(tracks, entity.accuracy, {w.steady_motion.t, w.steady_motion.r});
    for (std::size_t p = 0; p < kMotionPhases; ++p) *entity.weights[p] = {noise[p].t, noise[p].r};
  }
}

}  // namespace

PreparedTask prepareTask(const std::string& task_path, Diagnostics& diagnostics) {
  PreparedTask prepared;
  prepared.task = readTask(task_path, diagnostics);
  prepared.weights = weightsFor(prepared.task, diagnostics);
  diagnostics.throwIfErrors();
  std::vector<Demonstration> demonstrations = readDemonstrations(prepared.task, diagnostics);
  diagnostics.throwIfErrors();
  const auto accuracies = trackerAccuracies(prepared.task, demonstrations, diagnostics);
  for (std::size_t d = 0; d < demonstrations.size(); ++d) {
    const DemonstrationSpec& spec = prepared.task.demonstrations[d];
    const auto note = [&](const std::string& text) {
      diagnostics.note({prepared.task.path, spec.where.line, 0}, spec.name + ": " + text);
    };
    const std::string dropped = removeOutliers(demonstrations[d]).text();
    if (!dropped.empty()) note(dropped);
    PreparedDemonstration demo;
    demo.matched = matchTracks(demonstrations[d]);
    demo.segments =
        segmentDemonstration(demo.matched, SegmentOptions(), spec.grasp_time, spec.release_time);
    demo.accuracy.hand = accuracies.at("hand");
    demo.accuracy.object = accuracies.at("object");
    // An estimated torso has no measurement; its E2 takes the hand's accuracy.
    demo.accuracy.torso = accuracies.at(demo.matched.torso_estimated ? "hand" : "torso");
    if (demo.matched.torso_estimated) note("no torso track; the torso is estimated from the hand");
    // Below this the object was held more than once, or moved by something else.
    constexpr double kEnoughMotion = 0.8;
    if (demo.segments.motion_share < kEnoughMotion) {
      diagnostics.warning({prepared.task.path, spec.where.line, 0},
                          spec.name + ": only " +
                              std::to_string(int(100 * demo.segments.motion_share)) +
                              " % of the object's motion lies between grasp and release");
    }
    prepared.demonstrations.push_back(std::move(demo));
  }
  findSteadiness(prepared);
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
