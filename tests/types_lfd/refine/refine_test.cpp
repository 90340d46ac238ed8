// SPDX-License-Identifier: BSD-3-Clause
// The last step on made-up motions of a made-up robot.
#include "types_lfd/refine/refine.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/types_lfd/reach/small_map.hpp"
#include "types_lfd/build/graph_builder.hpp"
#include "types_lfd/map/polygon.hpp"

namespace graft::lfd {
namespace {

using testing::smallMap;
using testing::smallRobotChain;

constexpr double kStep = 0.1;  // s

/// A configuration in the middle of the arm's range, gripper about 0.8 m ahead.
Eigen::VectorXd relaxed() {
  Eigen::VectorXd q(7);
  q << 0.15, 0.0, 0.4, 0.7, 0.3, -0.6, 0.2;
  return q;
}

/// The base follows `base`, the gripper stays ahead of it as if in its hand.
DemonstrationEstimate carried(const std::vector<Pose2>& base, const Eigen::VectorXd& q) {
  DemonstrationEstimate demo;
  demo.name = "made_up";
  const Pose base_T_gripper = smallRobotChain().forward(q);
  for (std::size_t i = 0; i < base.size(); ++i) {
    demo.times.push_back(kStep * double(i));
    demo.base.push_back(base[i]);
    demo.gripper.push_back(floorPose(base[i]) * base_T_gripper);
  }
  demo.hand = demo.object = demo.torso = demo.gripper;
  demo.segments.release = base.size() - 1;
  return demo;
}

std::vector<Pose2> straight(std::size_t count, double from, double step, double y = 0) {
  std::vector<Pose2> base;
  for (std::size_t i = 0; i < count; ++i) base.emplace_back(from + step * double(i), y, 0);
  return base;
}

TaskScene sceneWith(std::unique_ptr<const OccupancyMap> map, double half_side = 0.25) {
  TaskScene scene;
  scene.chain = std::make_unique<Chain>(smallRobotChain());
  scene.reach = std::make_unique<ReachMap>(smallMap());
  scene.map = std::move(map);
  const double h = half_side;
  if (scene.map != nullptr) {
    scene.footprint =
        std::make_unique<FootprintChecker>(*scene.map, Polygon{{h, h}, {-h, h}, {-h, -h}, {h, -h}});
  }
  return scene;
}

/// 4 m x 4 m around the origin in cells of 5 cm; occupied where told.
template <class Occupied>
std::unique_ptr<const OccupancyMap> mapWhere(const Occupied& occupied) {
  constexpr int kSide = 80;
  std::vector<Cell> cells;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const double x = -2 + 0.05 * (column + 0.5);
      const double y = -2 + 0.05 * (row + 0.5);
      cells.push_back(occupied(x, y) ? Cell::kOccupied : Cell::kFree);
    }
  }
  return std::make_unique<OccupancyMap>(kSide, kSide, 0.05, Pose2(-2, -2, 0), std::move(cells));
}

/// Joint vectors are within limits and put the gripper where it was.
void expectConsistent(const DemonstrationEstimate& demo, const RefinedTrack& track) {
  const Chain chain = smallRobotChain();
  ASSERT_EQ(track.base.size(), demo.size());
  ASSERT_EQ(track.joints.joints.size(), demo.size());
  for (std::size_t i = 0; i < demo.size(); ++i) {
    const Eigen::VectorXd& q = track.joints.joints[i];
    if (q.size() == 0) continue;
    const Pose gripper = floorPose(track.base[i]) * chain.forward(q);
    const Vec<double, 6> e = poseError(gripper.inverse() * demo.gripper[i]);
    EXPECT_LT(e.head<3>().norm(), 1e-3) << i;
    EXPECT_LT(e.tail<3>().norm(), 1e-3) << i;
    for (int j = 0; j < chain.dof(); ++j) {
      if (chain.continuous(j)) continue;
      EXPECT_GE(q[j], chain.lower()[j]) << i;
      EXPECT_LE(q[j], chain.upper()[j]) << i;
    }
  }
}

