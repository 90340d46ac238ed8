// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/robot/chain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/derivatives.hpp"
#include "tests/types_lfd/robot/small_robot.hpp"

namespace graft::lfd {
namespace {

using testing::smallRobotChain;
using testing::smallRobotText;

Chain chainOf(const std::string& text, const std::string& base, const std::string& tip) {
  Diagnostics diagnostics;
  const UrdfModel model = readUrdfText("f", text, diagnostics);
  diagnostics.throwIfErrors();
  return Chain(model, base, tip);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Chain, PlanarArmAgainstItsClosedForm) {
  const Chain chain = chainOf(
      "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='t'/>"
      "<joint name='1' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 -1'/>"
      "<limit lower='-1' upper='2' velocity='3'/></joint>"
      "<joint name='2' type='continuous'><parent link='b'/><child link='c'/>"
      "<origin xyz='0.5 0 0'/><axis xyz='0 0 1'/></joint>"
      "<joint name='3' type='fixed'><parent link='c'/><child link='t'/>"
      "<origin xyz='0.25 0 0'/></joint></robot>",
      "a", "t");
  ASSERT_EQ(chain.dof(), 2);
  EXPECT_EQ(chain.names(), (std::vector<std::string>{"1", "2"}));
  EXPECT_EQ(chain.lower()[0], -1);
  EXPECT_TRUE(chain.continuous(1));
  EXPECT_TRUE(std::isinf(chain.velocity()[1]));
  EXPECT_EQ(chain.heightJoint(), -1);
  EXPECT_FALSE(chain.lastJointRolls());
  const double q[] = {0.3, 1.1};
  const Pose pose = chain.forward(q);
  const double a = -q[0];
  const double b = a + q[1];
  const Eigen::Vector3d expected(0.5 * std::cos(a) + 0.25 * std::cos(b),
                                 0.5 * std::sin(a) + 0.25 * std::sin(b), 0);
  EXPECT_LT((pose.translation - expected).norm(), 1e-14);
  EXPECT_LT(rotationAngle(Eigen::Quaterniond(Eigen::AngleAxisd(-b, Eigen::Vector3d::UnitZ())) *
                          pose.rotation),
            1e-7);
}

TEST(Chain, ForwardIsTheProductOfTheJointTransforms) {
  Diagnostics diagnostics;
  const UrdfModel model = readUrdfText("f", smallRobotText(), diagnostics);
  const Pose tip_T_gripper(Eigen::Vector3d(0.01, 0.02, 0.03),
                           expSO3<double>(Eigen::Vector3d(0.1, -0.2, 0.3)));
  const Chain chain(model, "base", "tool", tip_T_gripper);
  std::mt19937_64 random(1);
  for (int n = 0; n < 100; ++n) {
    const Eigen::VectorXd q = sampleJoints(chain, random);
    Pose expected;
    int i = 0;
    for (const UrdfJoint& joint : model.joints) {  // the file is in the order of the chain
      expected = expected * joint.parent_T_joint;
      if (!joint.moves()) continue;
      const Eigen::Vector3d move = q[i++] * joint.axis;
      expected = expected * (joint.type == UrdfJoint::Type::kPrismatic
                                 ? Pose(move, Eigen::Quaterniond::Identity())
                                 : Pose(Eigen::Vector3d::Zero(), expSO3<double>(move)));
    }
    expected = expected * tip_T_gripper;
    EXPECT_LT(chain.forward(q).minus(expected).norm(), 1e-12);
  }
}

TEST(Chain, JacobianAgainstNumericDerivatives) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(2);
  for (int n = 0; n < 20; ++n) {
    const Eigen::VectorXd q = sampleJoints(chain, random);
    Pose pose;
    Chain::Jacobian jacobian;
    chain.jacobian(q.data(), pose, jacobian);
    EXPECT_LT(chain.forward(q).minus(pose).norm(), 1e-12);
    const auto motion = [&](const Eigen::VectorXd& d) {
      const Pose moved = chain.forward(Eigen::VectorXd(q + d));
      Eigen::VectorXd e(6);
      e.head<3>() = moved.translation;
      e.tail<3>() = logSO3(Eigen::Quaterniond(moved.rotation * pose.rotation.conjugate()));
      return e;
    };
    const Eigen::MatrixXd numeric = graft::testing::riddersJacobian(motion, chain.dof());
    EXPECT_LT((numeric - jacobian).cwiseAbs().maxCoeff(), 1e-8);
  }
}

TEST(Chain, FindsTorsoAndRoll) {
  const Chain chain = smallRobotChain();
  EXPECT_EQ(chain.heightJoint(), 0);
  EXPECT_EQ(chain.heightSign(), 1);
  EXPECT_EQ(chain.rollSign(), 1);
  const Chain downwards =
      chainOf(replaced(smallRobotText(), "xyz=\"0.05 0 0.6\"/> <axis xyz=\"0 0 1\"/>",
                       "xyz=\"0.05 0 0.6\"/> <axis xyz=\"0 0 -1\"/>"),
              "base", "tool");
  EXPECT_EQ(downwards.heightSign(), -1);
  const Chain tilted = chainOf(
      replaced(smallRobotText(), "xyz=\"0.05 0 0.6\"", "xyz=\"0.05 0 0.6\" rpy=\"0.2 0 0\""),
      "base", "tool");
  EXPECT_EQ(tilted.heightJoint(), -1);
  const Pose turned(Eigen::Vector3d::Zero(), expSO3<double>(Eigen::Vector3d(0, 0.5, 0)));
  EXPECT_FALSE(smallRobotChain(turned).lastJointRolls());
  const Pose aside(Eigen::Vector3d(0, 0.02, 0), Eigen::Quaterniond::Identity());
  EXPECT_FALSE(smallRobotChain(aside).lastJointRolls());
}

TEST(Chain, PanTurnsTheGripperAboutAnUprightLine) {
  const Chain chain = smallRobotChain();
  ASSERT_EQ(chain.panJoint(), 1);
  std::mt19937_64 random(4);
  for (int n = 0; n < 100; ++n) {
    Eigen::VectorXd q = sampleJoints(chain, random);
    const Pose pose = chain.forward(q);
    const double turn = 0.7;
    q[chain.panJoint()] += turn;
    const Eigen::Vector3d line(chain.panOrigin()[0], chain.panOrigin()[1], 0);
    const Eigen::Quaterniond about_z =
        expSO3<double>(Eigen::Vector3d(0, 0, chain.panSign() * turn));
    const Pose expected(line + about_z * (pose.translation - line), about_z * pose.rotation);
    EXPECT_LT(chain.forward(q).minus(expected).norm(), 1e-12);
  }
}

TEST(Chain, ReachBoundHolds) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(3);
  for (int n = 0; n < 20000; ++n) {
    Eigen::VectorXd q = sampleJoints(chain, random);
    q[chain.heightJoint()] = 0;
    const Eigen::Vector3d t = chain.forward(q).translation;
    EXPECT_LE((t - chain.firstJointOrigin()).norm(), chain.reachBound());
  }
}

TEST(Chain, HashKnowsWhatShapesReach) {
  const std::uint64_t hash = smallRobotChain().hash();
  const auto of = [](const std::string& text) { return chainOf(text, "base", "tool").hash(); };
  EXPECT_EQ(of(smallRobotText()), hash);
  EXPECT_EQ(of(replaced(smallRobotText(), "velocity=\"2\"", "velocity=\"1\"")), hash);
  EXPECT_NE(of(replaced(smallRobotText(), "lower=\"-1.2\"", "lower=\"-1.1\"")), hash);
  EXPECT_NE(of(replaced(smallRobotText(), "0.35 0 0", "0.36 0 0")), hash);
  EXPECT_NE(of(replaced(smallRobotText(), "0.12 0 0", "0.13 0 0")), hash);
  EXPECT_NE(
      smallRobotChain(Pose(Eigen::Vector3d(0, 0, 1e-3), Eigen::Quaterniond::Identity())).hash(),
      hash);
}

}  // namespace
}  // namespace graft::lfd
