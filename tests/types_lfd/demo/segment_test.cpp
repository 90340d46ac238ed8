// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/segment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <string>
#include <utility>

#include "tests/support/test_data.hpp"
#include "tests/types_lfd/demo/synthetic.hpp"
#include "types_lfd/build/prepare.hpp"
#include "types_lfd/demo/arrival.hpp"
#include "types_lfd/demo/relative_motion.hpp"
#include "types_lfd/teach/teacher.hpp"

namespace graft::lfd {
namespace {

struct Times {
  double grasp;
  double release;
};

Times segmentTimes(const Demonstration& demonstration) {
  const MatchedDemonstration matched = matchTracks(demonstration);
  const Segmentation segments = segmentDemonstration(matched);
  return {matched.times[segments.grasp], matched.times[segments.release]};
}

TEST(Segment, FindsContactOfCleanRecordings) {
  SyntheticRecording recording;
  recording.hand_rate = recording.object_rate = 30;
  const Times found = segmentTimes(recording.record());
  // Two standard deviations of a soft hand (1 cm) are covered in the last
  // 0.25 s of such a reach; a later contact would be wrong.
  EXPECT_LE(found.grasp, recording.graspTime() + 1.0 / 30);
  EXPECT_GE(found.grasp, recording.graspTime() - 0.25);
  EXPECT_GE(found.release, recording.releaseTime() - 1.0 / 30);
  EXPECT_LE(found.release, recording.releaseTime() + 0.25);
}

TEST(Segment, HoldsForAnyNoiseRateAndDirection) {
  std::vector<double> errors;
  for (const double sigma : {0.001, 0.005, 0.015}) {
    for (const double rate : {10.0, 15.0, 30.0, 60.0}) {
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        SyntheticRecording recording;
        recording.sigma_t = sigma;
        recording.sigma_r = 10 * sigma;
        recording.hand_rate = rate;
        recording.object_rate = 0.8 * rate;
        recording.seed = seed;
        recording.yaw = static_cast<double>(seed);
        const Times found = segmentTimes(recording.record());
        errors.push_back(std::abs(found.grasp - recording.graspTime()));
        errors.push_back(std::abs(found.release - recording.releaseTime()));
      }
    }
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.25);
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.6);
}

TEST(Segment, DoesNotTakeAStraightLineAcrossAnOcclusionForMotion) {
  SyntheticRecording recording;
  recording.sigma_t = 0.005;
  Demonstration demonstration = recording.record();
  const double from = recording.graspTime() - 0.8;
  const double to = recording.graspTime() + 0.2;
  Trajectory seen;
  for (std::size_t i = 0; i < demonstration.hand.size(); ++i) {
    const double time = demonstration.hand.times[i];
    if (time > from && time < to) continue;
    seen.times.push_back(time);
    seen.poses.push_back(demonstration.hand.poses[i]);
  }
  demonstration.hand = seen;
  const Times found = segmentTimes(demonstration);
  EXPECT_NEAR(found.grasp, recording.graspTime(), 0.6);
}

TEST(Segment, InfersAHiddenReleaseFromTheHandsWayBehindIt) {
  // Hidden from before the release until most of the retreat is done.
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SyntheticRecording recording;
    recording.sigma_t = 0.003;
    recording.seed = seed;
    Demonstration demonstration = recording.record();
    const double from = recording.releaseTime() - 0.4;
    const double to = recording.releaseTime() + 0.7;
    Trajectory seen;
    for (std::size_t i = 0; i < demonstration.hand.size(); ++i) {
      const double time = demonstration.hand.times[i];
      if (time > from && time < to) continue;
      seen.times.push_back(time);
      seen.poses.push_back(demonstration.hand.poses[i]);
    }
    demonstration.hand = seen;
    const Times found = segmentTimes(demonstration);
    EXPECT_GT(found.release, recording.releaseTime() - 0.2) << seed;
    EXPECT_LT(found.release, recording.releaseTime() + 0.6) << seed;
  }
}

TEST(Segment, GivenTimesOverrideAndSnapToTheNearestTuple) {
  const MatchedDemonstration matched = matchTracks(SyntheticRecording().record());
  const double wanted = 0.6 * matched.times[10] + 0.4 * matched.times[11];
  const Segmentation automatic = segmentDemonstration(matched);
  const Segmentation given = segmentDemonstration(matched, {}, wanted);
  EXPECT_EQ(given.grasp, 10U);
  EXPECT_EQ(given.release, automatic.release);
  const Segmentation both = segmentDemonstration(matched, {}, wanted, matched.times.back());
  EXPECT_EQ(both.release, matched.size() - 1);
}

TEST(Segment, GivenTimesAlsoHoldForAnObjectThatStandsStill) {
  SyntheticRecording recording;
  recording.way = 0;
  const MatchedDemonstration matched = matchTracks(recording.record());
  const Segmentation given = segmentDemonstration(matched, {}, matched.times[3], matched.times[40]);
  EXPECT_EQ(given.grasp, 3U);
  EXPECT_EQ(given.release, 40U);
}

TEST(Segment, TellsHowMuchOfTheMotionIsManipulation) {
  const SyntheticRecording recording;
  const MatchedDemonstration matched = matchTracks(recording.record());
  EXPECT_EQ(segmentDemonstration(matched).motion_share, 1);
  const double middle = 0.5 * (recording.graspTime() + recording.releaseTime());
  EXPECT_NEAR(segmentDemonstration(matched, {}, middle).motion_share, 0.5, 0.03);
}

