// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "types_lfd/map/footprint.hpp"
#include "types_lfd/robot/arm_ik.hpp"
#include "types_lfd/robot/chain.hpp"
#include "types_lfd/robot/urdf.hpp"
#include "types_lfd/teach/grasp_samples.hpp"
#include "types_lfd/teach/scenario.hpp"
#include "types_lfd/teach/teacher_robot.hpp"

namespace graft::lfd {
namespace {

Chain teacherChain() {
  Diagnostics diagnostics;
  const UrdfModel model = readUrdfText("robot.urdf", formatRobotUrdf(), diagnostics);
  EXPECT_EQ(diagnostics.text(), "");
  return Chain(model, kRobotBaseLink, kRobotTipLink);
}

TEST(TeacherRobot, IsALiftAndAnArmOfSevenJoints) {
  const Chain chain = teacherChain();
  ASSERT_EQ(chain.dof(), 8);
  EXPECT_EQ(chain.heightJoint(), 0);
  EXPECT_TRUE(chain.lastJointRolls());
  // Stretched out ahead: shoulder offset 0.1, then 0.4 + 0.32 + 0.18 m.
  const Pose ahead = chain.forward(Eigen::VectorXd::Zero(8));
  EXPECT_LT((ahead.translation - Eigen::Vector3d(-0.05 + 0.1 + 0.9, -0.19, 0.79)).norm(), 1e-12);
}

/// True if from some place in front of it, clear of the map, the robot can hold
/// the handle as it is at this opening.
bool reachable(const Chain& chain, const Scenario& s, const FootprintChecker& footprint,
               const Pose& object_T_gripper, double opening) {
  const Pose scene_T_gripper = s.furniture.handle(opening, 0) * object_T_gripper;
  const double yaw = logSO3(s.world_T_scene.rotation).z();
  Eigen::VectorXd start(8);
  start << 0.16, -0.5, 0.3, -1.2, -1.2, 0.5, -1.0, 0.5;
  IkOptions options;
  options.restarts = 3;
  for (double back = 0.40; back < 0.85; back += 0.1) {
    for (double left = -0.3; left < 0.5; left += 0.1) {
      for (const double turn : {0.0, -0.6, 0.6, -1.2}) {
        const Pose2 scene_T_base(scene_T_gripper.translation.x() - back,
                                 scene_T_gripper.translation.y() + left, turn);
        const Eigen::Vector3d at =
            s.world_T_scene * Eigen::Vector3d(scene_T_base.x, scene_T_base.y, 0);
        if (footprint.inCollision(Pose2(at.x(), at.y(), yaw + turn))) continue;
        const Pose scene_T_base3(Eigen::Vector3d(scene_T_base.x, scene_T_base.y, 0),
                                 expSO3<double>(Eigen::Vector3d(0, 0, turn)));
        if (solveIk(chain, scene_T_base3.inverse() * scene_T_gripper, start, options)) return true;
      }
    }
  }
  return false;
}

TEST(TeacherRobot, ReachesAllFurniture) {
  const Chain chain = teacherChain();
  const double w = kRobotHalfWidth;
  for (const std::string& task : teachableTasks()) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      const Scenario s = drawScenario(task, seed, {});
      const OccupancyMap map = drawMap(s);
      const FootprintChecker footprint(map, {{w, w}, {-w, w}, {-w, -w}, {w, -w}});
      Grasp best;
      for (const Grasp& grasp : sampleGrasps(s, seed)) {
        if (grasp.quality > best.quality) best = grasp;
      }
      for (const double opening : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        EXPECT_TRUE(reachable(chain, s, footprint, best.object_T_gripper, opening))
            << task << ", seed " << seed << ", opening " << opening;
      }
    }
  }
}

TEST(GraspSamples, LieAtTheHandle) {
  for (const std::string& task : teachableTasks()) {
    const Scenario s = drawScenario(task, 4, {});
    int good = 0;
    for (const Grasp& grasp : sampleGrasps(s, 4)) {
      EXPECT_LT(grasp.object_T_gripper.translation.norm(), 0.05);
      const Eigen::Matrix3d r = grasp.object_T_gripper.rotation.toRotationMatrix();
      EXPECT_GT(r(0, 0), 0.8);                         // approach along x of the handle
      EXPECT_LT(std::abs(r.col(1).dot(s.bar)), 0.35);  // closing axis across the bar
      good += grasp.quality >= kTaughtMinQuality;
    }
    EXPECT_GE(good, 10);
    EXPECT_LT(good, kGraspSamples);
  }
}

}  // namespace
}  // namespace graft::lfd
