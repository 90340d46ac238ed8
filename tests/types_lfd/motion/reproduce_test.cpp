// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/motion/reproduce.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "tests/types_lfd/model/synthetic_motion.hpp"

namespace graft::lfd {
namespace {

using testing::SyntheticTask;

class Reproduce : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { model_ = SyntheticTask().model(); }

  /// The last point of a segment.
  static const MotionPoint& endOf(const std::vector<MotionPoint>& motion, int segment,
                                  int action = 0) {
    const MotionPoint* last = nullptr;
    for (const MotionPoint& p : motion) {
      if (p.segment == segment && p.action == action) last = &p;
    }
    return *last;
  }

  /// Largest share of any limit that a step uses.
  static double worstSpeed(const std::vector<MotionPoint>& motion, const SpeedLimits& limits) {
    double worst = 0;
    for (std::size_t i = 1; i < motion.size(); ++i) {
      const double least = leastTime({motion[i - 1].gripper, motion[i - 1].base},
                                     {motion[i].gripper, motion[i].base}, limits);
      worst = std::max(worst, least / (motion[i].time - motion[i - 1].time));
    }
    return worst;
  }

  static void expectAtGrasp(const MotionPoint& point, const Pose& world_T_object) {
    const Vec<double, 6> error =
        poseError((world_T_object * SyntheticTask::objectTGripper()).inverse() * point.gripper);
    EXPECT_LT(error.head<3>().norm(), 0.005);
    EXPECT_LT(error.tail<3>().norm(), 3.14159265358979323846 / 180);
  }

  static MotionModel model_;
};

MotionModel Reproduce::model_;

TEST_F(Reproduce, EndsAtTheGraspFromManyStarts) {
  const Pose object = SyntheticTask::objectAt(1.5, 0.7, 0.4);
  for (int i = 0; i < 8; ++i) {
    ReproduceOptions options;
    const double angle = 0.8 * i;
    options.start_base = Pose2(3 * std::cos(angle), 3 * std::sin(angle), 2 * angle);
    options.start_gripper =
        Pose(Vec<double, 3>(2.5 * std::cos(angle), 2.5 * std::sin(angle), 0.5 + 0.1 * i),
             expSO3<double>(Vec<double, 3>(0.4 * i, -0.2, 0.3 * i)));
    const auto motion = reproduceMotion(model_, object, options);
    EXPECT_LT(poseError(options.start_gripper->inverse() * motion.front().gripper).norm(), 1e-12);
    EXPECT_LT(poseError(options.start_base->inverse() * motion.front().base).norm(), 1e-12);
    expectAtGrasp(endOf(motion, 0), object);
    EXPECT_LT(worstSpeed(motion, options.limits), 1 + 1e-9);
    EXPECT_EQ(motion.back().segment, 2);
  }
}

TEST_F(Reproduce, TheApproachDoesNotDependOnTheStart) {
  const Pose object = SyntheticTask::objectAt(0, 0, 0);
  const auto plain = reproduceMotion(model_, object, ReproduceOptions());
  ReproduceOptions options;
  options.start_base = Pose2(-4, 1, 1);
  const auto far = reproduceMotion(model_, object, options);
  const double end_plain = endOf(plain, 0).time;
  const double end_far = endOf(far, 0).time;
  // The last 0.5 s of reaching, counted back from the grasp.
  for (int i = 0; i < 25; ++i) {
    const auto& a = plain[static_cast<std::size_t>(std::lround(50 * end_plain) - i)];
    const auto& b = far[static_cast<std::size_t>(std::lround(50 * end_far) - i)];
    EXPECT_LT((a.gripper.translation - b.gripper.translation).norm(), 2e-3);
    EXPECT_LT(std::hypot(a.base.x - b.base.x, a.base.y - b.base.y), 2e-3);
  }
}

TEST_F(Reproduce, FollowsTheRegressionWhereNoLimitBinds) {
  ReproduceOptions options;
  options.limits = {100, 100, 100, 100};
  const Pose object = SyntheticTask::objectAt(0.3, -0.2, 1);
  const auto motion = reproduceMotion(model_, object, options);
  double duration = 0;
  for (const SegmentModel& s : model_.segments) duration += s.duration;
  EXPECT_NEAR(motion.back().time, duration, 3.0 / options.rate);
  EXPECT_EQ(motion.front().time, 0);
  double begin = 0;
  for (const MotionPoint& p : motion) {
    const SegmentModel& s = model_.segments[static_cast<std::size_t>(p.segment)];
    const double length = endOf(motion, p.segment).time;
    if (p.segment > 0) begin = endOf(motion, p.segment - 1).time;
    const double phase = (p.time - begin) / (length - begin);
    const Pose expected = s.chart.decodeGripper(s.mixture.atTime(phase).mean, object);
    // Apart by the offsets that join the segments.
    EXPECT_LT((expected.translation - p.gripper.translation).norm(), 0.03);
    EXPECT_TRUE(p.covariance.allFinite());
    EXPECT_GT(p.covariance.trace(), 0);
  }
}

TEST_F(Reproduce, IsContinuousAndEvenlyTimed) {
  ReproduceOptions options;
  options.rate = 100;
  const auto motion = reproduceMotion(model_, SyntheticTask::objectAt(2, 1, 3), options);
  EXPECT_LT(worstSpeed(motion, options.limits), 1 + 1e-9);
  for (std::size_t i = 0; i < motion.size(); ++i) {
    EXPECT_NEAR(motion[i].time, static_cast<double>(i) / 100, 1e-12);
    EXPECT_NEAR(motion[i].gripper.rotation.norm(), 1, 1e-14);
  }
}

TEST_F(Reproduce, RestsWhereSegmentsMeet) {
  ReproduceOptions options;
  options.start_gripper =
      Pose(Vec<double, 3>(-0.5, 0.8, 1.4), expSO3<double>(Vec<double, 3>(1.5, -0.6, 0.8)));
  options.rate = 200;
  const auto motion = reproduceMotion(model_, SyntheticTask::objectAt(0, 0, 0), options);
  const auto speedAt = [&](std::size_t i) {
    return leastTime({motion[i - 1].gripper, motion[i - 1].base},
                     {motion[i].gripper, motion[i].base}, {1, 1, 1, 1}) *
           options.rate;
  };
  double fastest = 0;
  for (std::size_t i = 1; i < motion.size(); ++i) fastest = std::max(fastest, speedAt(i));
  EXPECT_LT(speedAt(1), 0.03 * fastest);
  EXPECT_LT(speedAt(motion.size() - 1), 0.03 * fastest);
  for (std::size_t i = 1; i + 1 < motion.size(); ++i) {
    if (motion[i].segment == motion[i + 1].segment) continue;
    EXPECT_LT(speedAt(i), 0.03 * fastest) << i;
    EXPECT_LT(speedAt(i + 1), 0.03 * fastest) << i;
  }
}

TEST_F(Reproduce, SlowLimitsStretchTimeButKeepThePath) {
  ReproduceOptions slow;
  slow.limits = {0.1, 0.2, 0.05, 0.1};
  const Pose object = SyntheticTask::objectAt(0, 0, 0);
  const auto fast = reproduceMotion(model_, object, ReproduceOptions());
  const auto motion = reproduceMotion(model_, object, slow);
  EXPECT_LT(worstSpeed(motion, slow.limits), 1 + 1e-9);
  EXPECT_GT(worstSpeed(motion, slow.limits), 0.95);  // and it is not slower than needed
  EXPECT_GT(motion.back().time, 2 * fast.back().time);
  for (int segment = 0; segment < 3; ++segment) {
    EXPECT_LT(
        poseError(endOf(fast, segment).gripper.inverse() * endOf(motion, segment).gripper).norm(),
        1e-9);
  }
}

TEST_F(Reproduce, MovingTheObjectMovesTheMotion) {
  const Pose object = SyntheticTask::objectAt(0.5, 0.1, 0.2);
  const Pose move(Vec<double, 3>(3, -7, 0), expSO3<double>(Vec<double, 3>(0, 0, 2.4)));
  const Pose2 move2(3, -7, 2.4);
  const auto a = reproduceMotion(model_, object, ReproduceOptions());
  const auto b = reproduceMotion(model_, move * object, ReproduceOptions());
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_LT(poseError((move * a[i].gripper).inverse() * b[i].gripper).norm(), 1e-9);
    EXPECT_LT(poseError((move2 * a[i].base).inverse() * b[i].base).norm(), 1e-9);
  }
}

