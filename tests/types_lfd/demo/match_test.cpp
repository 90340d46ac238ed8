// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/match.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "types_lfd/demo/segments_file.hpp"

namespace graft::lfd {
namespace {

/// Pose on a closed form: constant velocity and constant turn about z.
Pose screw(double time) {
  return Pose(Eigen::Vector3d(1 + 2 * time, -time, 0.5),
              Eigen::Quaterniond(std::cos(0.3 * time), 0, 0, std::sin(0.3 * time)));
}

Trajectory sampled(const std::vector<double>& times) {
  Trajectory track;
  track.times = times;
  for (const double time : times) track.poses.push_back(screw(time));
  return track;
}

Demonstration threeTracks() {
  Demonstration demonstration;
  demonstration.name = "d";
  demonstration.hand = sampled({0, 1, 2, 3, 4});
  demonstration.object = sampled({0.5, 1, 1.75, 4.5});
  demonstration.torso = sampled({-1, 0.75, 3.5, 6});
  return demonstration;
}

TEST(MatchTracks, TakesTheUnionOfStampsInTheCommonSpan) {
  const MatchedDemonstration matched = matchTracks(threeTracks());
  // Common span [0.5, 4]; stamp 1 is in two tracks and becomes one tuple.
  EXPECT_EQ(matched.times, (std::vector<double>{0.5, 0.75, 1, 1.75, 2, 3, 3.5, 4}));
  EXPECT_EQ(matched.hand.measured, (std::vector<char>{0, 0, 1, 0, 1, 1, 0, 1}));
  EXPECT_EQ(matched.object.measured, (std::vector<char>{1, 0, 1, 1, 0, 0, 0, 0}));
  EXPECT_EQ(matched.torso.measured, (std::vector<char>{0, 1, 0, 0, 0, 0, 1, 0}));
  EXPECT_EQ(matched.hand.measuredCount(), 4U);
  EXPECT_FALSE(matched.torso_estimated);
  EXPECT_EQ(matched.name, "d");
}

TEST(MatchTracks, InterpolatesOnTheStraightLineAndTheShorterArc) {
  Demonstration demonstration = threeTracks();
  // Opposite signs are the same rotations: nothing may change.
  for (std::size_t i = 0; i < demonstration.hand.size(); i += 2) {
    demonstration.hand.poses[i].rotation.coeffs() *= -1;
  }
  const MatchedDemonstration matched = matchTracks(demonstration);
  for (const MatchedTrack* track : {&matched.hand, &matched.object, &matched.torso}) {
    ASSERT_EQ(track->poses.size(), matched.size());
    for (std::size_t i = 0; i < matched.size(); ++i) {
      EXPECT_LT(poseError(screw(matched.times[i]).inverse() * track->poses[i]).norm(), 1e-14);
    }
  }
}

TEST(MatchTracks, CopiesMeasuredPosesBitByBit) {
  const Demonstration demonstration = threeTracks();
  const MatchedDemonstration matched = matchTracks(demonstration);
  double expected[7];
  double actual[7];
  demonstration.object.poses[2].toArray(expected);
  matched.object.poses[3].toArray(actual);
  EXPECT_EQ(std::memcmp(actual, expected, sizeof actual), 0);
}

TEST(MatchTracks, KeepsTheStampsOfDroppedPoses) {
  Demonstration demonstration = threeTracks();
  const std::vector<double> times = matchTracks(demonstration).times;
  demonstration.hand.times.erase(demonstration.hand.times.begin() + 2);
  demonstration.hand.poses.erase(demonstration.hand.poses.begin() + 2);
  demonstration.dropped_stamps.push_back(2);
  const MatchedDemonstration matched = matchTracks(demonstration);
  EXPECT_EQ(matched.times, times);
  EXPECT_EQ(matched.hand.measured[4], 0);
}

TEST(MatchTracks, IsDeterministicOnHalfTurns) {
  Demonstration demonstration = threeTracks();
  for (std::size_t i = 0; i < demonstration.hand.size(); ++i) {
    demonstration.hand.poses[i].rotation =
        i % 2 == 0 ? Eigen::Quaterniond(1, 0, 0, 0) : Eigen::Quaterniond(0, 0, 0, 1);
  }
  const MatchedDemonstration matched = matchTracks(demonstration);
  for (const Pose& pose : matched.hand.poses) {
    EXPECT_NEAR(pose.rotation.norm(), 1, 1e-14);
  }
}

TEST(MatchTracks, RefusesTracksWithoutTwoCommonStamps) {
  Demonstration demonstration = threeTracks();
  demonstration.object = sampled({4, 5});
  try {
    matchTracks(demonstration);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_STREQ(error.what(),
                 "demonstration 'd': the tracks have only one stamp in common: hand covers 0 to 4 "
                 "s, object covers 4 to 5 s, torso covers -1 to 6 s");
  }
  demonstration.object = sampled({4.5, 5});
  EXPECT_THROW(matchTracks(demonstration), Error);
}

TEST(MatchTracks, NeedsHandAndObjectButOnePoseMayDo) {
  for (const bool hand : {true, false}) {
    Demonstration demonstration = threeTracks();
    Trajectory& track = hand ? demonstration.hand : demonstration.object;
    const auto message = [&] {
      try {
        matchTracks(demonstration);
      } catch (const Error& error) {
        return std::string(error.what());
      }
      return std::string();
    };
    const std::string missing = "demonstration 'd': hand and object must be recorded";
    track = sampled({2});
    EXPECT_EQ(message().find(missing), std::string::npos) << message();
    track = {};
    EXPECT_EQ(message().rfind(missing, 0), 0u) << message();
  }
}

TEST(Summarize, FindsRateAndLongestGap) {
  const TrackSummary summary = summarize(sampled({1, 2, 3, 7, 8}));
  EXPECT_EQ(summary.poses, 5U);
  EXPECT_EQ(summary.duration, 7);
  EXPECT_EQ(summary.median_interval, 1);
  EXPECT_EQ(summary.longest_gap, 4);
  EXPECT_EQ(summary.gap_start, 3);
}

TEST(FormatSegments, WritesStampsAsRead) {
  MatchedDemonstration matched;
  matched.name = "demo_01";
  matched.times = {1479000000.670307, 1479000002.780023, 1479000007.726943};
  EXPECT_EQ(formatSegments({matched}, {Segmentation{1, 2}}),
            "demo,grasp_time,release_time\ndemo_01,1479000002.780023,1479000007.726943\n");
}

}  // namespace
}  // namespace graft::lfd
