// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/furniture.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace graft::lfd {
namespace {

TEST(Furniture, SwivelTurnsAboutItsHinge) {
  Furniture f;
  f.kind = Furniture::Kind::kSwivel;
  f.standoff = 0.03;
  f.radius = 0.35;
  f.height = 0.9;
  f.travel = 1.4;
  for (const double opening : {0.0, 0.3, 1.0}) {
    const Pose handle = f.handle(opening, 0);
    EXPECT_NEAR(handle.translation.head<2>().norm(), std::hypot(0.03, 0.35), 1e-12);
    EXPECT_NEAR(handle.translation.z(), 0.9, 1e-12);
    EXPECT_LT((logSO3(handle.rotation) - Eigen::Vector3d(0, 0, 1.4 * opening)).norm(), 1e-12);
  }
  EXPECT_LT(f.handle(1, 0).translation.x(), f.handle(0, 0).translation.x());  // towards the person
}

TEST(Furniture, LeverTurnsAboutItsAxisAndPressesDown) {
  Furniture f;
  f.kind = Furniture::Kind::kDoor;
  f.standoff = 0.06;
  f.radius = 0.72;
  f.height = 1;
  f.travel = -1.3;
  f.lever_arm = 0.07;
  f.lever_press = 0.6;
  EXPECT_LT((f.handle(0, 0).translation - Eigen::Vector3d(-0.06, 0.72, 1)).norm(), 1e-12);
  const Eigen::Vector3d axis(-0.06, 0.79, 1);
  for (const double press : {0.0, 0.4, 1.0}) {
    const Pose handle = f.handle(0, press);
    EXPECT_NEAR((handle.translation - axis).norm(), 0.07, 1e-12);
    EXPECT_NEAR(handle.translation.z(), 1 - 0.07 * std::sin(0.6 * press), 1e-12);
    EXPECT_NEAR(rotationAngle(handle.rotation), 0.6 * press, 1e-12);
  }
  EXPECT_GT(f.handle(1, 0).translation.x(), 0.5);  // away from the person
}

TEST(Furniture, SliderKeepsItsOrientation) {
  Furniture f;
  f.kind = Furniture::Kind::kSlider;
  f.height = 0.7;
  f.travel = 0.3;
  f.direction = -Eigen::Vector3d::UnitX();
  const Eigen::Vector3d moved = f.handle(0.5, 0).translation - f.handle(0, 0).translation;
  EXPECT_LT((moved - Eigen::Vector3d(-0.15, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(f.handle(0.5, 0).rotation.w(), 1);
}

}  // namespace
}  // namespace graft::lfd