void expectResolved(const DemonstrationEstimate& demo, const TaskScene& scene,
                    const RefineResult& result) {
  EXPECT_EQ(result.unresolved, 0u);
  EXPECT_EQ(result.blocked_steps, 0u);
  EXPECT_EQ(result.fast_steps, 0u);
  EXPECT_EQ(result.solved, demo.size());
  EXPECT_TRUE(result.notes.empty());
  const RefinedTrack& track = result.tracks.front();
  expectConsistent(demo, track);
  const Chain& chain = *scene.chain;
  for (std::size_t i = 0; i < demo.size(); ++i) {
    EXPECT_TRUE(scene.reach->contains(demo.gripper[i], track.base[i])) << i;
    if (i + 1 < demo.size()) {
      const Eigen::VectorXd step = track.joints.joints[i + 1] - track.joints.joints[i];
      const double seconds = demo.times[i + 1] - demo.times[i];
      for (int j = 0; j < chain.dof(); ++j) {
        EXPECT_LE(std::abs(step[j]), 2 * chain.velocity()[j] * seconds + 1e-9) << i << " " << j;
      }
    }
    if (scene.map == nullptr) continue;
    EXPECT_FALSE(scene.footprint->inCollision(track.base[i])) << i;
    if (i > 0) {
      EXPECT_TRUE(scene.footprint->pathFree(track.base[i - 1], track.base[i])) << i;
    }
    const Eigen::Vector3d shoulder =
        floorPose(track.base[i]) * Vec<double, 3>(chain.origins(track.joints.joints[i]).col(1));
    const Eigen::Vector3d gripper = demo.gripper[i].translation;
    EXPECT_TRUE(scene.map->segmentFree(shoulder.head<2>(), gripper.head<2>())) << i;
  }
}

void expectSame(const Pose2& a, const Pose2& b) {
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.theta, b.theta);
}

TEST(RefineBases, KeepsWhatIsGoodExactly) {
  const TaskScene scene = sceneWith(nullptr);
  const DemonstrationEstimate demo = carried(straight(40, 0, 0.02), relaxed());
  const RefineResult result = refineBases({demo}, scene);
  expectResolved(demo, scene, result);
  EXPECT_EQ(result.moved, 0u);
  EXPECT_EQ(result.farthest, 0);
  for (std::size_t i = 0; i < demo.size(); ++i) {
    expectSame(result.tracks[0].base[i], demo.base[i]);
  }
}

TEST(RefineBases, BringsABaseBackIntoReachAndNoOther) {
  const TaskScene scene = sceneWith(nullptr);
  DemonstrationEstimate demo = carried(straight(60, 0, 0.02), relaxed());
  for (std::size_t i = 25; i < 35; ++i) demo.base[i].x -= 0.3;  // 1.1 m: out of reach
  ASSERT_FALSE(scene.reach->contains(demo.gripper[30], demo.base[30]));
  const RefineResult result = refineBases({demo}, scene);
  expectResolved(demo, scene, result);
  EXPECT_GE(result.moved, 10u);
  EXPECT_GT(result.mean_distance, 0.02);
  for (const std::size_t i : {0, 5, 10, 50, 59}) {
    expectSame(result.tracks[0].base[i], demo.base[i]);
  }
}

TEST(RefineBases, PassesANarrowDoorway) {
  // An opening 0.7 m wide for a base of 0.5 m, and a way 0.15 m off its middle.
  const TaskScene scene = sceneWith(
      mapWhere([](double x, double y) { return x > 0 && x < 0.2 && std::abs(y) > 0.35; }));
  const DemonstrationEstimate demo = carried(straight(80, -1.2, 0.025, 0.15), relaxed());
  ASSERT_TRUE(scene.footprint->inCollision(Pose2(0.1, 0.15, 0)));
  const RefineResult result = refineBases({demo}, scene);
  expectResolved(demo, scene, result);
  EXPECT_LT(result.farthest, 0.3);
  expectSame(result.tracks[0].base.front(), demo.base.front());
}

