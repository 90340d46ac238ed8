// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/performance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "types_lfd/map/footprint.hpp"
#include "types_lfd/teach/teacher_robot.hpp"

namespace graft::lfd {
namespace {

constexpr std::uint64_t kSeeds[] = {1, 2, 3, 4, 5, 6, 7, 8};

/// Calls `check` for every task, several seeds and every demonstration.
template <class Check>
void forAll(const Check& check, const TeachOptions& options = {}) {
  for (const std::string& task : teachableTasks()) {
    for (const std::uint64_t seed : kSeeds) {
      if (options.move_object && task == "room_door") continue;
      const Scenario scenario = drawScenario(task, seed, options);
      for (int i = 0; i < scenario.demonstrations; ++i) {
        SCOPED_TRACE(task + ", seed " + std::to_string(seed) + ", demonstration " +
                     std::to_string(i));
        check(scenario, perform(scenario, i, seed, options));
      }
    }
  }
}

TEST(Performance, ObjectMovesAsItsMechanismAllows) {
  forAll([](const Scenario& s, const Performance& p) {
    const Furniture& f = s.furniture;
    double widest = 0;
    for (const Pose& world_T_object : p.object.poses) {
      const Pose handle = p.world_T_furniture.inverse() * world_T_object;
      if (f.kind == Furniture::Kind::kSlider) {
        const Eigen::Vector3d moved = handle.translation - f.handle(0, 0).translation;
        const double along = moved.dot(f.direction);
        widest = std::max(widest, along / f.travel);
        ASSERT_LT((moved - along * f.direction).norm(), 1e-9);
        ASSERT_LT(rotationAngle(handle.rotation), 1e-9);
        continue;
      }
      // The lever's axis goes round the hinge at a constant radius and height,
      // and the handle round that axis.
      const Eigen::Vector3d axis = handle * Eigen::Vector3d(0, f.lever_arm, 0);
      ASSERT_NEAR(axis.head<2>().norm(), std::hypot(f.standoff, f.radius + f.lever_arm), 1e-9);
      ASSERT_NEAR(axis.z(), f.height, 1e-9);
      const double angle =
          std::atan2(axis.y(), axis.x()) - std::atan2(f.radius + f.lever_arm, -f.standoff);
      widest = std::max(widest, std::remainder(angle, 2 * std::acos(-1.0)) / f.travel);
      // x of the handle lies in the plane of the leaf's normal.
      const Eigen::Vector3d x = handle.rotation * Eigen::Vector3d::UnitX();
      ASSERT_NEAR(std::remainder(std::atan2(x.y(), x.x()) - angle, 2 * std::acos(-1.0)), 0, 1e-9);
    }
    ASSERT_NEAR(widest, 1, 1e-6);
  });
}

TEST(Performance, HandHoldsTheHandleUpToTheSlip) {
  forAll([](const Scenario& s, const Performance& p) {
    ASSERT_GT(p.grasp_time, p.hand.times.front() + 1);
    ASSERT_LT(p.release_time, p.hand.times.back() - 0.5);
    Pose first;
    double farthest = 0;
    bool holding = false;
    for (std::size_t i = 0; i < p.hand.size(); ++i) {
      const Pose object_T_hand = p.object.poses[i].inverse() * p.hand.poses[i];
      if (p.hand.times[i] >= p.grasp_time && p.hand.times[i] <= p.release_time) {
        if (!holding) first = object_T_hand;
        holding = true;
        const Vec<double, 6> slip = poseError(first.inverse() * object_T_hand);
        ASSERT_LT(slip.head<3>().cwiseAbs().maxCoeff(), 2.5 * s.slip_t);
        ASSERT_LT(slip.tail<3>().cwiseAbs().maxCoeff(), 2.5 * s.slip_r);
        ASSERT_LT(object_T_hand.translation.norm(), 0.1);
      }
      farthest = std::max(farthest, object_T_hand.translation.norm());
    }
    ASSERT_GT(farthest, 0.7);
  });
}

TEST(Performance, MotionIsThatOfAPerson) {
  forAll([](const Scenario&, const Performance& p) {
    const double start = (p.hand.poses[0].translation - p.object.poses[0].translation).norm();
    ASSERT_GE(start, 0.7);
    ASSERT_LE(start, 1.2);
    for (std::size_t i = 0; i < p.hand.size(); ++i) {
      const double arm = (p.hand.poses[i].translation - p.torso.poses[i].translation).norm();
      ASSERT_GT(arm, 0.2) << i;
      ASSERT_LT(arm, 0.95) << i;
      ASSERT_GT(p.hand.poses[i].translation.z(), 0.3);
      ASSERT_LT(p.hand.poses[i].translation.z(), 1.3);
      if (i == 0) continue;
      const double dt = p.hand.times[i] - p.hand.times[i - 1];
      ASSERT_GT(dt, 0);
      const double hand_speed =
          (p.hand.poses[i].translation - p.hand.poses[i - 1].translation).norm() / dt;
      const double torso_speed =
          (p.torso.poses[i].translation - p.torso.poses[i - 1].translation).norm() / dt;
      ASSERT_LT(hand_speed, 2.0) << i;
      ASSERT_LT(torso_speed, 1.2) << i;
    }
  });
}

/// The frames before the grasp come in along the fingers.
TEST(Performance, HandComesInAlongTheFingers) {
  forAll([](const Scenario&, const Performance& p) {
    const auto grasp = std::find(p.hand.times.begin(), p.hand.times.end(), p.grasp_time);
    ASSERT_NE(grasp, p.hand.times.end());
    const auto at = static_cast<std::size_t>(grasp - p.hand.times.begin());
    for (std::size_t i = at - 1; i > 0; --i) {
      const Eigen::Vector3d way = p.hand.poses[at].translation - p.hand.poses[i].translation;
      if (way.norm() < 0.01) continue;
      const Eigen::Vector3d fingers = p.hand.poses[at].rotation * Eigen::Vector3d::UnitX();
      EXPECT_GT(way.normalized().dot(fingers), 0.8);
      break;
    }
  });
}

TEST(Performance, MapIsFreeWhereThePersonWalks) {
  forAll([](const Scenario& s, const Performance& p) {
    const OccupancyMap map = drawMap(s);
    for (const Pose& torso : p.torso.poses) {
      ASSERT_TRUE(map.inside(torso.translation.x(), torso.translation.y()));
      ASSERT_FALSE(map.unknown(torso.translation.x(), torso.translation.y()));
      ASSERT_GT(map.clearance(torso.translation.x(), torso.translation.y()), 0.2);
    }
  });
}

TEST(Performance, PersonWalksThroughTheDoor) {
  for (const std::uint64_t seed : kSeeds) {
    const Scenario s = drawScenario("room_door", seed, {});
    const OccupancyMap map = drawMap(s);
    const Performance p = perform(s, 0, seed, {});
    const Pose scene_T_world = s.world_T_scene.inverse();
    EXPECT_LT((scene_T_world * p.torso.poses.front().translation).x(), -1);
    EXPECT_GT((scene_T_world * p.torso.poses.back().translation).x(), 0.7);
    // A wall parts the rooms, but for the opening.
    const auto see = [&](double y) {
      const Eigen::Vector3d a = s.world_T_scene * Eigen::Vector3d(-0.5, y, 0);
      const Eigen::Vector3d b = s.world_T_scene * Eigen::Vector3d(0.5, y, 0);
      return map.segmentFree(a.head<2>(), b.head<2>());
    };
    EXPECT_FALSE(see(s.opening_low - 0.1));
    EXPECT_FALSE(see(s.opening_high + 0.1));
    EXPECT_TRUE(see(0.5 * (s.opening_low + s.opening_high)));
  }
}

TEST(Performance, RobotFitsThroughTheDoor) {
  for (const std::uint64_t seed : kSeeds) {
    const Scenario s = drawScenario("room_door", seed, {});
    const OccupancyMap map = drawMap(s);
    const double w = kRobotHalfWidth;
    const FootprintChecker checker(map, {{w, w}, {-w, w}, {-w, -w}, {w, -w}});
    const double yaw = logSO3(s.world_T_scene.rotation).z();
    const auto at = [&](double x, double y) {
      const Eigen::Vector3d p = s.world_T_scene * Eigen::Vector3d(x, y, 0);
      return Pose2(p.x(), p.y(), yaw);
    };
    const double middle = 0.5 * (s.opening_low + s.opening_high);
    EXPECT_TRUE(checker.pathFree(at(-1, middle), at(1, middle))) << seed;
    EXPECT_FALSE(checker.pathFree(at(-1, middle + 0.4), at(1, middle + 0.4))) << seed;
    EXPECT_FALSE(checker.pathFree(at(-1, middle - 0.4), at(1, middle - 0.4))) << seed;
  }
}

TEST(Performance, FurnitureCanStandElsewhereEachTime) {
  TeachOptions options;
  options.move_object = true;
  Pose last;
  forAll(
      [&last](const Scenario& s, const Performance& p) {
        const Pose moved = last.inverse() * p.world_T_furniture;
        EXPECT_GT(moved.translation.head<2>().norm(), 0.005);
        last = p.world_T_furniture;
        const OccupancyMap map = drawMap(s);
        EXPECT_TRUE(
            map.inside(p.object.poses[0].translation.x(), p.object.poses[0].translation.y()));
        EXPECT_GT(
            map.clearance(p.object.poses[0].translation.x(), p.object.poses[0].translation.y()),
            0.3);
      },
      options);
}

TEST(Scenario, RefusesWhatItCannotDo) {
  TeachOptions move;
  move.move_object = true;
  TeachOptions loud;
  loud.noise_scale = -1;
  TeachOptions many;
  many.demonstrations = 100;
  const std::pair<const char*, TeachOptions> bad[] = {
      {"window", {}}, {"room_door", move}, {"drawer", loud}, {"drawer", many}};
  for (const auto& [task, options] : bad) {
    try {
      drawScenario(task, 1, options);
      ADD_FAILURE() << task;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kUsage) << task;
    }
  }
}

}  // namespace
}  // namespace graft::lfd
