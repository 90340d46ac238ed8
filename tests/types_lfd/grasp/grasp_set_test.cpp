// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/grasp/grasp_set.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/test_data.hpp"

namespace graft::lfd {
namespace {

using graft::testing::makeTemporaryDirectory;
using graft::testing::writeTestFile;

const std::string kHeader = "x,y,z,qx,qy,qz,qw,quality\n";
const double kPi = std::acos(-1.0);

GraspSet readText(const std::string& content, double min_quality, Diagnostics& diagnostics) {
  return GraspSet::read(writeTestFile(makeTemporaryDirectory(), "grasps.csv", content), min_quality,
                        diagnostics);
}

Pose randomPose(std::mt19937_64& random, double size, double angle) {
  std::uniform_real_distribution<double> u(-1, 1);
  Vec<double, 6> d;
  for (int i = 0; i < 6; ++i) d[i] = (i < 3 ? size : angle) * u(random);
  return Pose().plus(d);
}

TEST(GraspSet, ReadsRowsAndKeepsTheirNumbers) {
  Diagnostics diagnostics;
  const GraspSet set = readText("\xef\xbb\xbf" + kHeader +
                                    "1,2,3,0,0,0,1,0.4\r\n"
                                    " 4, 5 ,6,0,0,0.6,0.8,0.5\r\n"
                                    "7,8,9,0,1.1,0,0,1\n\n",
                                0.5, diagnostics);
  EXPECT_EQ(diagnostics.errorCount(), 0u) << diagnostics.text();
  ASSERT_EQ(set.valid().size(), 2u);  // min_quality is inclusive
  EXPECT_EQ(set.valid()[0].row, 1);
  EXPECT_EQ(set.valid()[1].row, 2);
  EXPECT_EQ(set.valid()[0].quality, 0.5);
  EXPECT_EQ(set.valid()[0].object_T_gripper.translation, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(set.valid()[0].object_T_gripper.rotation.z(), 0.6);
  EXPECT_EQ(set.valid()[1].object_T_gripper.rotation.y(), 1);
  EXPECT_EQ(diagnostics.warningCount(), 1u);
  EXPECT_NE(diagnostics.text().find("grasps.csv:4: warning: the quaternion has length 1.1"),
            std::string::npos);
}

struct BadFile {
  std::string content;
  double min_quality;
  const char* message;
};

TEST(GraspSet, RefusesBadInputByLine) {
  const std::string good = "1,2,3,0,0,0,1,0.4\n";
  const BadFile cases[] = {
      {"", 0, "grasps.csv:1: error: expected the header x,y,z,qx,qy,qz,qw,quality, got ''"},
      {good, 0, "grasps.csv:1: error: expected the header x,y,z,qx,qy,qz,qw,quality, got '1,2,3"},
      {"x,y,z,qw,qx,qy,qz,quality\n" + good, 0, "grasps.csv:1: error: expected the header"},
      {"x;y;z;qx;qy;qz;qw;quality\n" + good, 0, "grasps.csv:1: error: expected the header"},
      {kHeader, 0, "grasps.csv: error: there is no grasp below the header"},
      {kHeader + good + "1,2,3,0,0,0,1\n", 0, "grasps.csv:3: error: expected 8 fields (x,y,z,qx,"},
      {kHeader + good + "1,2,3,0,0,0,1,1,1\n", 0, "grasps.csv:3: error: more than 8 fields"},
      {kHeader + "1;2;3;0;0;0;1;1\n", 0,
       "grasps.csv:2:1: error: '1;2;3;0;0;0;1;1' is not a number"},
      {kHeader + "\"1\",2,3,0,0,0,1,1\n", 0, "grasps.csv:2:1: error: '\"1\"' is not a number"},
      {kHeader + "1,2,,0,0,0,1,1\n", 0, "grasps.csv:2:5: error: field 3 is empty"},
      {kHeader + "1,2,inf,0,0,0,1,1\n", 0, "grasps.csv:2:5: error: 'inf' is not a finite number"},
      {kHeader + "1,2,3,0,0,0,1,nan\n", 0, "grasps.csv:2:15: error: 'nan' is not a finite number"},
      {kHeader + "1,2,3,0,0,0,1,1.5\n", 0,
       "grasps.csv:2: error: the quality is 1.5, expected 0 to"},
      {kHeader + "1,2,3,0,0,0,1,-0.1\n", 0, "grasps.csv:2: error: the quality is -0.1"},
      {kHeader + "1,2,3,0,0,0,0,1\n", 0, "grasps.csv:2: error: the quaternion has length 0"},
      {kHeader + "1,2,3,4,0,0,1,1\n", 0, "grasps.csv:2: error: the quaternion has length 4.1231"},
      {kHeader + good + "\n" + good, 0, "grasps.csv:3: error: the line is empty"},
      {kHeader + good + "1,2,3,0,0,0,1,0.61\n", 0.8,
       "grasps.csv: error: no grasp with quality >= 0.8 (best 0.61)"},
      {kHeader + good, std::nan(""), "grasps.csv: error: no grasp with quality >= nan (best 0.4)"}};
  for (const BadFile& c : cases) {
    Diagnostics diagnostics;
    readText(c.content, c.min_quality, diagnostics);
    EXPECT_EQ(diagnostics.errorCount(), 1u) << c.message;
    EXPECT_NE(diagnostics.text().find(std::string("/") + c.message), std::string::npos)
        << "expected " << c.message << "\ngot " << diagnostics.text();
  }
}

TEST(GraspSet, FlipIsHalfATurnAboutTheApproachAxis) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 100; ++i) {
    const Pose g = randomPose(random, 1, 2);
    const Pose turn({0, 0, 0},
                    Eigen::Quaterniond(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX())));
    EXPECT_LT(poseError((g * turn).inverse() * flippedGrasp(g)).norm(), 1e-12);
  }
}

