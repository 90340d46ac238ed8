// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/learn/result_reader.hpp"

#include <algorithm>

#include "core/base/file.hpp"
#include "core/base/text.hpp"
#include "core/io/trajectory.hpp"
#include "types_lfd/build/grasp_modes.hpp"

namespace graft::lfd {

namespace {

struct SegmentLine {
  std::string demo;
  double grasp_time = 0;
  double release_time = 0;
};

std::vector<SegmentLine> readSegments(const std::string& path) {
  const std::string content = readFile(path);
  LineReader reader(content);
  std::string_view line;
  std::vector<SegmentLine> segments;
  while (reader.next(line)) {
    const SourceLocation where{path, reader.lineNumber(), 0};
    if (reader.lineNumber() == 1) {
      if (line != "demo,grasp_time,release_time") {
        throw Error(ExitCode::kInput, where, "expected the header demo,grasp_time,release_time");
      }
      continue;
    }
    if (line.empty()) continue;
    const std::size_t first = line.find(',');
    const std::size_t second = line.find(',', first == line.npos ? first : first + 1);
    SegmentLine segment;
    if (second == line.npos ||
        parseDouble(line.substr(first + 1, second - first - 1), segment.grasp_time) !=
            NumberStatus::kOk ||
        parseDouble(line.substr(second + 1), segment.release_time) != NumberStatus::kOk) {
      throw Error(ExitCode::kInput, where, "expected a name and two times");
    }
    segment.demo = line.substr(0, first);
    segments.push_back(segment);
  }
  if (segments.empty()) throw Error(ExitCode::kInput, {path, 0, 0}, "no demonstration");
  return segments;
}

std::size_t tupleAt(const std::vector<double>& times, double time, const std::string& path) {
  const auto found = std::find(times.begin(), times.end(), time);
  if (found == times.end()) {
    throw Error(ExitCode::kInput, {path, 0, 0},
                "no tuple has the time " + formatDouble(time) + " of segments.csv");
  }
  return std::size_t(found - times.begin());
}

/// `estimates`: "optimized", or "iterations/5".
DemonstrationEstimate readDemonstrationFolder(const std::string& directory,
                                              const std::string& estimates,
                                              const SegmentLine& segment) {
  DemonstrationEstimate demo;
  demo.name = segment.demo;
  const std::string folder = directory + "/" + estimates + "/" + segment.demo + "/";
  Diagnostics diagnostics;
  const auto read = [&](const char* name) {
    const Trajectory track = readTum(folder + name, diagnostics);
    diagnostics.throwIfErrors();
    if (demo.times.empty()) demo.times = track.times;
    if (track.times != demo.times) {
      throw Error(ExitCode::kInput, {folder + name, 0, 0}, "its stamps are not those of hand.tum");
    }
    return track.poses;
  };
  demo.hand = read("hand.tum");
  demo.object = read("object.tum");
  demo.torso = read("torso.tum");
  demo.gripper = read("gripper.tum");
  for (const Pose& base : read("base.tum")) demo.base.push_back(uprightBase(base));
  demo.segments.grasp = tupleAt(demo.times, segment.grasp_time, folder + "hand.tum");
  demo.segments.release = tupleAt(demo.times, segment.release_time, folder + "hand.tum");
  if (demo.segments.release < demo.segments.grasp) {
    throw Error(ExitCode::kInput, {directory + "/segments.csv", 0, 0},
                "the release of " + graft::quoted(segment.demo) + " is before its grasp");
  }
  return demo;
}

}  // namespace

std::vector<DemonstrationEstimate> readEstimates(const std::string& directory,
                                                 const std::string& estimates) {
  std::vector<DemonstrationEstimate> demos;
  std::vector<Pose> holds;
  for (const SegmentLine& segment : readSegments(directory + "/segments.csv")) {
    demos.push_back(readDemonstrationFolder(directory, estimates, segment));
    std::vector<Pose> held;
    for (std::size_t i = demos.back().segments.grasp; i <= demos.back().segments.release; ++i) {
      held.push_back(demos.back().object[i].inverse() * demos.back().hand[i]);
    }
    holds.push_back(meanPose(held));
  }
  const std::vector<char> turned = turnedHands(holds);
  for (std::size_t d = 0; d < turned.size(); ++d) demos[d].hand_turned = turned[d] != 0;
  return demos;
}

LearnedFolder readLearnedFolder(const std::string& directory) {
  return {readSceneFiles(directory), readEstimates(directory, "optimized")};
}

MotionModel fitMotionModel(const std::string& task_name,
                           const std::vector<DemonstrationEstimate>& demonstrations,
                           Diagnostics& diagnostics) {
  MotionModel model;
  model.task = task_name;
  const char* const names[] = {"reach", "manipulate", "retreat"};
  for (int segment = 0; segment < 3; ++segment) {
    std::vector<SegmentDemonstration> parts;
    for (const DemonstrationEstimate& demo : demonstrations) {
      const std::size_t bounds[] = {0, demo.segments.grasp, demo.segments.release, demo.size() - 1};
      SegmentDemonstration part;
      part.world_T_object = demo.object[demo.segments.grasp];
      for (std::size_t i = bounds[segment]; i <= bounds[segment + 1]; ++i) {
        part.samples.push_back({demo.times[i], demo.gripper[i], demo.base[i]});
      }
      parts.push_back(std::move(part));
    }
    FitReport report;
    try {
      model.segments.push_back(fitSegment(names[segment], parts, FitOptions(), &report));
    } catch (const Error& error) {
      if (error.code() != ExitCode::kNoResult) throw;
      diagnostics.warning(
          {}, std::string("no model of the segment ") + names[segment] + ": " + error.what());
    }
    for (const std::string& note : report.notes) {
      diagnostics.note({}, std::string(names[segment]) + ": " + note);
    }
  }
  return model;
}

}  // namespace graft::lfd
