// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/demonstration.hpp"

#include <algorithm>

#include "core/base/text.hpp"
#include "types_lfd/demo/statistics.hpp"

namespace graft::lfd {

namespace {

// Longer than any glance away or occlusion by the own arm, s.
constexpr double kLongGap = 2;

void warnOfGap(const std::string& path, const Trajectory& track, Diagnostics& diagnostics) {
  const TrackSummary summary = summarize(track);
  if (summary.longest_gap < std::max(kLongGap, 5 * summary.median_interval)) return;
  diagnostics.warning({path, 0, 0}, "no pose for " + formatDouble(summary.longest_gap) +
                                        " s after " + formatDouble(summary.gap_start) +
                                        "; tuples there are interpolated");
}

/// Reads one file; true if it is a usable track.
bool readOneTrack(const std::string& path, Trajectory& track, Diagnostics& diagnostics) {
  // Its own collection: what is wrong with one file must not hide what is
  // wrong with the next.
  Diagnostics found;
  try {
    track = readTrack(path, found);
  } catch (const Error& error) {
    found.error(error.where(), error.what());
  }
  if (track.size() >= 2) warnOfGap(path, track, found);
  diagnostics.append(found);
  return found.errorCount() == 0;
}

}  // namespace

TimeSpan spanOf(const Trajectory& track) { return {track.times.front(), track.times.back()}; }

TimeSpan commonSpan(const Demonstration& demonstration) {
  TimeSpan common = spanOf(demonstration.hand);
  for (const Trajectory* track : {&demonstration.object, &demonstration.torso}) {
    if (track->size() == 0) continue;
    const TimeSpan span = spanOf(*track);
    common.first = std::max(common.first, span.first);
    common.last = std::min(common.last, span.last);
  }
  return common;
}

std::string describeSpans(const Demonstration& demonstration) {
  std::string text;
  const auto add = [&](const char* name, const Trajectory& track) {
    if (track.size() == 0) return;
    const TimeSpan span = spanOf(track);
    text += (text.empty() ? "" : ", ") + std::string(name) + " covers " + formatDouble(span.first) +
            " to " + formatDouble(span.last) + " s";
  };
  add("hand", demonstration.hand);
  add("object", demonstration.object);
  add("torso", demonstration.torso);
  return text;
}

TrackSummary summarize(const Trajectory& track) {
  TrackSummary summary;
  summary.poses = track.size();
  const TimeSpan span = spanOf(track);
  summary.duration = span.last - span.first;
  std::vector<double> intervals;
  for (std::size_t i = 1; i < track.size(); ++i) {
    intervals.push_back(track.times[i] - track.times[i - 1]);
    if (intervals.back() <= summary.longest_gap) continue;
    summary.longest_gap = intervals.back();
    summary.gap_start = track.times[i - 1];
  }
  summary.median_interval = medianOf(std::move(intervals));
  return summary;
}

Demonstration readDemonstration(const DemonstrationSpec& spec, Diagnostics& diagnostics) {
  Demonstration demonstration;
  demonstration.name = spec.name;
  bool usable = readOneTrack(spec.hand, demonstration.hand, diagnostics);
  usable = readOneTrack(spec.object, demonstration.object, diagnostics) && usable;
  if (!spec.torso.empty()) {
    usable = readOneTrack(spec.torso, demonstration.torso, diagnostics) && usable;
  }
  if (spec.hand_offset) {
    for (Pose& pose : demonstration.hand.poses) {
      pose = pose * *spec.hand_offset;
      pose.renormalize();
    }
  }
  if (!usable) return demonstration;
  const TimeSpan common = commonSpan(demonstration);
  if (!(common.first < common.last)) {
    diagnostics.error(
        spec.where, "demonstration " + quoted(spec.name) + ": the tracks do not overlap in time: " +
                        describeSpans(demonstration) + "; were they stamped by one clock?");
  }
  return demonstration;
}

std::vector<Demonstration> readDemonstrations(const Task& task, Diagnostics& diagnostics) {
  std::vector<Demonstration> demonstrations;
  demonstrations.reserve(task.demonstrations.size());
  for (const DemonstrationSpec& spec : task.demonstrations) {
    demonstrations.push_back(readDemonstration(spec, diagnostics));
  }
  return demonstrations;
}

}  // namespace graft::lfd
