// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/grasp_modes.hpp"

#include <algorithm>
#include <cstdio>
#include <tuple>

#include "types_lfd/build/steadiness.hpp"

namespace graft::lfd {

namespace {

HoldGap gapOf(const GraspSpread& spread, std::size_t a, std::size_t b) {
  return holdGap(spread.object_T_hand[a], spread.object_T_hand[b]);
}

/// The larger of both gaps in units of its limit: at most 1 for the same hold.
double dissimilarity(const HoldGap& gap) {
  return std::max(gap.distance / kSameGraspDistance, gap.angle / kSameGraspAngle);
}

double linkage(const GraspSpread& spread, const GraspMode& a, const GraspMode& b) {
  double largest = 0;
  for (const std::size_t i : a.demonstrations) {
    for (const std::size_t j : b.demonstrations) {
      largest = std::max(largest, dissimilarity(gapOf(spread, i, j)));
    }
  }
  return largest;
}

std::string apart(double distance, double angle) {
  char text[80];
  std::snprintf(text, sizeof text, "%.1f cm and %.0f degrees", 100 * distance,
                angle * 180 / 3.14159265358979323846);
  return text;
}

std::string namesOf(const RecordedHolds& holds, const GraspMode& mode) {
  std::string text;
  for (const std::size_t d : mode.demonstrations) {
    text += (text.empty() ? "" : ", ") + holds.names[d];
  }
  return text;
}

/// The line of the task file that names a demonstration.
SourceLocation placeOf(const PreparedTask& task, std::size_t d) {
  const auto& specs = task.task.demonstrations;
  return {task.task.path, d < specs.size() ? specs[d].where.line : 0, 0};
}

}  // namespace

HoldGap holdGap(const Pose& a, const Pose& b) {
  const auto gap = [&](const Pose& other, bool turned) {
    const Vec<double, 6> e = poseError(a.inverse() * other);
    return HoldGap{e.head<3>().norm(), e.tail<3>().norm(), turned};
  };
  const HoldGap as_is = gap(b, false);
  const HoldGap turned = gap(flippedGrasp(b), true);
  return turned.angle < as_is.angle ? turned : as_is;
}

GraspSpread graspSpread(const std::vector<PreparedDemonstration>& demonstrations) {
  GraspSpread spread;
  for (const PreparedDemonstration& demo : demonstrations) {
    std::vector<Pose> poses;
    for (std::size_t i = demo.segments.grasp; i <= demo.segments.release; ++i) {
      poses.push_back(demo.objectToHand(i));
    }
    spread.object_T_hand.push_back(meanPose(poses));
  }
  for (std::size_t i = 0; i < demonstrations.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const HoldGap gap = gapOf(spread, i, j);
      spread.distance = std::max(spread.distance, gap.distance);
      spread.angle = std::max(spread.angle, gap.angle);
    }
  }
  return spread;
}

std::vector<GraspMode> findGraspModes(const GraspSpread& spread) {
  std::vector<GraspMode> modes;
  for (std::size_t d = 0; d < spread.object_T_hand.size(); ++d) modes.push_back({{d}, 0, 0});
  while (modes.size() > 1) {
    double best = 2;
    std::size_t keep = 0;
    std::size_t merge = 0;
    for (std::size_t b = 0; b < modes.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        const double link = linkage(spread, modes[a], modes[b]);
        if (link < best) std::tie(best, keep, merge) = std::make_tuple(link, a, b);
      }
    }
    if (best > 1) break;
    auto& target = modes[keep].demonstrations;
    const auto& source = modes[merge].demonstrations;
    target.insert(target.end(), source.begin(), source.end());
    modes.erase(modes.begin() + static_cast<std::ptrdiff_t>(merge));
  }
  for (GraspMode& mode : modes) {
    std::sort(mode.demonstrations.begin(), mode.demonstrations.end());
    for (const std::size_t i : mode.demonstrations) {
      for (const std::size_t j : mode.demonstrations) {
        if (i == j) continue;
        const HoldGap gap = gapOf(spread, i, j);
        mode.distance = std::max(mode.distance, gap.distance);
        mode.angle = std::max(mode.angle, gap.angle);
      }
    }
  }
  const auto order = [](const GraspMode& mode) {
    return std::make_tuple(-static_cast<std::ptrdiff_t>(mode.demonstrations.size()), mode.distance,
                           mode.angle, mode.demonstrations.front());
  };
  std::sort(modes.begin(), modes.end(),
            [&](const GraspMode& a, const GraspMode& b) { return order(a) < order(b); });
  return modes;
}