TEST(RefineBases, DoesNotReachThroughAWall) {
  // A thin wall between the base and a gripper that waits behind it.
  const DemonstrationEstimate demo = carried(std::vector<Pose2>(20, Pose2(-0.6, 0, 0)), relaxed());
  const TaskScene scene = sceneWith(
      mapWhere([](double x, double y) { return x > -0.2 && x < -0.15 && std::abs(y) < 0.2; }), 0.2);
  ASSERT_FALSE(scene.footprint->inCollision(demo.base[0]));
  const Eigen::Vector2d gripper = demo.gripper[0].translation.head<2>();
  ASSERT_FALSE(scene.map->segmentFree({demo.base[0].x + 0.15, -0.1}, gripper));
  const RefineResult result = refineBases({demo}, scene);
  expectResolved(demo, scene, result);
  EXPECT_EQ(result.moved, demo.size());
}

TEST(RefineBases, CountsAndKeepsWhatNoBaseReaches) {
  const TaskScene scene = sceneWith(nullptr);
  DemonstrationEstimate demo = carried(straight(60, 0, 0.02), relaxed());
  for (std::size_t i = 20; i < 30; ++i) demo.gripper[i].translation.z() = 3;
  const RefineResult result = refineBases({demo}, scene);
  EXPECT_EQ(result.unresolved, 10u);
  EXPECT_EQ(result.solved, 50u);
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_EQ(result.notes[0], "made_up: 10 tuples have no base that is free and in reach nearby");
  expectConsistent(demo, result.tracks[0]);
  for (std::size_t i = 0; i < demo.size(); ++i) {
    EXPECT_EQ(result.tracks[0].joints.joints[i].size() == 0, i >= 20 && i < 30) << i;
    expectSame(result.tracks[0].base[i], demo.base[i]);
  }
}

TEST(RefineBases, TakesShortAndEmptyDemonstrations) {
  const TaskScene scene = sceneWith(nullptr);
  DemonstrationEstimate one = carried(straight(1, 0, 0), relaxed());
  one.base[0].x -= 0.4;
  const RefineResult result = refineBases({one, DemonstrationEstimate()}, scene);
  EXPECT_EQ(result.tuples, 1u);
  EXPECT_EQ(result.solved, 1u);
  EXPECT_EQ(result.moved, 1u);
  EXPECT_TRUE(refineBases({}, scene).tracks.empty());
}

TEST(RefineBases, IsTheSameForAnyNumberOfThreads) {
  const TaskScene scene = sceneWith(
      mapWhere([](double x, double y) { return x > 0 && x < 0.2 && std::abs(y) > 0.35; }));
  std::vector<DemonstrationEstimate> demos;
  for (const double y : {0.15, -0.12, 0.0}) {
    demos.push_back(carried(straight(70, -1.2, 0.03, y), relaxed()));
  }
  RefineOptions options;
  options.threads = 1;
  const RefineResult one = refineBases(demos, scene, options);
  options.threads = 4;
  const RefineResult four = refineBases(demos, scene, options);
  EXPECT_EQ(one.mean_distance, four.mean_distance);
  for (std::size_t d = 0; d < demos.size(); ++d) {
    for (std::size_t i = 0; i < demos[d].size(); ++i) {
      expectSame(one.tracks[d].base[i], four.tracks[d].base[i]);
      EXPECT_EQ(one.tracks[d].joints.joints[i], four.tracks[d].joints.joints[i]);
    }
  }
}

TEST(Chain, OriginsAreWhereTheJointsTurn) {
  const Chain chain = smallRobotChain();
  Eigen::VectorXd q = relaxed();
  const Eigen::Matrix3Xd origins = chain.origins(q);
  // Torso's joint is fixed in the base; the pan joint rides on it.
  EXPECT_LT((origins.col(0) - Eigen::Vector3d(0.05, 0, 0.6)).norm(), 1e-12);
  EXPECT_LT((origins.col(1) - Eigen::Vector3d(0.15, -0.1, 0.6 + q[0])).norm(), 1e-12);
  // The tool is 0.12 m ahead of the last joint, along the gripper's x axis.
  const Pose gripper = chain.forward(q);
  const Eigen::Vector3d wrist = gripper * Vec<double, 3>(-0.12, 0, 0);
  EXPECT_LT((origins.col(6) - wrist).norm(), 1e-12);
}

}  // namespace
}  // namespace graft::lfd
