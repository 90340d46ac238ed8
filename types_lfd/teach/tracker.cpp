// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/tracker.hpp"

#include <algorithm>
#include <cmath>

namespace graft::lfd {

namespace {

/// White noise plus a stationary first-order Gauss-Markov process.
class Noise {
 public:
  Noise(double sigma, const TrackerModel& tracker, Random& random)
      : white_(sigma * std::sqrt(tracker.white_share)),
        slow_(sigma * std::sqrt(1 - tracker.white_share)),
        time_(tracker.slow_time),
        state_(random.normal3(slow_)) {}

  Eigen::Vector3d next(double dt, Random& random) {
    const double keep = std::exp(-dt / time_);
    state_ = keep * state_ + random.normal3(slow_ * std::sqrt(1 - keep * keep));
    return state_ + random.normal3(white_);
  }

 private:
  double white_;
  double slow_;
  double time_;
  Eigen::Vector3d state_;
};

/// Which frames the tracker reports.
std::vector<bool> seenFrames(int frames, const TrackerModel& tracker, Random& random) {
  constexpr int kEdge = 4;
  std::vector<bool> seen(static_cast<std::size_t>(frames), true);
  if (tracker.skip_every > 0) {
    const int phase = random.below(tracker.skip_every);
    for (int i = phase; i < frames; i += tracker.skip_every) seen[i] = false;
  }
  if (tracker.bursts == 0) return seen;
  for (int i = 0; i < frames; ++i) {
    if (random.chance(tracker.miss)) seen[i] = false;
  }
  const int bursts = 1 + random.below(tracker.bursts);
  for (int i = 0; i < bursts; ++i) {
    const int length = 4 + random.below(7);
    const int start = kEdge + random.below(std::max(1, frames - length - 2 * kEdge));
    for (int k = start; k < std::min(start + length, frames); ++k) seen[k] = false;
  }
  const int late = random.below(4);
  const int early = random.below(4);
  for (int k = 0; k < late; ++k) seen[k] = false;
  for (int k = 0; k < early; ++k) seen[frames - 1 - k] = false;
  return seen;
}

}  // namespace

Trajectory observe(const Trajectory& truth, const TrackerModel& tracker, Random& random) {
  const std::vector<bool> seen = seenFrames(static_cast<int>(truth.size()), tracker, random);
  Noise translation(tracker.sigma_t, tracker, random);
  Noise rotation(tracker.sigma_r, tracker, random);
  Trajectory observed;
  double last = truth.times.front();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double dt = truth.times[i] - last;
    last = truth.times[i];
    // The camera's noise runs on while the marker is hidden.
    const Eigen::Vector3d shift = translation.next(dt, random);
    const Eigen::Vector3d turn = rotation.next(dt, random);
    if (!seen[i]) continue;
    const Pose& pose = truth.poses[i];
    observed.times.push_back(truth.times[i]);
    observed.poses.emplace_back(pose.translation + shift,
                                (pose.rotation * expSO3<double>(turn)).normalized());
  }
  return observed;
}

}  // namespace graft::lfd
