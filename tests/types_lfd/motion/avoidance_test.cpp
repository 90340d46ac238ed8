// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/motion/avoidance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/error.hpp"

namespace graft::lfd {
namespace {

using Vec2 = Vec<double, 2>;

/// Ellipse (x/a)^2 + (y/b)^2 = 1 by its implicit function, which is not the
/// distance but has the same zero and sign.
class Ellipse : public ClearanceField {
 public:
  Ellipse(double a, double b) : a_(a), b_(b) {}
  double clearance(double x, double y) const override {
    return (std::hypot(x / a_, y / b_) - 1) * std::min(a_, b_);
  }
  Vec2 gradient(double x, double y) const override {
    const double r = std::hypot(x / a_, y / b_);
    return Vec2(x / (a_ * a_), y / (b_ * b_)) * (std::min(a_, b_) / r);
  }

 private:
  double a_;
  double b_;
};

/// Clearance for which Gamma = (r / a)^2: the modulation is then, with rho = 1,
/// the potential flow around a cylinder.
class Cylinder : public ClearanceField {
 public:
  explicit Cylinder(double radius) : radius_(radius) {}
  double clearance(double x, double y) const override {
    return (x * x + y * y) / (radius_ * radius_) - 1;
  }
  Vec2 gradient(double x, double y) const override {
    return Vec2(2 * x, 2 * y) / (radius_ * radius_);
  }

