// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/teacher.hpp"

#include <cmath>
#include <filesystem>

#include "core/base/staged_directory.hpp"
#include "core/base/text.hpp"
#include "types_lfd/teach/grasp_samples.hpp"
#include "types_lfd/teach/performance.hpp"
#include "types_lfd/teach/teacher_robot.hpp"

namespace graft::lfd {

namespace {

/// A billionth of a metre: far below any noise, and coarse enough that the last
/// bits of a mathematical library do not show in the files.
Trajectory rounded(Trajectory track) {
  for (Pose& pose : track.poses) {
    double values[7];
    pose.toArray(values);
    for (double& value : values) value = std::round(value * 1e9) / 1e9 + 0.0;
    pose = Pose::fromArray(values);
  }
  return track;
}

std::string formatTracker(const char* entity, const TrackerModel& tracker) {
  // An exact track still has a resolution; the learner's weights need a number.
  const double sigma_t = std::max(tracker.sigma_t, 1e-4);
  const double sigma_r = std::max(tracker.sigma_r, 1e-4);
  return std::string("  <tracker entity=\"") + entity + "\" sigma_t=\"" + formatDouble(sigma_t) +
         "\" sigma_r=\"" + formatDouble(sigma_r) + "\"/>\n";
}

std::string formatTask(const Scenario& s) {
  const std::string w = formatDouble(kRobotHalfWidth);
  std::string out = "<?xml version=\"1.0\"?>\n<task name=\"" + s.name + "\" version=\"1\">\n";
  out += std::string("  <robot urdf=\"robot.urdf\" base_link=\"") + kRobotBaseLink +
         "\" tip_link=\"" + kRobotTipLink + "\"\n         footprint=\"" + w + ' ' + w + "  -" + w +
         ' ' + w + "  -" + w + " -" + w + "  " + w + " -" + w + "\"/>\n";
  out += "  <grasps file=\"grasps.csv\" min_quality=\"" + formatDouble(kTaughtMinQuality) +
         "\"/>\n  <map file=\"map.yaml\"/>\n";
  out += formatTracker("hand", s.hand_tracker) + formatTracker("object", s.object_tracker);
  if (s.has_torso) out += formatTracker("torso", s.torso_tracker);
  for (int i = 0; i < s.demonstrations; ++i) {
    const std::string name = demonstrationName(i);
    out.append("  <demonstration name=\"").append(name);
    out.append("\" hand=\"").append(name).append("/hand.tum\"");
    out.append(" object=\"").append(name).append("/object.tum\"");
    if (s.has_torso) out.append(" torso=\"").append(name).append("/torso.tum\"");
    out.append("/>\n");
  }
  return out + "</task>\n";
}

/// demo_* of an earlier run, which this one may not write again.
std::vector<std::string> earlierDemonstrations(const std::string& directory) {
  std::vector<std::string> names;
  std::error_code missing;
  for (const auto& entry : std::filesystem::directory_iterator(directory, missing)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("demo_", 0) == 0) names.push_back(name);
  }
  return names;
}

}  // namespace

std::string demonstrationName(int index) {
  const std::string number = std::to_string(index + 1);
  return "demo_" + std::string(number.size() < 2 ? "0" : "") + number;
}

void teach(const std::string& task_name, const std::string& directory, std::uint64_t seed,
           const TeachOptions& options) {
  const Scenario scenario = drawScenario(task_name, seed, options);
  StagedDirectory out(directory);
  out.replaces(earlierDemonstrations(directory));
  out.write("task.xml", formatTask(scenario));
  out.write("robot.urdf", formatRobotUrdf());
  out.write("grasps.csv", formatGrasps(sampleGrasps(scenario, seed)));
  const OccupancyMap map = drawMap(scenario);
  out.write("map.yaml", map.formatYaml("map.pgm"));
  out.write("map.pgm", map.formatPgm());
  std::string segments = "demo,grasp_time,release_time\n";
  for (int i = 0; i < scenario.demonstrations; ++i) {
    const std::string name = demonstrationName(i);
    const Performance truth = perform(scenario, i, seed, options);
    segments +=
        name + ',' + formatDouble(truth.grasp_time) + ',' + formatDouble(truth.release_time) + '\n';
    struct Entity {
      const char* name;
      const Trajectory& track;
      const TrackerModel& tracker;
      bool recorded;
    };
    const Entity entities[] = {{"hand", truth.hand, scenario.hand_tracker, true},
                               {"object", truth.object, scenario.object_tracker, true},
                               {"torso", truth.torso, scenario.torso_tracker, scenario.has_torso}};
    std::uint64_t stream = 20;
    for (const Entity& entity : entities) {
      Random random(seed, stream++, static_cast<std::uint64_t>(i));
      const Trajectory observed = observe(entity.track, entity.tracker, random);
      out.write("truth/" + name + '_' + entity.name + ".tum", formatTum(rounded(entity.track)));
      if (!entity.recorded) continue;
      out.write(name + '/' + entity.name + ".tum", formatTum(rounded(observed)));
    }
  }
  out.write("truth/segments.csv", segments);
  out.commit();
}

}  // namespace graft::lfd