TEST(GraspSet, NearestEqualsBruteForce) {
  std::mt19937_64 random(2);
  std::vector<Grasp> grasps;
  for (int i = 0; i < 40; ++i) grasps.push_back({randomPose(random, 0.1, 2), 1, 2 * i + 1});
  const GraspSet set(grasps);
  int flips = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Pose query = randomPose(random, 0.1, 2);
    const double sigma_t = 0.02;
    const double sigma_r = 0.3;
    // All 80 candidates in the order of the tie rule, by rotation matrices.
    GraspSet::Choice best;
    std::vector<double> costs;
    for (int i = 0; i < 80; ++i) {
      Eigen::Matrix3d r = grasps[i / 2].object_T_gripper.rotation.toRotationMatrix();
      if (i % 2 == 1) r = r * Eigen::Vector3d(1, -1, -1).asDiagonal();
      const Eigen::Matrix3d d = query.rotation.toRotationMatrix().transpose() * r;
      const double angle = Eigen::AngleAxisd(d).angle();
      const double t = (grasps[i / 2].object_T_gripper.translation - query.translation).norm();
      costs.push_back(t * t / (sigma_t * sigma_t) + angle * angle / (sigma_r * sigma_r));
      if (best.index < 0 || costs.back() < best.cost) best = {i / 2, i % 2 == 1, costs.back()};
    }
    double second = 1e300;
    for (int i = 0; i < 80; ++i) {
      if (i / 2 != best.index) second = std::min(second, costs[i]);
    }
    GraspSet::Choice runner_up;
    const GraspSet::Choice found = set.nearest(query, sigma_t, sigma_r, &runner_up);
    ASSERT_EQ(found.index, best.index);
    ASSERT_EQ(found.flipped, best.flipped);
    ASSERT_NEAR(found.cost, best.cost, 1e-8 * best.cost);
    ASSERT_NEAR(runner_up.cost, second, 1e-8 * second);
    ASSERT_NE(runner_up.index, found.index);
    flips += found.flipped;
    EXPECT_LT(set.nearest(set.pose(found), sigma_t, sigma_r).cost, 1e-9);
  }
  EXPECT_GT(flips, 100);
}

