// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "types_lfd/demo/match.hpp"
#include "types_lfd/demo/task.hpp"

namespace graft::lfd {

/// What a hand and an object are doing: moving without each other, together, or
/// in between, when contact is made or lost and velocities jump.
enum class MotionPhase { kFree, kContact, kHeld };
constexpr std::size_t kMotionPhases = 3;

/// Phase of a tuple. Contact is within this of grasp or release: what the
/// segmentation is off by in nine of ten cases, or less.
constexpr double kContactTime = 0.4;  // s
MotionPhase motionPhase(const std::vector<double>& times, std::size_t grasp, std::size_t release,
                        std::size_t i);

/// One track of a demonstration, with the phase of each of its tuples.
struct PhasedTrack {
  const std::vector<double>* times = nullptr;
  const MatchedTrack* track = nullptr;
  std::vector<MotionPhase> phases;
};

/// Root of the spectral density of a velocity that wanders (white-noise
/// acceleration): m/s and rad/s per square root of a second.
struct MotionNoise {
  double t = 0;
  double r = 0;
};

/// The motion noise under which the measured poses are most likely, per phase:
/// the likelihood of a Kalman filter's innovations (constant velocity, on the
/// rotation group for orientations), given the tracker's accuracy. `usual` is
/// the centre of the prior, which is a factor of four wide. Powers of two times
/// `usual` are tried. Source: Bar-Shalom, Li, Kirubarajan, "Estimation with
/// Applications to Tracking and Navigation", 2001, sections 6.2 and 11.
std::array<MotionNoise, kMotionPhases> estimateMotionNoise(const std::vector<PhasedTrack>& tracks,
                                                           const TrackerAccuracy& accuracy,
                                                           const MotionNoise& usual);

}  // namespace graft::lfd
