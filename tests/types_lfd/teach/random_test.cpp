// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "types_lfd/teach/scenario.hpp"
#include "types_lfd/teach/smooth_path.hpp"
#include "types_lfd/teach/tracker.hpp"

namespace graft::lfd {
namespace {

TEST(Random, UniformStaysInItsRangeAndFillsIt) {
  Random random(7);
  std::vector<int> bins(10);
  for (int i = 0; i < 100000; ++i) {
    const double u = random.uniform(-2, 3);
    ASSERT_GE(u, -2);
    ASSERT_LT(u, 3);
    ++bins[static_cast<std::size_t>((u + 2) * 2)];
  }
  // Binomial with mean 10000 and sigma 95.
  for (const int count : bins) EXPECT_NEAR(count, 10000, 5 * 95);
}

TEST(Random, NormalHasTheMomentsAndTailsOfTheNormalDistribution) {
  Random random(8);
  constexpr int kCount = 200000;
  double sums[4] = {};
  int beyond_two = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal();
    for (int k = 0; k < 4; ++k) sums[k] += std::pow(x, k + 1);
    beyond_two += std::abs(x) > 2;
  }
  const double root = std::sqrt(static_cast<double>(kCount));
  EXPECT_NEAR(sums[0] / kCount, 0, 5 / root);
  EXPECT_NEAR(sums[1] / kCount, 1, 5 * std::sqrt(2.0) / root);
  EXPECT_NEAR(sums[2] / kCount, 0, 5 * std::sqrt(15.0) / root);
  EXPECT_NEAR(sums[3] / kCount, 3, 5 * std::sqrt(96.0) / root);
  EXPECT_NEAR(static_cast<double>(beyond_two) / kCount, std::erfc(std::sqrt(2.0)), 5 * 0.21 / root);
}

TEST(Random, StreamsAreApart) {
  Random a(1, 2, 3);
  Random same(1, 2, 3);
  EXPECT_EQ(a.uniform(0, 1), same.uniform(0, 1));
  const double x = Random(1, 2, 3).uniform(0, 1);
  EXPECT_NE(Random(2, 2, 3).uniform(0, 1), x);
  EXPECT_NE(Random(1, 3, 3).uniform(0, 1), x);
  EXPECT_NE(Random(1, 2, 4).uniform(0, 1), x);
}

TEST(MinimumJerk, RestsAtBothEnds) {
  EXPECT_EQ(minimumJerkFraction(-1), 0);
  EXPECT_EQ(minimumJerkFraction(0), 0);
  EXPECT_EQ(minimumJerkFraction(0.5), 0.5);
  EXPECT_EQ(minimumJerkFraction(1), 1);
  EXPECT_EQ(minimumJerkFraction(2), 1);
  const double h = 1e-4;
  EXPECT_LT(minimumJerkFraction(h), 11 * h * h * h);  // velocity and acceleration are 0
  EXPECT_LT(1 - minimumJerkFraction(1 - h), 11 * h * h * h);
}

TEST(PlanarPath, PassesItsPointsWithContinuousVelocity) {
  PlanarPath path;
  const double times[] = {0, 1, 1.5, 4};
  Random random(9);
  std::vector<Eigen::Vector3d> points;
  for (const double t : times) {
    points.push_back(random.normal3(1));
    path.add(t, points.back());
  }
  const double h = 1e-6;
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT((path.at(times[i]) - points[i]).norm(), 1e-12);
    const Eigen::Vector3d before = (path.at(times[i]) - path.at(times[i] - h)) / h;
    const Eigen::Vector3d after = (path.at(times[i] + h) - path.at(times[i])) / h;
    EXPECT_LT((before - after).norm(), 1e-4);
    if (i == 0 || i == 3) {
      EXPECT_LT(after.norm(), 1e-4);
    }
  }
}

TEST(Tracker, NoiseHasTheStatedSigmaAndCorrelation) {
  Trajectory truth;
  for (int i = 0; i < 60000; ++i) {
    truth.times.push_back(0.1 * i);
    truth.poses.emplace_back(Eigen::Vector3d(1, 2, 3), Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5));
  }
  TrackerModel model;
  model.sigma_t = 0.02;
  model.sigma_r = 0.1;
  Random random(10);
  const Trajectory observed = observe(truth, model, random);
  ASSERT_EQ(observed.size(), truth.size());
  double variance_t = 0;
  double variance_r = 0;
  double lagged = 0;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector3d t = observed.poses[i].translation - truth.poses[i].translation;
    const Vec<double, 3> r =
        logSO3<double>(truth.poses[i].rotation.conjugate() * observed.poses[i].rotation);
    variance_t += t.squaredNorm() / 3;
    variance_r += r.squaredNorm() / 3;
    lagged += t.dot(last) / 3;
    last = t;
  }
  const double n = static_cast<double>(truth.size());
  EXPECT_NEAR(std::sqrt(variance_t / n), 0.02, 0.02 * 0.02);
  EXPECT_NEAR(std::sqrt(variance_r / n), 0.1, 0.02 * 0.1);
  // One step apart only the slow part is shared: 0.4 exp(-0.1 s / 1 s).
  EXPECT_NEAR(lagged / variance_t, 0.4 * std::exp(-0.1), 0.03);
}

TEST(Tracker, LosesFramesSinglyAndInBursts) {
  Trajectory truth;
  for (int i = 0; i < 150; ++i) {
    truth.times.push_back(i);
    truth.poses.emplace_back();
  }
  TrackerModel model;
  model.miss = 0.05;
  model.bursts = 2;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const Trajectory observed = observe(truth, model, random);
    ASSERT_GT(observed.size(), 100u);
    EXPECT_LT(observed.times.front(), 12);
    double longest = 0;
    for (std::size_t i = 1; i < observed.size(); ++i) {
      longest = std::max(longest, observed.times[i] - observed.times[i - 1]);
    }
    EXPECT_GE(longest, 5);  // a burst hides at least four frames
  }
}

// The numbers are those of both g++ and clang, which evaluate arguments in different orders.
TEST(Random, SceneOfASeedIsTheSameForEveryCompiler) {
  const Scenario scene = drawScenario("sliding_door", 22, TeachOptions());
  EXPECT_NEAR(scene.object_T_hand.translation.x(), -0.033298393608872719, 1e-12);
  EXPECT_NEAR(scene.object_T_hand.translation.z(), 0.0050534894578917978, 1e-12);
  EXPECT_NEAR(scene.world_T_scene.translation.x(), 0.89872991910452704, 1e-12);
  EXPECT_NEAR(scene.world_T_scene.translation.y(), -0.86564026514547221, 1e-12);
}

}  // namespace
}  // namespace graft::lfd
