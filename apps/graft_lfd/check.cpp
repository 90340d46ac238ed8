// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <memory>

#include "apps/common/progress.hpp"
#include "apps/graft_lfd/commands.hpp"
#include "types_lfd/build/grasp_modes.hpp"
#include "types_lfd/build/reach_check.hpp"
#include "types_lfd/build/scene.hpp"
#include "types_lfd/demo/demonstration.hpp"

namespace graft::lfd {

namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;
// A grasp farther from the hand than this makes another motion of it.
constexpr double kFarGrasp = 0.15;
constexpr double kFarGraspAngle = 0.8;

void describeTrack(const char* entity, const Trajectory& track) {
  if (track.size() < 2) {
    std::printf("  %-7s not recorded\n", entity);
    return;
  }
  const TrackSummary summary = summarize(track);
  double lowest = track.poses.front().translation[2];
  double highest = lowest;
  for (const Pose& pose : track.poses) {
    lowest = std::min(lowest, pose.translation[2]);
    highest = std::max(highest, pose.translation[2]);
  }
  std::printf(
      "  %-7s %4zu poses over %.2f s, median rate %.1f Hz, longest gap %.2f s, "
      "height %.2f to %.2f m\n",
      entity, summary.poses, summary.duration, 1 / summary.median_interval, summary.longest_gap,
      lowest, highest);
}

void describeRecordings(const PreparedTask& prepared) {
  Diagnostics silent;  // prepareTask() has reported what these files hold
  const std::vector<Demonstration> recorded = readDemonstrations(prepared.task, silent);
  std::printf("%s: %zu demonstrations, %zu tuples after matching\n", prepared.task.name.c_str(),
              recorded.size(), prepared.tupleCount());
  for (std::size_t d = 0; d < recorded.size(); ++d) {
    const PreparedDemonstration& demo = prepared.demonstrations[d];
    std::printf("%s: %zu tuples, grasp at %.2f s, release at %.2f s of %.2f s\n",
                recorded[d].name.c_str(), demo.size(),
                demo.matched.times[demo.segments.grasp] - demo.matched.times.front(),
                demo.matched.times[demo.segments.release] - demo.matched.times.front(),
                demo.matched.times.back() - demo.matched.times.front());
    describeTrack("hand", recorded[d].hand);
    describeTrack("object", recorded[d].object);
    describeTrack("torso", recorded[d].torso);
  }
}

/// The ways of holding the object; true if there is one that can be learned.
bool describeHolds(const RecordedHolds& holds) {
  if (holds.modes.size() == 1) {
    std::printf("hands hold the object within %.1f cm and %.0f degrees of each other\n",
                100 * holds.spread.distance, holds.spread.angle * kDegrees);
    return true;
  }
  std::printf("hands hold the object in %zu ways:\n", holds.modes.size());
  for (std::size_t m = 0; m < holds.modes.size(); ++m) {
    const GraspMode& mode = holds.modes[m];
    std::printf("  mode %zu:", m);
    for (const std::size_t d : mode.demonstrations) std::printf(" %s", holds.names[d].c_str());
    std::printf(" (within %.1f cm and %.0f degrees)\n", 100 * mode.distance, mode.angle * kDegrees);
  }
  return holds.common();
}

/// What of one way of holding no base could reach.
ReachCheck describeReach(const PreparedTask& task, const TaskScene& scene,
                         Diagnostics& diagnostics) {
  ReachCheck check = checkReach(task, *scene.grasps, *scene.reach);
  std::printf("grasp nearest to the hands: row %d%s, %.1f cm and %.0f degrees from them\n",
              check.grasp.row, check.grasp.choice.flipped ? " (turned by 180 degrees)" : "",
              100 * check.grasp.distance, check.grasp.angle * kDegrees);
  if (check.grasp.distance > kFarGrasp || check.grasp.angle > kFarGraspAngle) {
    diagnostics.warning({task.task.grasps, 0, 0},
                        "no valid grasp is near the place where the hands hold the object; the "
                        "robot will move otherwise than was shown (add grasps there)");
  }
  std::printf("reach: %zu of %zu tuples are in reach of some base\n",
              check.tuples - check.unreachable, check.tuples);
  for (std::size_t d = 0; d < check.ranges.size(); ++d) {
    for (const UnreachableRange& range : check.ranges[d]) {
      std::printf("  %s\n", describeRange(task.demonstrations[d], range, check).c_str());
    }
  }
  return check;
}

ExitCode run(const std::string& path) {
  Diagnostics diagnostics;
  const PreparedTask prepared = prepareTask(path, diagnostics);
  printMessages(diagnostics);
  describeRecordings(prepared);
  const RecordedHolds holds = recordedHolds(prepared.demonstrations);
  const bool common = describeHolds(holds);

  Diagnostics findings;
  ProgressBar bar("reachability map", 100);
  const TaskScene scene =
      loadScene(prepared.task, findings, [&](double share) { bar.update(int(100 * share), ""); });
  std::size_t tuples = 0;
  std::size_t unreachable = 0;
  for (std::size_t m = 0; m < holds.modes.size(); ++m) {
    if (holds.modes.size() > 1) std::printf("mode %zu: ", m);
    const ReachCheck check =
        describeReach(taskOfMode(prepared, holds, m, findings), scene, findings);
    tuples += check.tuples;
    unreachable += check.unreachable;
  }
  printMessages(findings);
  const std::size_t warnings =
      diagnostics.warningCount() + findings.warningCount() + (unreachable > 0 ? 1 : 0);
  if (!common || unreachable == tuples) {
    std::printf("not usable: %s\n", common ? "no base reaches any tuple"
                                           : "no two demonstrations hold the object alike");
    return ExitCode::kNoResult;
  }
  if (holds.modes.size() > 1) {
    std::printf("usable in part: learn takes mode 0 (see learn --grasp-mode)\n");
  } else if (warnings > 0) {
    std::printf("usable, with what is said above\n");
  } else {
    std::printf("usable\n");
  }
  return ExitCode::kSuccess;
}

}  // namespace

void addCheck(Program& program) {
  auto task = std::make_shared<std::string>();
  CLI::App* app = program.add(
      "check",
      "Tell whether a recording is usable: rates, gaps, units, axes, contact, ways of holding the "
      "object, and which tuples no base could ever reach (exit code 3 or 4 if it is not)",
      [task] { return run(*task); });
  app->add_option("TASK.xml", *task, "Task file")->required();
}

}  // namespace graft::lfd
