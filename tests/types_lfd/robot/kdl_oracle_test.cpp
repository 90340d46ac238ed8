// SPDX-License-Identifier: BSD-3-Clause
// Our URDF reader and kinematics against urdfdom and KDL.
#include <gtest/gtest.h>

#include "tests/support/test_data.hpp"
#include "types_lfd/robot/chain.hpp"

#ifdef GRAFT_HAS_KDL
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <random>
#endif

namespace graft::lfd {
namespace {

#ifdef GRAFT_HAS_KDL

KDL::Chain kdlChain(const urdf::ModelInterface& model, const std::string& base,
                    const std::string& tip) {
  std::vector<urdf::JointConstSharedPtr> path;
  for (auto link = model.getLink(tip); link->name != base; link = link->getParent()) {
    path.push_back(link->parent_joint);
  }
  std::reverse(path.begin(), path.end());
  KDL::Chain chain;
  for (const auto& joint : path) {
    const auto& o = joint->parent_to_joint_origin_transform;
    const KDL::Frame frame(
        KDL::Rotation::Quaternion(o.rotation.x, o.rotation.y, o.rotation.z, o.rotation.w),
        KDL::Vector(o.position.x, o.position.y, o.position.z));
    const KDL::Vector axis = frame.M * KDL::Vector(joint->axis.x, joint->axis.y, joint->axis.z);
    KDL::Joint kind(KDL::Joint::None);
    if (joint->type == urdf::Joint::PRISMATIC) {
      kind = KDL::Joint(joint->name, frame.p, axis, KDL::Joint::TransAxis);
    } else if (joint->type != urdf::Joint::FIXED) {
      kind = KDL::Joint(joint->name, frame.p, axis, KDL::Joint::RotAxis);
    }
    chain.addSegment(KDL::Segment(kind, frame));
  }
  return chain;
}

TEST(KdlOracle, ForwardKinematicsAndJacobianAgree) {
  const struct {
    const char* file;
    const char* tip;
  } robots[] = {{"robots/pr2/pr2_moveit_resources.urdf", "r_gripper_tool_frame"},
                {"robots/pr2/pr2_moveit_resources.urdf", "l_gripper_tool_frame"},
                {"robots/tiago/tiago_no_hand.urdf", "arm_tool_link"}};
  for (const auto& robot : robots) {
    GRAFT_REQUIRE_DATA(robot.file);
    const std::string path = graft::testing::dataPath(robot.file);
    Diagnostics diagnostics;
    const Chain chain(readUrdf(path, diagnostics), "base_footprint", robot.tip);
    const auto oracle = urdf::parseURDFFile(path);
    ASSERT_TRUE(oracle);
    const KDL::Chain kdl = kdlChain(*oracle, "base_footprint", robot.tip);
    ASSERT_EQ(static_cast<int>(kdl.getNrOfJoints()), chain.dof());
    KDL::ChainFkSolverPos_recursive position(kdl);
    KDL::ChainJntToJacSolver velocity(kdl);
    std::mt19937_64 random(6);
    for (int n = 0; n < 1000; ++n) {
      const Eigen::VectorXd q = sampleJoints(chain, random);
      KDL::JntArray joints(kdl.getNrOfJoints());
      joints.data = q;
      KDL::Frame frame;
      ASSERT_GE(position.JntToCart(joints, frame), 0);
      KDL::Jacobian expected(kdl.getNrOfJoints());
      ASSERT_GE(velocity.JntToJac(joints, expected), 0);
      Pose pose;
      Chain::Jacobian jacobian;
      chain.jacobian(q.data(), pose, jacobian);
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(pose.translation[i], frame.p(i), 1e-9);
        for (int j = 0; j < 3; ++j) {
          EXPECT_NEAR(pose.rotation.toRotationMatrix()(i, j), frame.M(i, j), 1e-9);
        }
      }
      EXPECT_LT((expected.data - jacobian).cwiseAbs().maxCoeff(), 1e-9);
    }
    int i = 0;
    for (const std::string& name : chain.names()) {
      const auto joint = oracle->getJoint(name);
      if (!chain.continuous(i)) {
        EXPECT_EQ(chain.lower()[i], joint->limits->lower) << name;
        EXPECT_EQ(chain.upper()[i], joint->limits->upper) << name;
      }
      EXPECT_EQ(chain.velocity()[i], joint->limits->velocity) << name;
      ++i;
    }
  }
}

#else

TEST(KdlOracle, ForwardKinematicsAndJacobianAgree) {
  GTEST_SKIP() << "urdfdom or orocos_kdl was not found when this was built";
}

#endif

}  // namespace
}  // namespace graft::lfd