TEST(GraspSet, TiesGoToTheLowerRowUnflipped) {
  const Pose g({1, 2, 3}, Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5));
  const GraspSet set({{g, 1, 3}, {g, 1, 5}});
  GraspSet::Choice runner_up;
  // Quarter turn about x: as far from the grasp as from its flip.
  const Pose quarter({1, 2, 3}, Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5) *
                                    Eigen::Quaterniond(std::sqrt(0.5), std::sqrt(0.5), 0, 0));
  const GraspSet::Choice equal = set.nearest(g, 0.01, 0.1, &runner_up);
  EXPECT_EQ(equal.index, 0);
  EXPECT_FALSE(equal.flipped);
  EXPECT_EQ(runner_up.index, 1);
  EXPECT_NEAR(set.nearest(quarter, 0.01, 0.1).cost, std::pow(kPi / 2 / 0.1, 2), 1e-6);
  const GraspSet one({{g, 1, 0}});
  one.nearest(g, 0.01, 0.1, &runner_up);
  EXPECT_EQ(runner_up.index, -1);
  EXPECT_EQ(GraspSet().nearest(g, 0.01, 0.1).index, -1);
}

TEST(GraspSet, KeepsCandidatesThatAreHardlyFartherThanTheNearest) {
  std::mt19937_64 random(5);
  std::vector<Grasp> grasps;
  for (int i = 0; i < 60; ++i) grasps.push_back({randomPose(random, 0.02, 0.3), 0.9, 2 * i});
  const auto offset = [](const Pose& a, const Pose& b) {
    const Eigen::AngleAxisd turn(a.rotation.conjugate() * b.rotation);
    return std::make_pair((a.translation - b.translation).norm(), turn.angle());
  };
  std::size_t kept = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const bool turned = trial % 2 != 0;
    const Pose hand = randomPose(random, 0.02, 0.3);
    const Pose shown = turned ? flippedGrasp(hand) : hand;
    GraspSet set(grasps);
    ASSERT_EQ(set.candidates().size(), 120u);
    std::pair<double, double> near(0, 0);
    double least = 1e300;
    for (const GraspSet::Candidate& c : set.candidates()) {
      const auto o = offset(shown, c.object_T_gripper);
      const double cost = std::pow(o.first / 0.01, 2) + std::pow(o.second / 0.06, 2);
      if (cost < least) near = o;
      least = std::min(least, cost);
    }
    std::vector<std::pair<int, bool>> expected;
    for (const GraspSet::Candidate& c : set.candidates()) {
      const auto o = offset(shown, c.object_T_gripper);
      if (o.first > near.first + 0.005 || o.second > near.second + 2 * kPi / 180) continue;
      expected.emplace_back(c.row, c.flipped);
    }
    set.keepLike(shown, 0.01, 0.06);
    std::vector<std::pair<int, bool>> found;
    for (const GraspSet::Candidate& c : set.candidates()) {
      found.emplace_back(c.row, c.flipped);
      EXPECT_EQ(c.flipped, turned);
    }
    EXPECT_EQ(found, expected) << trial;
    EXPECT_EQ(set.valid().size(), 60u) << "they remain valid";
    kept += found.size();
  }
  EXPECT_GT(kept, 60u) << "the nearest alone hardly tests anything";
  EXPECT_LT(kept, 1000u);
}

TEST(GraspSet, ReadsTheSharedTasks) {
  for (const char* task :
       {"room_door", "swivel_door", "drawer", "sliding_door", "mocap_suitcase"}) {
    GRAFT_REQUIRE_DATA(std::string("tasks/") + task);
    Diagnostics diagnostics;
    const GraspSet set = GraspSet::read(
        graft::testing::dataPath(std::string("tasks/") + task + "/grasps.csv"), 0.5, diagnostics);
    EXPECT_EQ(diagnostics.text(), "") << task;
    EXPECT_GT(set.valid().size(), 3u) << task;
  }
}

}  // namespace
}  // namespace graft::lfd