TEST(Segment, IsNotMisledByAnObjectThatMovedBefore) {
  SyntheticRecording recording;
  recording.lead = 3;
  recording.sigma_t = 0.004;
  Demonstration demonstration = recording.record();
  for (std::size_t i = 0; i < demonstration.object.size(); ++i) {
    // Pushed by something else in the first second, and back in the second.
    const double t = std::clamp(demonstration.object.times[i] - recording.start - 0.4, 0.0, 2.0);
    demonstration.object.poses[i].translation.z() += 0.1 * std::sin(1.5708 * t);
  }
  const Times found = segmentTimes(demonstration);
  EXPECT_NEAR(found.grasp, recording.graspTime(), 0.4);
  EXPECT_NEAR(found.release, recording.releaseTime(), 0.4);
}

std::string errorOf(const MatchedDemonstration& matched, std::optional<double> grasp = {},
                    std::optional<double> release = {}) {
  try {
    segmentDemonstration(matched, {}, grasp, release);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    return error.what();
  }
  return "no error";
}

TEST(Segment, NamesTheDemonstrationThatCannotBeSegmented) {
  const auto starts = [](const std::string& text, const std::string& with) {
    EXPECT_EQ(text.substr(0, with.size()), with) << text;
  };
  SyntheticRecording recording;
  recording.sigma_t = 0.003;
  const MatchedDemonstration good = matchTracks(recording.record());
  starts(errorOf(good, 5.0), "demonstration 'synthetic': grasp_time 5 is outside of the matched");
  starts(errorOf(good, {}, 9999.0), "demonstration 'synthetic': release_time 9999 is outside");
  starts(errorOf(good, recording.releaseTime() + 0.3),
         "demonstration 'synthetic': no manipulation between grasp at ");

  recording.way = 0;
  starts(errorOf(matchTracks(recording.record())),
         "demonstration 'synthetic': the object never moves");

  recording.way = 0.3;
  Demonstration held = recording.record();
  for (std::size_t i = 0; i < held.hand.size(); ++i) {
    held.hand.poses[i] = recording.objectAt(held.hand.times[i]);
  }
  starts(errorOf(matchTracks(held)),
         "demonstration 'synthetic': the hand holds the object from the first tuple on");
}

TEST(Segment, AcceptsARecordingThatEndsWhileHolding) {
  SyntheticRecording recording;
  Demonstration demonstration = recording.record();
  for (Trajectory* track : {&demonstration.hand, &demonstration.object}) {
    while (track->times.back() > recording.releaseTime() - 0.3) {
      track->times.pop_back();
      track->poses.pop_back();
    }
  }
  const MatchedDemonstration matched = matchTracks(demonstration);
  EXPECT_EQ(segmentDemonstration(matched).release, matched.size() - 1);
}

TEST(Arrival, FitsItsOwnModelExactly) {
  EXPECT_EQ(minimumJerkToGo(-1), 0);
  EXPECT_EQ(minimumJerkToGo(0.5), 0.5);
  EXPECT_EQ(minimumJerkToGo(2), 1);
  ArrivalSamples samples;
  for (int i = 0; i < 80; ++i) {
    const double t = 0.03 * i;
    samples.times.push_back(t);
    samples.points.push_back(Eigen::Vector3d(1, 2, 3) +
                             minimumJerkToGo((0.9 - t) / 1.95) * Eigen::Vector3d(0.5, -0.2, 0.1));
  }
  samples.edge = 0.7;
  samples.latest = 1.5;
  SegmentOptions options;
  options.softness = 0;
  EXPECT_NEAR(fitArrival(samples, options), 0.9, 0.05);
  samples.latest = 0.4;  // the object moves already
  EXPECT_LE(fitArrival(samples, options), 0.4);
}

/// People who walk up to a handle, partly hidden: by its fit alone the hand held it 1 s
/// before it was there.
TEST(Segment, HandsThatAreFarAwayHoldNothing) {
  for (const auto& [task, seed] :
       {std::pair("swivel_door", 26), {"drawer", 24}, {"sliding_door", 32}}) {
    const std::string folder = testing::makeTemporaryDirectory() + "/task";
    teach(task, folder, std::uint64_t(seed));
    Diagnostics diagnostics;
    const PreparedTask prepared = prepareTask(folder + "/task.xml", diagnostics);
    std::istringstream truth(testing::readTestFile(folder + "/truth/segments.csv"));
    std::string line;
    std::getline(truth, line);  // the header
    for (const PreparedDemonstration& demo : prepared.demonstrations) {
      double grasp = 0;
      double release = 0;
      std::string name;
      char comma = 0;
      ASSERT_TRUE(std::getline(truth, name, ',') && truth >> grasp >> comma >> release);
      std::getline(truth, line);
      ASSERT_EQ(name, demo.matched.name);
      EXPECT_NEAR(demo.matched.times[demo.segments.grasp], grasp, 0.6) << task << ' ' << name;
      EXPECT_NEAR(demo.matched.times[demo.segments.release], release, 0.6) << task << ' ' << name;
    }
  }
}

TEST(SeenTuples, LeaveOutOcclusions) {
  MatchedDemonstration matched;
  for (int i = 0; i < 12; ++i) {
    matched.times.push_back(i);
    matched.hand.measured.push_back(static_cast<char>(i < 4 || i > 7));
    matched.object.measured.push_back(static_cast<char>(i % 2 == 0 || i == 11));
  }
  EXPECT_EQ(seenTuples(matched), (std::vector<char>{1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1}));
}

}  // namespace
}  // namespace graft::lfd
