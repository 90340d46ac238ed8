// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/clean.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/support/test_data.hpp"
#include "tests/types_lfd/demo/synthetic.hpp"
#include "types_lfd/demo/statistics.hpp"

namespace graft::lfd {
namespace {

SyntheticRecording noisy(std::uint64_t seed) {
  SyntheticRecording recording;
  recording.sigma_t = 0.012;
  recording.sigma_r = 0.15;
  recording.seed = seed;
  return recording;
}

TEST(RemoveOutliers, LeavesCleanNoisyTracksAlone) {
  std::size_t samples = 0;
  std::size_t dropped = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Demonstration demonstration = noisy(seed).record();
    const CleanReport report = removeOutliers(demonstration);
    samples += report.hand.samples + report.object.samples;
    dropped += report.dropped();
    EXPECT_EQ(demonstration.dropped_stamps.size(), report.dropped());
  }
  EXPECT_LT(static_cast<double>(dropped), 0.005 * static_cast<double>(samples));
}

struct Plant {
  const char* what;
  std::vector<std::size_t> samples;
  Eigen::Vector3d shift;
  double turn;  // about x, rad
};

TEST(RemoveOutliers, DropsWhatWasPlanted) {
  const Plant plants[] = {{"the first sample", {0}, {0.6, 0, 0}, 0},
                          {"the last samples", {125, 126}, {0, 1, 0}, 0},
                          {"single spikes", {15, 40, 77}, {0, 0, 0.2}, 0},
                          {"far away", {30}, {100, 0, 0}, 0},
                          {"marker flips", {50, 51, 52}, {0, 0, 0}, 3},
                          {"a burst", {60, 61, 62, 63, 64}, {1.2, -0.5, 0}, 0},
                          {"a wrong begin", {0, 1, 2, 3, 4, 5}, {-2, 0, 0}, 1}};
  for (const Plant& plant : plants) {
    Trajectory track = noisy(5).record().hand;
    ASSERT_EQ(track.size(), 127U);
    std::set<double> bad;
    for (const std::size_t i : plant.samples) {
      bad.insert(track.times[i]);
      track.poses[i].translation += plant.shift;
      track.poses[i].rotation =
          track.poses[i].rotation * expSO3<double>(Eigen::Vector3d(plant.turn, 0, 0));
    }
    const CleanCounts counts = removeOutliers(track, CleanOptions().hand);
    EXPECT_EQ(counts.samples, 127U);
    EXPECT_EQ(counts.samples - counts.dropped(), track.size());
    EXPECT_LE(counts.dropped(), bad.size() + 1) << plant.what;
    for (const double time : track.times) EXPECT_EQ(bad.count(time), 0U) << plant.what;
  }
}

TEST(RemoveOutliers, DrawsNoLineAcrossAnOcclusion) {
  // A hand that rests, is hidden for most of a second, and is seen again on its way.
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0, 0.004);
    Trajectory track;
    for (int i = 0; i < 60; ++i) {
      const double time = 0.075 * i;
      if (time > 2 && time < 2.7) continue;
      const double moved = time < 2 ? 0 : 0.2 + 0.5 * (time - 2.7);
      Pose pose;
      pose.translation = {noise(random), moved + noise(random), noise(random)};
      track.times.push_back(time);
      track.poses.push_back(pose);
    }
    EXPECT_EQ(removeOutliers(track, CleanOptions().hand).dropped(), 0U) << seed;
  }
}

TEST(RemoveOutliers, RefusesATrackWithoutMajority) {
  Demonstration demonstration = noisy(1).record();
  // Three places in turn, too far apart to go from one to the other.
  for (std::size_t i = 0; i < demonstration.object.size(); ++i) {
    demonstration.object.poses[i].translation.x() = static_cast<double>(5 * (i / 8 % 3));
  }
  try {
    removeOutliers(demonstration);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_NE(std::string(error.what()).find("demonstration 'synthetic', object track: only "),
              std::string::npos)
        << error.what();
  }
}

TEST(RemoveOutliers, ReportsCountsInWords) {
  Demonstration demonstration = noisy(1).record();
  EXPECT_EQ(CleanReport().text(), "");
  demonstration.hand.poses[20].translation.z() += 2;
  const CleanReport report = removeOutliers(demonstration);
  EXPECT_EQ(report.text(),
            "hand: 1 of 127 poses dropped (1 too fast, 0 off the line of their neighbours)");
}

TEST(RemoveOutliers, KeepsNearlyEverythingOfTheSharedTasks) {
  for (const char* name :
       {"room_door", "swivel_door", "drawer", "sliding_door", "mocap_suitcase"}) {
    const std::string path = std::string("tasks/") + name + "/task.xml";
    GRAFT_REQUIRE_DATA(path);
    Diagnostics diagnostics;
    const Task task = readTask(testing::dataPath(path), diagnostics);
    std::size_t samples = 0;
    std::size_t dropped = 0;
    for (Demonstration& demonstration : readDemonstrations(task, diagnostics)) {
      const CleanReport report = removeOutliers(demonstration);
      samples += report.hand.samples + report.object.samples + report.torso.samples;
      dropped += report.dropped();
    }
    EXPECT_LT(static_cast<double>(dropped), 0.005 * static_cast<double>(samples)) << name;
  }
}

TEST(RepeatedMedianLine, IgnoresNearlyHalfOfThePoints) {
  const std::vector<double> times = {0, 1, 2, 3, 4, 5, 6};
  std::vector<double> values;
  for (const double time : times) values.push_back(2 + 3 * time);
  values[1] = 1e6;
  values[4] = -1e6;
  values[5] = 1e5;
  EXPECT_DOUBLE_EQ(repeatedMedianLine(times, values, 2.5), 9.5);
  EXPECT_EQ(medianOf({3, 1, 2}), 2);
  EXPECT_EQ(medianOf({4, 1, 2, 3}), 2.5);
}

}  // namespace
}  // namespace graft::lfd
