// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/types_lfd/reach/small_map.hpp"
#include "types_lfd/robot/arm_ik.hpp"

namespace graft::lfd {
namespace {

using testing::onFloor;
using testing::smallMap;
using testing::smallOptions;
using testing::smallRobotChain;
using testing::uniform;

Eigen::Matrix3d gripperRotation(double heading, double elevation, double roll) {
  return (Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(-elevation, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

TEST(ReachMap, SomewhereIsAnyCellOfThePosesSlice) {
  const ReachMap& map = smallMap();
  const ReachGrid& grid = map.grid();
  std::mt19937_64 random(8);
  std::size_t inside = 0;
  for (int n = 0; n < 2000; ++n) {
    const Pose gripper(
        Eigen::Vector3d(3, -2, uniform(random, -0.5, 2)),
        Eigen::Quaterniond(gripperRotation(uniform(random, -3, 3), uniform(random, -1.5, 1.5),
                                           uniform(random, -3, 3))));
    // A base at every node, asked one by one: in between, distances are no larger.
    const GripperView view = grid.view(gripper);
    bool any = false;
    for (int psi = 0; psi < grid.psiCount() && !any; ++psi) {
      for (int y = 0; y < grid.ny && !any; ++y) {
        for (int x = 0; x < grid.nx && !any; ++x) {
          const Pose2 node((grid.x0 + x) * grid.resolution, (grid.y0 + y) * grid.resolution,
                           psi * grid.nodeStep());
          any = map.contains(gripper, baseInWorld(view, node));
        }
      }
    }
    ASSERT_EQ(map.reachableSomewhere(gripper), any);
    inside += any ? 1 : 0;
    const ReachMap::Heights heights = map.heights(gripper);
    const double z = gripper.translation[2];
    if (any) {
      EXPECT_LE(heights.low, z + 1e-6);
      EXPECT_GE(heights.high, z - 1e-6);
      EXPECT_LE(map.heights().low, heights.low);
      EXPECT_GE(map.heights().high, heights.high);
    }
  }
  EXPECT_GT(inside, 100u);
  EXPECT_LT(inside, 1900u);
  Pose above;
  above.translation[2] = map.heights().high + 1e-6;
  EXPECT_FALSE(map.reachableSomewhere(above));
}

TEST(ReachGrid, SplitsOrientationsAsStated) {
  std::mt19937_64 random(1);
  for (int n = 0; n < 10000; ++n) {
    const double heading = uniform(random, -M_PI, M_PI);
    const double elevation = uniform(random, -1.57, 1.57);
    const double roll = uniform(random, -M_PI, M_PI);
    const GripperView view =
        ReachGrid::view(gripperRotation(heading, elevation, roll), Eigen::Vector3d::Zero());
    EXPECT_NEAR(view.heading, heading, 1e-9);
    EXPECT_NEAR(view.elevation, elevation, 1e-9);
    EXPECT_NEAR(view.roll, roll, 1e-9);
  }
}

/// Straight up or down the heading is arbitrary, and nothing may depend on it.
TEST(ReachMap, IsContinuousWhereTheHeadingIsNot) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(11);
  double worst = 0;
  for (int n = 0; n < 300; ++n) {
    const double sign = n % 2 == 0 ? 1 : -1;
    const Pose2 base(uniform(random, -0.7, 0.7), uniform(random, -0.7, 0.7), 0.3 * n);
    const Eigen::Vector3d position(0, 0, uniform(random, 0.2, 1.3));
    const auto distance = [&](const Eigen::Matrix3d& rotation) {
      return smallMap().distance(Pose(position, Eigen::Quaterniond(rotation)), base);
    };
    const Eigen::Matrix3d straight = gripperRotation(0.5, sign * M_PI / 2, 0);
    for (double around = -3; around < 3; around += 0.5) {
      const Eigen::AngleAxisd tilt(1e-3, Eigen::Vector3d(std::cos(around), std::sin(around), 0));
      worst = std::max(worst, std::abs(distance(tilt * straight) - distance(straight)));
    }
  }
  // Nodes stand at angles of their own, which is what is left of the choice.
  EXPECT_LT(worst, 0.5 * smallMap().grid().resolution);
}

TEST(ReachGrid, BaseInViewAndBack) {
  std::mt19937_64 random(2);
  for (int n = 0; n < 1000; ++n) {
    GripperView view;
    view.heading = uniform(random, -M_PI, M_PI);
    view.position = Eigen::Vector3d(uniform(random, -9, 9), uniform(random, -9, 9), 1);
    const Pose2 base(uniform(random, -9, 9), uniform(random, -9, 9), uniform(random, -3.1, 3.1));
    const Pose2 back = baseInWorld(view, baseInView(view, base));
    EXPECT_LT(back.minus(base).norm(), 1e-12);
  }
}

TEST(ReachMap, HoldsWhatTheArmReaches) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(3);
  int held = 0;
  constexpr int kCount = 2000;
  for (int n = 0; n < kCount; ++n) {
    const Pose pose = chain.forward(sampleJoints(chain, random));
    const bool holds = smallMap().contains(pose, Pose2());
    held += holds ? 1 : 0;
    EXPECT_EQ(smallMap().quality(pose, Pose2()) > 0, holds);
    // And nothing beyond its length.
    Pose far = pose;
    far.translation[0] += 2 * chain.reachBound() + 0.5;
    EXPECT_FALSE(smallMap().contains(far, Pose2()));
    EXPECT_EQ(smallMap().quality(far, Pose2()), 0);
  }
  // Twice as coarse as the default, and a sixteenth of its samples.
  EXPECT_GE(held, 0.93 * kCount);
}

TEST(ReachMap, AgreesWithInverseKinematics) {
  const Chain chain = smallRobotChain();
  const Eigen::VectorXd start = 0.5 * (chain.lower() + chain.upper());
  std::mt19937_64 random(4);
  int agree = 0;
  constexpr int kCount = 500;
  for (int n = 0; n < kCount; ++n) {
    Pose pose(
        Eigen::Vector3d(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, 0.1, 1.6)),
        Eigen::Quaterniond(1, 0, 0, 0));
    pose.rotation = Eigen::Quaterniond(uniform(random, -1, 1), uniform(random, -1, 1),
                                       uniform(random, -1, 1), uniform(random, -1, 1))
                        .normalized();
    agree += solveIk(chain, pose, start).has_value() == smallMap().contains(pose, Pose2()) ? 1 : 0;
  }
  EXPECT_GE(agree, 0.96 * kCount);
}

TEST(ReachMap, DoesNotDependOnWhereTheSceneStands) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(5);
  int changed = 0;
  for (int n = 0; n < 5000; ++n) {
    const Pose pose = chain.forward(sampleJoints(chain, random));
    const Pose2 scene(uniform(random, -5, 5), uniform(random, -5, 5), uniform(random, -3, 3));
    const int here = smallMap().quality(pose, Pose2());
    changed += here != smallMap().quality(onFloor(scene) * pose, scene) ? 1 : 0;
  }
  // Only poses within rounding of a cell's face may differ.
  EXPECT_LE(changed, 1);
}

TEST(ReachMap, IsTheSameForAnyNumberOfThreads) {
  ReachOptions options = smallOptions();
  options.threads = 1;
  const ReachMap one = ReachMap::build(smallRobotChain(), options);
  options.threads = 3;
  const ReachMap three = ReachMap::build(smallRobotChain(), options);
  EXPECT_EQ(one.cells(), three.cells());
  EXPECT_EQ(one.distances(), three.distances());
  EXPECT_EQ(one.samples(), three.samples());
  options.seed = 2;
  EXPECT_NE(ReachMap::build(smallRobotChain(), options).distances(), one.distances());
}

TEST(ReachMap, ReportsProgressThatRises) {
  double last = 0;
  int calls = 0;
  ReachMap::build(smallRobotChain(), smallOptions(), [&](double fraction) {
    EXPECT_GE(fraction, last);
    EXPECT_LE(fraction, 1);
    last = fraction;
    ++calls;
  });
  EXPECT_EQ(last, 1);
  EXPECT_GT(calls, 1);
}

TEST(ReachMap, MapsShortChainsToo) {
  // One joint: the tool goes around in a circle; nothing else may be assumed.
  Diagnostics diagnostics;
  const UrdfModel model =
      readUrdfText("f",
                   "<robot name='r'><link name='a'/><link name='b'/><link name='t'/>"
                   "<joint name='1' type='continuous'><parent link='a'/><child link='b'/>"
                   "<origin xyz='0 0 0.75'/><axis xyz='0 0 1'/></joint>"
                   "<joint name='2' type='fixed'><parent link='b'/><child link='t'/>"
                   "<origin xyz='0.52 0 0'/></joint></robot>",
                   diagnostics);
  const Chain chain(model, "a", "t");
  ReachOptions options = smallOptions();
  const ReachMap map = ReachMap::build(chain, options);
  for (double q = -3; q < 3; q += 0.1) {
    EXPECT_TRUE(map.contains(chain.forward(&q), Pose2())) << q;
    const Pose pose = chain.forward(&q);
    EXPECT_FALSE(map.contains(pose, Pose2(0.3, 0, 0)));
  }
}

TEST(ReachMap, RefusesOptionsOutOfRange) {
  const auto refused = [](auto change) {
    ReachOptions options = smallOptions();
    change(options);
    try {
      ReachMap::build(smallRobotChain(), options);
    } catch (const Error& error) {
      return error.code();
    }
    return ExitCode::kSuccess;
  };
  const auto usage = ExitCode::kUsage;
  EXPECT_EQ(refused([](ReachOptions& o) { o.resolution = 0; }), usage);
  EXPECT_EQ(refused([](ReachOptions& o) { o.resolution = std::nan(""); }), usage);
  EXPECT_EQ(refused([](ReachOptions& o) { o.angular_step = 0.7; }), usage);
  EXPECT_EQ(refused([](ReachOptions& o) { o.angular_step = 0; }), usage);
  EXPECT_EQ(refused([](ReachOptions& o) { o.angular_step = std::nan(""); }), usage);
  EXPECT_EQ(refused([](ReachOptions& o) { o.max_samples = 0; }), usage);
  EXPECT_EQ(refused([](ReachOptions& o) {
              o.resolution = 0.005;
              o.angular_step = M_PI / 36;
            }),
            ExitCode::kResources);
}

}  // namespace
}  // namespace graft::lfd
