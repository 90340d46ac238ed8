// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "types_lfd/model/expectation_maximization.hpp"
#include "types_lfd/model/segment_chart.hpp"

namespace graft::lfd {

/// One demonstration's part that belongs to a segment: samples in the world
/// frame with strictly rising times, and the object's pose at the grasp (last
/// tuple of reaching), which is the model frame of all segments.
struct SegmentDemonstration {
  std::vector<MotionSample> samples;
  Pose world_T_object;
};

/// What was learned of one segment (reach, manipulate, retreat).
struct SegmentModel {
  std::string name;
  double duration = 0;      ///< s, mean over demonstrations; t of the mixture is 0..1 of it
  SegmentChart chart;       ///< frames and orientation coordinates of the state
  MotionState start;        ///< mean first state of the demonstrations
  MotionState end;          ///< mean last state
  GaussianMixture mixture;  ///< over [t; state], dimension 1 + kStateDimension
  int demonstrations = 0;
  int samples = 0;                        ///< columns the mixture was fitted to
  std::vector<ComponentScore> selection;  ///< number of components against BIC
};

/// The motion of a task: its segments in order, each starting where the one
/// before ends.
struct MotionModel {
  std::string task;
  std::vector<SegmentModel> segments;
};

struct FitOptions {
  EmOptions mixture;
  /// Every demonstration is resampled at equal steps of normalised time, so that
  /// each counts alike whatever its rate: to the median number of samples, within
  /// these limits.
  int minimum_resampled = 20;
  int maximum_resampled = 100;
};

/// What a fit had to say beside its result.
struct FitReport {
  std::vector<double> log_likelihood;  ///< per iteration of the chosen mixture
  std::vector<std::string> notes;      ///< guesses, reductions, skipped demonstrations
};

/// Learns one segment (paper, section V). The demonstrations' samples at the same
/// normalised time share their component (see SampleGroups), so that components
/// are phases of the motion. Demonstrations with fewer than two
/// samples are left out, with a note. Throws Error(kInput) for times that do not
/// rise or numbers that are not finite, Error(kNoResult) where no demonstration
/// remains, and as fitMixture does.
SegmentModel fitSegment(const std::string& name,
                        const std::vector<SegmentDemonstration>& demonstrations,
                        const FitOptions& options, FitReport* report = nullptr);

}  // namespace graft::lfd
