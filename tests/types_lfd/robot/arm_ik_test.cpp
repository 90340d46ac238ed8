// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/robot/arm_ik.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/test_data.hpp"
#include "tests/types_lfd/robot/small_robot.hpp"

namespace graft::lfd {
namespace {

using testing::smallRobotChain;

void expectReached(const Chain& chain, const Pose& pose, const Eigen::VectorXd& q) {
  const Pose reached = chain.forward(q);
  EXPECT_LT((reached.translation - pose.translation).norm(), 1e-3);
  EXPECT_LT(rotationAngle(pose.rotation.conjugate() * reached.rotation), 0.1 * M_PI / 180);
  for (int i = 0; i < chain.dof(); ++i) {
    if (chain.continuous(i)) continue;
    EXPECT_GE(q[i], chain.lower()[i]);
    EXPECT_LE(q[i], chain.upper()[i]);
  }
}

/// Share of random reachable poses that are solved; each solution is checked.
double solvedShare(const Chain& chain, int count) {
  std::mt19937_64 random(4);
  const Eigen::VectorXd start = 0.5 * (chain.lower() + chain.upper());
  int solved = 0;
  for (int n = 0; n < count; ++n) {
    const Pose pose = chain.forward(sampleJoints(chain, random));
    const auto q = solveIk(chain, pose, start);
    if (!q) continue;
    ++solved;
    expectReached(chain, pose, *q);
  }
  return static_cast<double>(solved) / count;
}

TEST(SolveIk, FindsWhatForwardKinematicsMade) {
  EXPECT_GE(solvedShare(smallRobotChain(), 500), 0.98);
}

TEST(SolveIk, SolvesTheSharedRobots) {
  const struct {
    const char* file;
    const char* tip;
  } robots[] = {{"robots/pr2/pr2_moveit_resources.urdf", "r_gripper_tool_frame"},
                {"robots/pr2/pr2_moveit_resources.urdf", "l_gripper_tool_frame"},
                {"robots/tiago/tiago_no_hand.urdf", "arm_tool_link"}};
  for (const auto& robot : robots) {
    GRAFT_REQUIRE_DATA(robot.file);
    Diagnostics diagnostics;
    const UrdfModel model = readUrdf(graft::testing::dataPath(robot.file), diagnostics);
    const Chain chain(model, "base_footprint", robot.tip);
    EXPECT_EQ(chain.dof(), 8);
    EXPECT_EQ(chain.heightJoint(), 0);
    EXPECT_GE(solvedShare(chain, 500), 0.98) << robot.tip;
  }
}

TEST(SolveIk, GivesUpOnWhatIsOutOfReach) {
  const Chain chain = smallRobotChain();
  const Eigen::VectorXd start = 0.5 * (chain.lower() + chain.upper());
  const Pose far(Eigen::Vector3d(3, 0, 1), Eigen::Quaterniond::Identity());
  EXPECT_FALSE(solveIk(chain, far, start));
  EXPECT_THROW(solveIk(chain, far, Eigen::VectorXd::Zero(3)), Error);
}

TEST(SolveIk, StaysNearTheStartAndRepeats) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(5);
  for (int n = 0; n < 50; ++n) {
    Eigen::VectorXd q = 0.9 * sampleJoints(chain, random);
    q[0] = 0.15;
    q[4] += 2 * M_PI;  // a continuous joint, a turn away
    Eigen::VectorXd start = q.array() + 0.01;
    const auto first = solveIk(chain, chain.forward(q), start);
    ASSERT_TRUE(first);
    EXPECT_LT((*first - start).norm(), 1.0);
    EXPECT_EQ(*first, *solveIk(chain, chain.forward(q), start));
  }
}

/// A slow sweep of the gripper in front of the robot.
std::vector<Pose> sweep(std::size_t count) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(count - 1);
    poses.emplace_back(Eigen::Vector3d(0.6, -0.35 + 0.4 * s, 0.7 + 0.1 * std::sin(6 * s)),
                       expSO3<double>(Eigen::Vector3d(0, 0.3 * s, 0.5 * s)));
  }
  return poses;
}

TEST(SolveIkAlong, IsSmoothAndWithinTheSpeedLimits) {
  const Chain chain = smallRobotChain();
  const std::vector<Pose> poses = sweep(200);
  std::vector<double> times;
  for (std::size_t i = 0; i < poses.size(); ++i)
    times.push_back(100 + 0.05 * static_cast<double>(i));
  const IkTrack track = solveIkAlong(chain, poses, times);
  ASSERT_EQ(track.joints.size(), poses.size());
  EXPECT_EQ(track.solved, poses.size());
  EXPECT_EQ(track.too_fast, 0U);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    expectReached(chain, poses[i], track.joints[i]);
    if (i == 0) continue;
    EXPECT_LT((track.joints[i] - track.joints[i - 1]).cwiseAbs().maxCoeff(), 0.15) << i;
  }
}

TEST(SolveIkAlong, LeavesGapsEmptyAndGoesOnAfterThem) {
  const Chain chain = smallRobotChain();
  std::vector<Pose> poses = sweep(60);
  std::vector<double> times;
  for (std::size_t i = 0; i < poses.size(); ++i) times.push_back(0.05 * static_cast<double>(i));
  for (std::size_t i = 20; i < 30; ++i) poses[i].translation[2] = 2.5;
  const IkTrack track = solveIkAlong(chain, poses, times);
  EXPECT_EQ(track.solved, 50U);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(track.joints[i].size() == 0, i >= 20 && i < 30) << i;
  }
}

TEST(SolveIkAlong, CountsStepsThatAreTooFast) {
  const Chain chain = smallRobotChain();
  std::vector<Pose> poses = sweep(2);
  const IkTrack track = solveIkAlong(chain, poses, {0, 0.01});
  EXPECT_EQ(track.solved, 2U);
  EXPECT_EQ(track.too_fast, 1U);
}

TEST(SolveIkAlong, RefusesTimesThatDoNotRise) {
  const Chain chain = smallRobotChain();
  EXPECT_THROW(solveIkAlong(chain, sweep(2), {0, 0}), Error);
  EXPECT_THROW(solveIkAlong(chain, sweep(2), {0}), Error);
  EXPECT_TRUE(solveIkAlong(chain, {}, {}).joints.empty());
}

}  // namespace
}  // namespace graft::lfd
