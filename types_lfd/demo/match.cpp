// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/match.hpp"

#include <algorithm>

#include "core/base/text.hpp"
#include "types_lfd/demo/torso.hpp"

namespace graft::lfd {

std::size_t MatchedTrack::measuredCount() const {
  return static_cast<std::size_t>(std::count(measured.begin(), measured.end(), 1));
}

MatchedTrack resample(const Trajectory& track, const std::vector<double>& times) {
  MatchedTrack matched;
  matched.poses.reserve(times.size());
  matched.measured.reserve(times.size());
  std::size_t next = 0;  // first stamp of the track that is not before the wanted one
  for (const double time : times) {
    while (next < track.size() && track.times[next] < time) ++next;
    if (next < track.size() && track.times[next] == time) {
      matched.poses.push_back(track.poses[next]);
      matched.measured.push_back(1);
      continue;
    }
    if (next == 0 || next == track.size()) {
      throw Error(ExitCode::kInternal, "resampling outside of a track's span");
    }
    const double before = track.times[next - 1];
    const double fraction = (time - before) / (track.times[next] - before);
    matched.poses.push_back(interpolate(track.poses[next - 1], track.poses[next], fraction));
    matched.measured.push_back(0);
  }
  return matched;
}

MatchedDemonstration matchTracks(const Demonstration& demonstration) {
  const auto fail = [&](const std::string& what) {
    throw Error(ExitCode::kInput, "demonstration " + quoted(demonstration.name) + ": " + what +
                                      ": " + describeSpans(demonstration));
  };
  if (demonstration.hand.size() == 0 || demonstration.object.size() == 0) {
    fail("hand and object must be recorded");
  }
  const TimeSpan common = commonSpan(demonstration);
  if (common.first > common.last) fail("the tracks do not overlap in time");

  MatchedDemonstration matched;
  matched.name = demonstration.name;
  for (const std::vector<double>* stamps :
       {&demonstration.hand.times, &demonstration.object.times, &demonstration.torso.times,
        &demonstration.dropped_stamps}) {
    for (const double time : *stamps) {
      if (time >= common.first && time <= common.last) matched.times.push_back(time);
    }
  }
  std::sort(matched.times.begin(), matched.times.end());
  matched.times.erase(std::unique(matched.times.begin(), matched.times.end()), matched.times.end());
  if (matched.size() < 2) fail("the tracks have only one stamp in common");

  matched.hand = resample(demonstration.hand, matched.times);
  matched.object = resample(demonstration.object, matched.times);
  if (demonstration.torso.size() > 0) {
    matched.torso = resample(demonstration.torso, matched.times);
  } else {
    matched.torso = estimateTorso(matched);
    matched.torso_estimated = true;
  }
  return matched;
}

}  // namespace graft::lfd