TEST_F(Reproduce, AGivenGraspIsMetExactly) {
  ReproduceOptions options;
  options.object_T_gripper = SyntheticTask::objectTGripper();
  options.object_T_gripper->translation[0] -= 0.02;
  const Pose object = SyntheticTask::objectAt(0, 2, 0);
  const auto motion = reproduceMotion(model_, object, options);
  EXPECT_LT(
      poseError((object * *options.object_T_gripper).inverse() * endOf(motion, 0).gripper).norm(),
      1e-12);
}

TEST_F(Reproduce, ChainsStartWhereTheOneBeforeEnded) {
  const Pose first = SyntheticTask::objectAt(0, 0, 0);
  const Pose second = SyntheticTask::objectAt(2, 3, 1.8);
  const auto motion = reproduceChain({{model_, first}, {model_, second}}, ReproduceOptions());
  expectAtGrasp(endOf(motion, 0, 0), first);
  expectAtGrasp(endOf(motion, 0, 1), second);
  EXPECT_LT(worstSpeed(motion, ReproduceOptions().limits), 1 + 1e-9);
  const auto alone = reproduceMotion(model_, first, ReproduceOptions());
  ASSERT_GT(motion.size(), alone.size());
  for (std::size_t i = 0; i < alone.size(); ++i) {
    EXPECT_EQ(alone[i].gripper.translation, motion[i].gripper.translation);
  }
  EXPECT_EQ(motion[alone.size()].action, 1);
}

TEST_F(Reproduce, BadOptionsAreRefused) {
  const auto codeOf = [](const MotionModel& model, const ReproduceOptions& options) {
    try {
      reproduceMotion(model, Pose(), options);
    } catch (const Error& e) {
      return e.code();
    }
    return ExitCode::kSuccess;
  };
  ReproduceOptions rate;
  rate.rate = 0;
  ReproduceOptions speed;
  speed.limits.base_speed = -1;
  ReproduceOptions blend;
  blend.blend_share = 1.5;
  ReproduceOptions fine;
  fine.rate = 1e9;
  EXPECT_EQ(codeOf(model_, rate), ExitCode::kUsage);
  EXPECT_EQ(codeOf(model_, speed), ExitCode::kUsage);
  EXPECT_EQ(codeOf(model_, blend), ExitCode::kUsage);
  EXPECT_EQ(codeOf(model_, fine), ExitCode::kResources);
  EXPECT_EQ(codeOf(MotionModel(), ReproduceOptions()), ExitCode::kNoResult);
}

}  // namespace
}  // namespace graft::lfd
