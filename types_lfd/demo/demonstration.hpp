// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/io/trajectory.hpp"
#include "types_lfd/demo/task.hpp"

namespace graft::lfd {

/// Three tracks of one demonstration in the fixed frame (map, z up), each with
/// its own stamps (s).
struct Demonstration {
  std::string name;
  Trajectory hand;
  Trajectory object;
  Trajectory torso;  ///< empty if not recorded
  /// Stamps of poses that were dropped as outliers (clean.hpp), in any order:
  /// they stay stamps of tuples, only the pose is interpolated.
  std::vector<double> dropped_stamps;
};

/// Span [first, last] of stamps, s.
struct TimeSpan {
  double first = 0;
  double last = 0;
};

/// Span of a track; the track must not be empty.
TimeSpan spanOf(const Trajectory& track);
/// The span that all tracks of the demonstration cover; first > last if none.
TimeSpan commonSpan(const Demonstration& demonstration);
/// "hand covers 1.5 to 9 s, object covers ...", for messages.
std::string describeSpans(const Demonstration& demonstration);

/// What a person wants to know of a track before it is used.
struct TrackSummary {
  std::size_t poses = 0;
  double duration = 0;         ///< s
  double median_interval = 0;  ///< s
  double longest_gap = 0;      ///< s
  double gap_start = 0;        ///< stamp at which the longest gap begins
};
/// The track needs at least 2 poses.
TrackSummary summarize(const Trajectory& track);

/// Reads the tracks of one demonstration and applies its hand_offset (hand pose
/// times marker_T_palm). Defects go to `diagnostics`: a file that is missing or
/// rejected by name, tracks that do not overlap with the intervals of all; gaps
/// of more than 2 s (and 5 median intervals) are warnings.
Demonstration readDemonstration(const DemonstrationSpec& spec, Diagnostics& diagnostics);

/// The same for all demonstrations of a task, in its order.
std::vector<Demonstration> readDemonstrations(const Task& task, Diagnostics& diagnostics);

}  // namespace graft::lfd