RecordedHolds recordedHolds(const std::vector<PreparedDemonstration>& demonstrations) {
  RecordedHolds holds;
  for (const PreparedDemonstration& demo : demonstrations) {
    holds.names.push_back(demo.matched.name);
  }
  holds.spread = graspSpread(demonstrations);
  holds.modes = findGraspModes(holds.spread);
  return holds;
}

std::vector<char> turnedHands(const std::vector<Pose>& object_T_hand) {
  std::vector<char> turned;
  turned.reserve(object_T_hand.size());
  for (const Pose& hold : object_T_hand) {
    turned.push_back(holdGap(object_T_hand.front(), hold).turned ? 1 : 0);
  }
  const auto count = std::count(turned.begin(), turned.end(), 1);
  if (2 * count > static_cast<std::ptrdiff_t>(turned.size())) {
    for (char& one : turned) one = one == 0 ? 1 : 0;
  }
  return turned;
}

void warnOfLeftOut(const PreparedTask& task, const RecordedHolds& holds, std::size_t mode,
                   Diagnostics& diagnostics) {
  const std::vector<std::size_t>& members = holds.modes[mode].demonstrations;
  const std::vector<std::string> lines = describeLeftOut(holds, mode);
  auto line = lines.begin();
  for (std::size_t d = 0; d < holds.names.size(); ++d) {
    if (std::binary_search(members.begin(), members.end(), d)) continue;
    diagnostics.warning(placeOf(task, d), *line++);
  }
}

PreparedTask taskOfMode(const PreparedTask& task, const RecordedHolds& holds, std::size_t mode,
                        Diagnostics& diagnostics) {
  const std::vector<std::size_t>& members = holds.modes[mode].demonstrations;
  PreparedTask part = task;
  part.task.demonstrations.clear();
  part.demonstrations.clear();
  std::vector<Pose> poses;
  for (const std::size_t d : members) {
    if (d < task.task.demonstrations.size()) {
      part.task.demonstrations.push_back(task.task.demonstrations[d]);
    }
    part.demonstrations.push_back(task.demonstrations[d]);
    poses.push_back(holds.spread.object_T_hand[d]);
  }
  const std::vector<char> turned = turnedHands(poses);
  for (std::size_t k = 0; k < members.size(); ++k) {
    part.demonstrations[k].hand_turned = turned[k] != 0;
    if (turned[k] == 0) continue;
    diagnostics.note(placeOf(task, members[k]),
                     holds.names[members[k]] +
                         ": the hand is turned by half a turn about its approach axis against the "
                         "others; for a parallel gripper that is the same grasp");
  }
  findSteadiness(part);
  return part;
}

PreparedTask prepareUsualMode(const std::string& task_path, Diagnostics& diagnostics) {
  const PreparedTask task = prepareTask(task_path, diagnostics);
  const RecordedHolds holds = recordedHolds(task.demonstrations);
  if (!holds.common()) {
    throw Error(ExitCode::kNoResult, {task_path, 0, 0},
                "no common grasp: no two demonstrations hold the object alike");
  }
  warnOfLeftOut(task, holds, 0, diagnostics);
  return taskOfMode(task, holds, 0, diagnostics);
}

std::vector<std::string> describeLeftOut(const RecordedHolds& holds, std::size_t mode) {
  std::vector<std::string> lines;
  const GraspMode& kept = holds.modes.at(mode);
  std::vector<std::size_t> mode_of(holds.names.size(), mode);
  for (std::size_t m = 0; m < holds.modes.size(); ++m) {
    for (const std::size_t d : holds.modes[m].demonstrations) mode_of[d] = m;
  }
  for (std::size_t d = 0; d < holds.names.size(); ++d) {
    if (mode_of[d] == mode) continue;
    double distance = 0;
    double angle = 0;
    for (const std::size_t other : kept.demonstrations) {
      const HoldGap gap = gapOf(holds.spread, d, other);
      distance = std::max(distance, gap.distance);
      angle = std::max(angle, gap.angle);
    }
    lines.push_back(holds.names[d] + " is left out: it holds the object up to " +
                    apart(distance, angle) + " from " + namesOf(holds, kept) + " (mode " +
                    std::to_string(mode) + "); its way is mode " + std::to_string(mode_of[d]));
  }
  return lines;
}

std::vector<std::string> describeDisagreement(const RecordedHolds& holds) {
  std::vector<std::string> lines;
  for (std::size_t b = 0; b < holds.names.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const HoldGap gap = gapOf(holds.spread, a, b);
      if (gap.same()) continue;
      lines.push_back(holds.names[a] + " and " + holds.names[b] + " hold the object " +
                      apart(gap.distance, gap.angle) + " apart");
    }
  }
  return lines;
}

}  // namespace graft::lfd
