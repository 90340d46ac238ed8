// SPDX-License-Identifier: BSD-3-Clause
#include "tests/types_lfd/demo/synthetic.hpp"

#include <algorithm>
#include <random>

namespace graft::lfd {

namespace {

/// Share done of a minimum-jerk movement at fraction x of its duration.
double done(double x) {
  const double r = std::clamp(x, 0.0, 1.0);
  return r * r * r * (10 - 15 * r + 6 * r * r);
}

template <class PoseAt>
Trajectory sample(const SyntheticRecording& recording, double rate, double scale,
                  std::mt19937_64& random, const PoseAt& poseAt) {
  std::normal_distribution<double> normal;
  Trajectory track;
  const double end = recording.endTime();
  for (int i = 0; recording.start + i / rate <= end; ++i) {
    const double time = recording.start + i / rate;
    Vec<double, 6> noise;
    for (int k = 0; k < 6; ++k) {
      noise[k] = scale * (k < 3 ? recording.sigma_t : recording.sigma_r) * normal(random);
    }
    track.times.push_back(time);
    track.poses.push_back(poseAt(time).plus(noise));
  }
  return track;
}

}  // namespace

Pose SyntheticRecording::objectAt(double time) const {
  const double pulled = way * done((time - graspTime() - rest) / pull);
  const Eigen::Quaterniond turn = expSO3<double>(Eigen::Vector3d(0, 0, yaw));
  return Pose(turn * Eigen::Vector3d(1 - pulled, 0.2, 0.8), turn);
}

Pose SyntheticRecording::handAt(double time) const {
  const double to_go = 1 - done((time - start - lead) / reach);
  const double away = done((time - releaseTime()) / retreat);
  const Eigen::Vector3d offset =
      to_go * Eigen::Vector3d(-0.5, 0.1, -0.1) + away * Eigen::Vector3d(-0.3, 0.05, 0.05);
  return objectAt(time) *
         Pose(Eigen::Vector3d(-0.05, 0.3, 0.02) + offset, Eigen::Quaterniond::Identity());
}

Demonstration SyntheticRecording::record() const {
  std::mt19937_64 random(seed);
  Demonstration demonstration;
  demonstration.name = "synthetic";
  demonstration.hand =
      sample(*this, hand_rate, 1, random, [&](double time) { return handAt(time); });
  demonstration.object =
      sample(*this, object_rate, 0.5, random, [&](double time) { return objectAt(time); });
  return demonstration;
}

}  // namespace graft::lfd
