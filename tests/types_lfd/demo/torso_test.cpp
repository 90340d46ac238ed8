// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/torso.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/geometry/se2.hpp"
#include "tests/support/test_data.hpp"
#include "tests/types_lfd/demo/synthetic.hpp"

namespace graft::lfd {
namespace {

double yawOf(const Pose& pose) {
  const Eigen::Vector3d x = pose.rotation * Eigen::Vector3d::UnitX();
  return std::atan2(x.y(), x.x());
}

TEST(EstimateTorso, StandsBehindTheHandAndFacesIt) {
  for (const double yaw : {0.0, 1.2, 3.1, -2.0}) {
    SyntheticRecording recording;
    recording.yaw = yaw;
    recording.sigma_t = 0.015;
    recording.sigma_r = 0.3;
    const MatchedDemonstration matched = matchTracks(recording.record());
    ASSERT_TRUE(matched.torso_estimated);
    ASSERT_EQ(matched.torso.poses.size(), matched.size());
    EXPECT_EQ(matched.torso.measuredCount(), 0U);
    // Reach and retreat of the recording come from -x of the object, a little
    // from the side: atan2(0.1, -0.5) is the furthest.
    for (const Pose& pose : matched.torso.poses) {
      EXPECT_NEAR(wrapAngle(yawOf(pose) - yaw), 0, 0.25);
      EXPECT_NEAR((pose.rotation * Eigen::Vector3d::UnitZ()).z(), 1, 1e-12) << "not upright";
      EXPECT_EQ(pose.translation.z(), TorsoOptions().height);
    }
    // While the hand rests on the handle, the distance is the nominal one.
    for (std::size_t i = 0; i < matched.size(); ++i) {
      if (matched.times[i] < recording.endTime() - 0.3) continue;
      const Eigen::Vector3d to_hand =
          recording.handAt(matched.times[i]).translation - matched.torso.poses[i].translation;
      EXPECT_NEAR(to_hand.head<2>().norm(), TorsoOptions().distance, 0.06);
    }
  }
}

TEST(EstimateTorso, NeitherSpinsNorJumps) {
  SyntheticRecording recording;
  recording.sigma_t = 0.03;
  recording.sigma_r = 0.4;
  const MatchedDemonstration matched = matchTracks(recording.record());
  for (std::size_t i = 1; i < matched.size(); ++i) {
    const Pose step = matched.torso.poses[i - 1].inverse() * matched.torso.poses[i];
    EXPECT_LT(rotationAngle(step.rotation), 1e-9);
    EXPECT_LT(step.translation.norm(), 1.0 * (matched.times[i] - matched.times[i - 1]) + 0.01);
  }
}

TEST(EstimateTorso, UsesTheFingersWhereTheHandNeverApproaches) {
  SyntheticRecording recording;
  Demonstration demonstration = recording.record();
  for (std::size_t i = 0; i < demonstration.hand.size(); ++i) {
    const Pose object = recording.objectAt(demonstration.hand.times[i]);
    demonstration.hand.poses[i] =
        object * Pose(Eigen::Vector3d(0.01, 0, 0), expSO3<double>(Eigen::Vector3d(0, 0, 0.7)));
  }
  const MatchedDemonstration matched = matchTracks(demonstration);
  for (const Pose& pose : matched.torso.poses) EXPECT_NEAR(yawOf(pose), 0.7, 1e-6);
}

TEST(EstimateTorso, IsNearTheTrueTorsoOfTheSharedTasks) {
  for (const char* name :
       {"room_door", "swivel_door", "drawer", "sliding_door", "mocap_suitcase"}) {
    const std::string folder = std::string("tasks/") + name;
    GRAFT_REQUIRE_DATA(folder + "/task.xml");
    Diagnostics diagnostics;
    Task task = readTask(testing::dataPath(folder + "/task.xml"), diagnostics);
    std::vector<double> distances;
    std::vector<double> turns;
    for (DemonstrationSpec& spec : task.demonstrations) {
      const std::string truth = folder + "/truth/" + spec.name + "_torso.tum";
      const Trajectory torso =
          readTum(testing::dataExists(truth) ? testing::dataPath(truth) : spec.torso, diagnostics);
      spec.torso.clear();
      const MatchedDemonstration matched = matchTracks(readDemonstration(spec, diagnostics));
      for (std::size_t i = 0; i < matched.size(); ++i) {
        const double time = matched.times[i];
        if (time < torso.times.front() || time > torso.times.back()) continue;
        const Pose expected = resample(torso, {time}).poses[0];
        const Pose& pose = matched.torso.poses[i];
        distances.push_back((pose.translation - expected.translation).head<2>().norm());
        turns.push_back(std::abs(wrapAngle(yawOf(pose) - yawOf(expected))));
      }
    }
    std::sort(distances.begin(), distances.end());
    std::sort(turns.begin(), turns.end());
    ASSERT_FALSE(distances.empty());
    const std::size_t half = distances.size() / 2;
    const std::size_t nine_of_ten = distances.size() * 9 / 10;
    std::printf("%-16s torso off by median %.2f m, 90 %% %.2f m; yaw median %.2f, 90 %% %.2f rad\n",
                name, distances[half], distances[nine_of_ten], turns[half], turns[nine_of_ten]);
    // Who carries a suitcase turns with it, away from one fixed direction.
    const double limit = std::string(name) == "mocap_suitcase" ? 0.8 : 0.5;
    EXPECT_LT(distances[half], limit) << name;
  }
}

}  // namespace
}  // namespace graft::lfd