 private:
  double radius_;
};

AvoidanceOptions plain() {
  AvoidanceOptions o;
  o.safety = 0;
  o.release_when_leaving = false;
  return o;
}

TEST(Modulation, IsThePotentialFlowAroundACylinder) {
  AvoidanceOptions options = plain();
  options.reference_distance = 1;
  options.reactivity = 1;
  const double a = 0.7;
  const Cylinder field(a);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(-3.1, 3.1);
  std::uniform_real_distribution<double> radius(a, 4);
  for (int i = 0; i < 1000; ++i) {
    const double r = radius(random);
    const double phi = angle(random);
    const Vec2 v =
        modulateVelocity(field, Vec2(r * std::cos(phi), r * std::sin(phi)), Vec2(1, 0), options);
    const double radial = (1 - a * a / (r * r)) * std::cos(phi);
    const double around = -(1 + a * a / (r * r)) * std::sin(phi);
    EXPECT_NEAR(v[0], radial * std::cos(phi) - around * std::sin(phi), 1e-12);
    EXPECT_NEAR(v[1], radial * std::sin(phi) + around * std::cos(phi), 1e-12);
  }
}

TEST(Modulation, NeverEntersFromAHundredThousandStarts) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> angle(-3.14159265358979323846, 3.14159265358979323846);
  std::uniform_real_distribution<double> distance(1e-6, 1.5);
  for (const double b : {1.0, 0.4}) {  // a circle and an ellipse
    const Ellipse field(1.0, b);
    double least = 1;
    for (int i = 0; i < 50000; ++i) {
      const double phi = angle(random);
      const double scale = 1 + distance(random);
      Vec2 x(scale * std::cos(phi), scale * b * std::sin(phi));
      // Towards a point inside, as hard as it gets.
      const Vec2 goal(0.5 * std::cos(angle(random)), 0.5 * b * std::sin(angle(random)));
      AvoidanceOptions options = plain();
      options.release_when_leaving = i % 2 == 0;
      for (int step = 0; step < 40; ++step) {
        const Vec2 v = modulateVelocity(field, x, (goal - x).normalized(), options);
        x += 0.05 * v;
        least = std::min(least, field.clearance(x[0], x[1]));
      }
    }
    EXPECT_GT(least, 0) << b;
  }
}

TEST(Modulation, LeadsAroundAndReachesTheGoalBehind) {
  const Ellipse field(1.0, 0.4);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> side(0.05, 1.5);
  for (int i = 0; i < 50; ++i) {
    Vec2 x(-3, i % 2 == 0 ? side(random) : -side(random));
    const Vec2 goal(3, 0.1);
    for (int step = 0; step < 4000 && (x - goal).norm() > 0.02; ++step) {
      const Vec2 to_goal = goal - x;
      const Vec2 f = to_goal * std::min(1.0, 0.5 / to_goal.norm());
      x += 0.02 * modulateVelocity(field, x, f, AvoidanceOptions());
    }
    EXPECT_LT((x - goal).norm(), 0.021);
  }
}

TEST(Modulation, LeavesAVelocityAloneThatLeadsAwayOrIsFar) {
  const Ellipse field(1, 1);
  AvoidanceOptions options;
  EXPECT_EQ(modulateVelocity(field, Vec2(1.1, 0), Vec2(0.3, 0.1), options), Vec2(0.3, 0.1));
  options.release_when_leaving = false;
  EXPECT_LT((modulateVelocity(field, Vec2(1e4, 0), Vec2(-1, 1), options) - Vec2(-1, 1)).norm(),
            1e-8);
  // Inside, inward becomes outward.
  EXPECT_GT(modulateVelocity(field, Vec2(0.9, 0), Vec2(-1, 0), options)[0], 0);
}

TEST(Modulation, DefaultGradientIsThatOfTheClearance) {
  const Ellipse exact(1, 0.5);
  const FunctionField field([&](double x, double y) { return exact.clearance(x, y); }, 1e-4);
  EXPECT_LT((field.gradient(1.2, 0.4) - exact.gradient(1.2, 0.4)).norm(), 1e-7);
}

/// A base that drives 4 m along x in 16 s, in two segments; the gripper is ahead.
std::vector<MotionPoint> straightDrive() {
  std::vector<MotionPoint> motion;
  for (int i = 0; i <= 800; ++i) {
    MotionPoint p;
    p.time = i / 50.0;
    p.base = Pose2(-2 + 4.0 * i / 800, 0.05, 0.001 * i);
    p.gripper.translation = Vec<double, 3>(p.base.x + 0.7, 0.05, 1);
    p.segment = i <= 300 ? 0 : 1;
    motion.push_back(p);
  }
  return motion;
}

TEST(AvoidObstacles, WithoutObstaclesNothingChanges) {
  const FunctionField nothing([](double, double) { return 100.0; });
  const auto motion = straightDrive();
  AvoidanceReport report;
  const auto result = avoidObstacles(motion, nothing, AvoidanceOptions(), &report);
  ASSERT_EQ(result.size(), motion.size());
  for (std::size_t i = 0; i < motion.size(); ++i) {
    EXPECT_NEAR(result[i].base.x, motion[i].base.x, 1e-12);
    EXPECT_NEAR(result[i].base.y, motion[i].base.y, 1e-12);
    EXPECT_NEAR(result[i].time, motion[i].time, 1e-12);
    EXPECT_EQ(result[i].segment, motion[i].segment);
  }
  EXPECT_LT(report.largest_deviation, 1e-12);
  EXPECT_EQ(report.stalled + report.inside, 0);
}

TEST(AvoidObstacles, DrivesAroundAndComesBack) {
  const Ellipse field(0.5, 0.3);
  const auto motion = straightDrive();
  AvoidanceOptions options;
  AvoidanceReport report;
  const auto result = avoidObstacles(motion, field, options, &report);
  EXPECT_GE(report.least_clearance, options.safety);
  EXPECT_EQ(report.inside, 0);
  EXPECT_GT(report.largest_deviation, 0.2);  // the reference goes through the middle
  EXPECT_LT(report.final_deviation, options.largest_lag);
  bool kept_segment_end = false;
  for (std::size_t i = 1; i < result.size(); ++i) {
    const Pose2& a = result[i - 1].base;
    const Pose2& b = result[i].base;
    const double dt = result[i].time - result[i - 1].time;
    EXPECT_NEAR(dt, 0.02, 1e-9);
    EXPECT_LT(std::hypot(b.x - a.x, b.y - a.y), options.base_speed * dt * (1 + 1e-9));
    kept_segment_end |=
        (result[i].gripper.translation - motion[300].gripper.translation).norm() == 0;
  }
  EXPECT_TRUE(kept_segment_end);
  EXPECT_EQ(result.back().gripper.translation, motion.back().gripper.translation);
}

TEST(AvoidObstacles, AWallIsReportedNotCrossed) {
  const FunctionField wall([](double x, double) { return 0.5 - x; });
  AvoidanceReport report;
  AvoidanceOptions options;
  const auto result = avoidObstacles(straightDrive(), wall, options, &report);
  EXPECT_GE(report.least_clearance, options.safety - 1e-12);
  EXPECT_NEAR(report.final_deviation, 1.5 + options.safety, 0.02);
  EXPECT_GT(report.stalled, 0);
  EXPECT_LT(result.back().time, 5 * 16.0 + 10);
}

TEST(AvoidObstacles, BadOptionsAreRefused) {
  const FunctionField nothing([](double, double) { return 1.0; });
  AvoidanceOptions options;
  options.reactivity = 0;
  EXPECT_THROW(avoidObstacles(straightDrive(), nothing, options), Error);
  options = AvoidanceOptions();
  options.slowest = 0.5;
  EXPECT_THROW(avoidObstacles(straightDrive(), nothing, options), Error);
  EXPECT_TRUE(avoidObstacles({}, nothing, AvoidanceOptions()).empty());
}

}  // namespace
}  // namespace graft::lfd
