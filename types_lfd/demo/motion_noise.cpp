// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/motion_noise.hpp"

#include <algorithm>
#include <cmath>

#include "core/geometry/se3.hpp"

namespace graft::lfd {

namespace {

constexpr int kHalvings = 6;             ///< at most, of the usual noise; and doublings
constexpr double kPriorDoublings = 2;    ///< standard deviation of the prior
constexpr double kVelocityVariance = 4;  ///< before anything was seen: (2 m/s)^2, (2 rad/s)^2
constexpr int kRounds = 4;

using Levels = std::array<int, kMotionPhases>;

/// Three axes that share their covariance; the mean is kept by the caller.
struct Filter {
  double pp;
  double pv = 0;
  double vv = kVelocityVariance;

  void predict(double dt, double q) {
    pp += 2 * dt * pv + dt * dt * vv + q * q * dt * dt * dt / 3;
    pv += dt * vv + q * q * dt * dt / 2;
    vv += q * q * dt;
  }
  /// Gains for position and velocity under measurements of variance r.
  void update(double r, double& position, double& velocity) {
    const double s = pp + r;
    position = pp / s;
    velocity = pv / s;
    vv -= velocity * pv;
    pv -= position * pv;
    pp -= position * pp;
  }
};

double surprise(const Vec<double, 3>& innovation, double variance) {
  return innovation.squaredNorm() / variance + 3 * std::log(variance);
}

/// -2 log likelihood of a track's translations (or rotations), given the noise
/// of each phase.
double surpriseOf(const PhasedTrack& phased, bool rotation, double sigma,
                  const std::array<double, kMotionPhases>& noise) {
  const MatchedTrack& track = *phased.track;
  const std::vector<double>& times = *phased.times;
  double sum = 0;
  bool begun = false;
  Filter filter{sigma * sigma};
  Pose pose;
  Vec<double, 3> velocity = Vec<double, 3>::Zero();
  double last = 0;
  for (std::size_t i = 0; i < track.poses.size(); ++i) {
    const double dt = times[i] - last;
    if (begun) {
      filter.predict(dt, noise[std::size_t(phased.phases[i])]);
      if (rotation) {
        pose.rotation = pose.rotation * expSO3<double>(Vec<double, 3>(velocity * dt));
      } else {
        pose.translation += velocity * dt;
      }
    }
    last = times[i];
    if (!track.measured[i]) continue;
    if (!begun) {
      pose = track.poses[i];
      begun = true;
      continue;
    }
    Vec<double, 3> innovation;
    if (rotation) {
      innovation = logSO3(Eigen::Quaterniond(pose.rotation.conjugate() * track.poses[i].rotation));
    } else {
      innovation = track.poses[i].translation - pose.translation;
    }
    sum += surprise(innovation, filter.pp + sigma * sigma);
    double gain = 0;
    double velocity_gain = 0;
    filter.update(sigma * sigma, gain, velocity_gain);
    if (rotation) {
      pose.rotation =
          (pose.rotation * expSO3<double>(Vec<double, 3>(gain * innovation))).normalized();
    } else {
      pose.translation += gain * innovation;
    }
    velocity += velocity_gain * innovation;
  }
  return sum;
}

/// One phase after the other until none changes: each of few levels, so that
/// rounding decides nothing.
std::array<double, kMotionPhases> mostLikely(const std::vector<PhasedTrack>& tracks, bool rotation,
                                             double sigma, double usual) {
  const auto noiseAt = [usual](const Levels& levels) {
    std::array<double, kMotionPhases> noise{};
    for (std::size_t p = 0; p < kMotionPhases; ++p) noise[p] = std::ldexp(usual, levels[p]);
    return noise;
  };
  const auto cost = [&](const Levels& levels) {
    double sum = 0;
    for (const int level : levels) sum += level * level / (kPriorDoublings * kPriorDoublings);
    const auto noise = noiseAt(levels);
    for (const PhasedTrack& track : tracks) sum += surpriseOf(track, rotation, sigma, noise);
    return sum;
  };
  Levels best{};
  double least = cost(best);
  for (int round = 0; round < kRounds; ++round) {
    const Levels before = best;
    for (std::size_t p = 0; p < kMotionPhases; ++p) {
      Levels tried = best;
      for (int level = -kHalvings; level <= kHalvings; ++level) {
        if (level == best[p]) continue;
        tried[p] = level;
        const double c = cost(tried);
        if (c < least) {
          least = c;
          best = tried;
        }
      }
    }
    if (best == before) break;
  }
  return noiseAt(best);
}

}  // namespace

MotionPhase motionPhase(const std::vector<double>& times, std::size_t grasp, std::size_t release,
                        std::size_t i) {
  const double t = times[i];
  if (std::abs(t - times[grasp]) <= kContactTime || std::abs(t - times[release]) <= kContactTime) {
    return MotionPhase::kContact;
  }
  return i > grasp && i < release ? MotionPhase::kHeld : MotionPhase::kFree;
}

std::array<MotionNoise, kMotionPhases> estimateMotionNoise(const std::vector<PhasedTrack>& tracks,
                                                           const TrackerAccuracy& accuracy,
                                                           const MotionNoise& usual) {
  const auto t = mostLikely(tracks, false, accuracy.sigma_t, usual.t);
  const auto r = mostLikely(tracks, true, accuracy.sigma_r, usual.r);
  std::array<MotionNoise, kMotionPhases> noise;
  for (std::size_t p = 0; p < kMotionPhases; ++p) noise[p] = {t[p], r[p]};
  return noise;
}

}  // namespace graft::lfd
