// SPDX-License-Identifier: BSD-3-Clause
// Motion noise from tracks that were drawn with a known one.
#include "types_lfd/demo/motion_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/geometry/se3.hpp"

namespace graft::lfd {
namespace {

constexpr std::size_t kSamples = 900;
constexpr double kSpacing = 0.05;  // s
constexpr TrackerAccuracy kTracker{0.004, 0.01};

/// A velocity that wanders by the noise of the phase, integrated in steps much
/// finer than the samples, and measured with the tracker's noise.
struct Drawn {
  std::vector<double> times;
  MatchedTrack track;
  std::vector<MotionPhase> phases;

  Drawn(const std::array<MotionNoise, kMotionPhases>& noise, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto draw = [&](double sigma) {
      return Vec<double, 3>(sigma * normal(random), sigma * normal(random), sigma * normal(random));
    };
    Pose pose;
    Vec<double, 3> velocity = Vec<double, 3>::Zero();
    Vec<double, 3> turning = Vec<double, 3>::Zero();
    constexpr int kFine = 10;
    const double dt = kSpacing / kFine;
    for (std::size_t i = 0; i < kSamples; ++i) {
      const auto phase = MotionPhase(i * kMotionPhases / kSamples);
      for (int k = 0; k < kFine; ++k) {
        pose.translation += velocity * dt;
        pose.rotation = pose.rotation * expSO3<double>(Vec<double, 3>(turning * dt));
        velocity += draw(noise[std::size_t(phase)].t * std::sqrt(dt));
        turning += draw(noise[std::size_t(phase)].r * std::sqrt(dt));
      }
      pose.rotation.normalize();
      Pose seen = pose;
      seen.translation += draw(kTracker.sigma_t);
      seen.rotation = seen.rotation * expSO3<double>(draw(kTracker.sigma_r));
      times.push_back(double(i) * kSpacing);
      phases.push_back(phase);
      track.poses.push_back(seen);
      // Every seventh sample was interpolated: it says nothing.
      track.measured.push_back(i % 7 != 3);
      if (!track.measured.back()) track.poses.back() = Pose();
    }
  }
  PhasedTrack phased() const { return {&times, &track, phases}; }
};

const std::array<MotionNoise, kMotionPhases> kNoise = {
    MotionNoise{0.01, 0.05}, MotionNoise{0.2, 0.8}, MotionNoise{0.05, 0.1}};

TEST(MotionNoise, IsFoundWithinOneLevel) {
  const Drawn a(kNoise, 1);
  const Drawn b(kNoise, 2);
  const auto found =
      estimateMotionNoise({a.phased(), b.phased()}, kTracker, MotionNoise{0.07, 0.15});
  for (std::size_t p = 0; p < kMotionPhases; ++p) {
    EXPECT_LE(std::abs(std::log2(found[p].t / kNoise[p].t)), 1) << "phase " << p;
    EXPECT_LE(std::abs(std::log2(found[p].r / kNoise[p].r)), 1) << "phase " << p;
  }
}

TEST(MotionNoise, IsTheSameInAnotherFrame) {
  Drawn drawn(kNoise, 3);
  const MotionNoise usual{0.05, 0.2};
  const auto here = estimateMotionNoise({drawn.phased()}, kTracker, usual);
  const Pose moved(Vec<double, 3>(3, -2, 1), expSO3<double>(Vec<double, 3>(0.3, -0.2, 2)));
  for (Pose& pose : drawn.track.poses) pose = moved * pose;
  const auto there = estimateMotionNoise({drawn.phased()}, kTracker, usual);
  for (std::size_t p = 0; p < kMotionPhases; ++p) {
    EXPECT_EQ(here[p].t, there[p].t);
    EXPECT_EQ(here[p].r, there[p].r);
  }
}

TEST(MotionNoise, OfWhatStandsStillIsSmall) {
  std::array<MotionNoise, kMotionPhases> none{};
  const Drawn drawn(none, 4);
  const auto found = estimateMotionNoise({drawn.phased()}, kTracker, MotionNoise{0.05, 0.2});
  for (std::size_t p = 0; p < kMotionPhases; ++p) {
    EXPECT_LT(found[p].t, 0.05 / 8);
    EXPECT_LT(found[p].r, 0.2 / 8);
  }
}

TEST(MotionNoise, IsTheUsualWhereNothingWasMeasured) {
  Drawn drawn(kNoise, 5);
  drawn.track.measured.assign(kSamples, false);
  const auto found = estimateMotionNoise({drawn.phased()}, kTracker, MotionNoise{0.05, 0.2});
  for (std::size_t p = 0; p < kMotionPhases; ++p) {
    EXPECT_EQ(found[p].t, 0.05);
    EXPECT_EQ(found[p].r, 0.2);
  }
}

TEST(MotionNoise, PhasesFollowGraspAndRelease) {
  std::vector<double> times;
  for (int i = 0; i <= 50; ++i) times.push_back(100 + 0.1 * i);
  const auto at = [&](std::size_t i) { return motionPhase(times, 10, 30, i); };
  EXPECT_EQ(at(0), MotionPhase::kFree);
  EXPECT_EQ(at(5), MotionPhase::kFree);
  EXPECT_EQ(at(7), MotionPhase::kContact);
  EXPECT_EQ(at(13), MotionPhase::kContact);
  EXPECT_EQ(at(15), MotionPhase::kHeld);
  EXPECT_EQ(at(25), MotionPhase::kHeld);
  EXPECT_EQ(at(28), MotionPhase::kContact);
  EXPECT_EQ(at(33), MotionPhase::kContact);
  EXPECT_EQ(at(35), MotionPhase::kFree);
}

}  // namespace
}  // namespace graft::lfd
