// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <memory>

#include "apps/graft_lfd/commands.hpp"
#include "types_lfd/build/grasp_modes.hpp"
#include "types_lfd/demo/demonstration.hpp"

namespace graft::lfd {

namespace {

void describeTrack(const char* entity, const Trajectory& track) {
  if (track.size() < 2) {
    std::printf("  %-7s not recorded\n", entity);
    return;
  }
  std::vector<double> steps;
  for (std::size_t i = 1; i < track.size(); ++i) {
    steps.push_back(track.times[i] - track.times[i - 1]);
  }
  std::sort(steps.begin(), steps.end());
  double lowest = track.poses.front().translation[2];
  double highest = lowest;
  for (const Pose& pose : track.poses) {
    lowest = std::min(lowest, pose.translation[2]);
    highest = std::max(highest, pose.translation[2]);
  }
  std::printf(
      "  %-7s %4zu poses over %.2f s, median rate %.1f Hz, longest gap %.2f s, "
      "height %.2f to %.2f m\n",
      entity, track.size(), track.times.back() - track.times.front(), 1 / steps[steps.size() / 2],
      steps.back(), lowest, highest);
}

ExitCode run(const std::string& path) {
  Diagnostics diagnostics;
  const PreparedTask prepared = prepareTask(path, diagnostics);
  Diagnostics silent;  // prepareTask() has reported what these files hold
  const std::vector<Demonstration> recorded = readDemonstrations(prepared.task, silent);
  printMessages(diagnostics);
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
  const GraspSpread spread = graspSpread(prepared.demonstrations);
  std::printf("hands hold the object within %.1f cm and %.0f degrees of each other\n",
              100 * spread.distance, spread.angle * 180 / 3.14159265358979323846);
  return ExitCode::kSuccess;
}

}  // namespace

void addCheck(Program& program) {
  auto task = std::make_shared<std::string>();
  CLI::App* app = program.add("check", "Tell whether a recording is usable: rates, gaps, contact",
                              [task] { return run(*task); });
  app->add_option("TASK.xml", *task, "Task file")->required();
}

}  // namespace graft::lfd
