// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/accuracy.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/types_lfd/demo/synthetic.hpp"

namespace graft::lfd {
namespace {

TEST(EstimateAccuracy, FindsPlantedNoise) {
  const std::pair<double, double> planted[] = {{0.002, 0.01}, {0.01, 0.05}, {0.03, 0.2}};
  for (const auto& [sigma_t, sigma_r] : planted) {
    SyntheticRecording recording;
    recording.sigma_t = sigma_t;
    recording.sigma_r = sigma_r;
    recording.hand_rate = 30;
    recording.object_rate = 30;
    double sum_t = 0;
    double sum_r = 0;
    constexpr int kRuns = 20;
    for (int run = 1; run <= kRuns; ++run) {
      recording.seed = static_cast<std::uint64_t>(run);
      const Demonstration demonstration = recording.record();
      const TrackerAccuracy hand = estimateAccuracy(demonstration.hand);
      EXPECT_NEAR(hand.sigma_t / sigma_t, 1, 0.15);
      EXPECT_NEAR(hand.sigma_r / sigma_r, 1, 0.15);
      const TrackerAccuracy object = estimateAccuracy(demonstration.object);
      EXPECT_NEAR(object.sigma_t / (0.5 * sigma_t), 1, 0.15);
      sum_t += hand.sigma_t / sigma_t / kRuns;
      sum_r += hand.sigma_r / sigma_r / kRuns;
    }
    EXPECT_NEAR(sum_t, 1, 0.03) << "biased";
    EXPECT_NEAR(sum_r, 1, 0.03) << "biased";
  }
}

TEST(EstimateAccuracy, IsNotMovedByGapsAndOutliers) {
  SyntheticRecording recording;
  recording.sigma_t = 0.01;
  recording.sigma_r = 0.05;
  recording.hand_rate = 30;
  const Trajectory full = recording.record().hand;
  std::mt19937_64 random(3);
  Trajectory track;
  for (std::size_t i = 0; i < full.size(); ++i) {
    if (random() % 5 == 0) continue;
    track.times.push_back(full.times[i]);
    track.poses.push_back(full.poses[i]);
    if (random() % 20 == 0) track.poses.back().translation.x() += 1;
  }
  const TrackerAccuracy accuracy = estimateAccuracy(track);
  EXPECT_NEAR(accuracy.sigma_t / 0.01, 1, 0.3);
  EXPECT_NEAR(accuracy.sigma_r / 0.05, 1, 0.15);
}

TEST(EstimateAccuracy, HasALeastValueAndALeastLength) {
  Trajectory still;
  for (int i = 0; i < 5; ++i) {
    still.times.push_back(i);
    still.poses.emplace_back();
  }
  EXPECT_GT(estimateAccuracy(still).sigma_t, 0);
  EXPECT_GT(estimateAccuracy(still).sigma_r, 0);
  still.times.pop_back();
  still.poses.pop_back();
  EXPECT_THROW(estimateAccuracy(still), Error);
}

TEST(TrackerAccuracies, KeepsWhatTheTaskGivesAndReportsTheRest) {
  SyntheticRecording recording;
  recording.sigma_t = 0.01;
  Task task;
  task.trackers["hand"] = {0.5, 0.25};
  Diagnostics diagnostics;
  const auto accuracies = trackerAccuracies(task, {recording.record()}, diagnostics);
  EXPECT_EQ(accuracies.at("hand").sigma_t, 0.5);
  EXPECT_NEAR(accuracies.at("object").sigma_t, 0.005, 0.001);
  EXPECT_EQ(accuracies.count("torso"), 0U) << "not recorded";
  EXPECT_NE(diagnostics.text().find("no <tracker> for 'object'"), std::string::npos);
}

}  // namespace
}  // namespace graft::lfd
