// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/io/trajectory.hpp"
#include "types_lfd/demo/demonstration.hpp"
#include "types_lfd/demo/task.hpp"

namespace graft::lfd {

/// Standard deviation of a track's white noise, per axis, from the track alone:
/// what a pose differs from the interpolation of its two neighbours, robustly
/// (median), scaled so that it is unbiased for Gaussian noise on a path that is
/// smooth at the track's rate. Works with uneven stamps; noise that is slower
/// than a few samples cannot be seen, and is not part of the result.
/// The result is at least 0.1 mm and 0.001 rad, so that it can be used as a
/// weight also for a track without noise. Throws Error(kInput) for a track of
/// fewer than 5 poses.
TrackerAccuracy estimateAccuracy(const Trajectory& track);

/// Accuracy per entity ("hand", "object", and "torso" where it was recorded):
/// the task's <tracker> where there is one, else estimated per track and pooled
/// over the demonstrations (quadratic mean), with a note to `diagnostics`.
std::map<std::string, TrackerAccuracy> trackerAccuracies(
    const Task& task, const std::vector<Demonstration>& demonstrations, Diagnostics& diagnostics);

}  // namespace graft::lfd
