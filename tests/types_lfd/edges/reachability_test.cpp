// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/types_lfd/reach/small_map.hpp"
#include "types_lfd/edges/reachability_edge.hpp"

namespace graft::lfd {
namespace {

using testing::smallMap;
using testing::smallRobotChain;
using testing::uniform;

constexpr double kSigmaT = 0.01;
constexpr double kSigmaR = 0.05;

/// The gradient of E9's cost, with the base chosen anew wherever it is evaluated.
TEST(ReachabilityEdge, GradientIsThatOfTheCostWithBasesChosenAnew) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(6);
  const FreeSpace space;
  const auto made = [&](const double* association) {
    ReachabilityEdge edge;
    edge.resources = {&smallMap(), &space};
    edge.association = association;
    return edge;
  };
  Eigen::MatrixXd information =
      Eigen::Vector3d(1 / (kSigmaT * kSigmaT), 1 / (kSigmaT * kSigmaT), 1 / (kSigmaR * kSigmaR))
          .asDiagonal();
  const InformationBlock omega(information.data(), 3, 3);
  const auto costAt = [&](const Pose& gripper, const Pose2& base, double* association) {
    made(nullptr).associate(true, gripper, BasePose<>(base), omega, association);
    const Vec<double, 3> e = made(association).error(gripper, BasePose<>(base));
    return e.dot(information * e);
  };
  const double h = 1e-6;
  int good = 0;
  int all = 0;
  for (int n = 0; n < 400 && all < 100; ++n) {
    const Pose gripper = chain.forward(sampleJoints(chain, random));
    const Pose2 base(uniform(random, -0.4, 0.4), uniform(random, -0.4, 0.4),
                     uniform(random, -3.2, 3.2));
    const double up = (gripper.rotation * Vec<double, 3>(1, 0, 0))[2];
    const ProjectedBase found = smallMap().project(gripper, base, kSigmaT, kSigmaR);
    if (!found.found || found.inside || std::abs(up) > 0.9) continue;
    ++all;
    double association[17] = {};
    const double cost = costAt(gripper, base, association);
    EXPECT_NEAR(cost, found.cost, 1e-6 * cost);
    // By the association at hand, and with it chosen anew; a gripper turned and moved.
    double largest = 0;
    double difference = 0;
    for (int k = 0; k < 9; ++k) {
      const auto moved = [&](double share, bool anew) {
        Pose g = gripper;
        Pose2 b = base;
        Vec<double, 3> turn(0, 0, 0);
        if (k < 3) g.translation[k] += share * h;
        if (k >= 3 && k < 6) turn[k - 3] = share * h;
        g.rotation = gripper.rotation * expSO3<double>(turn);
        if (k == 6) b.x += share * h;
        if (k == 7) b.y += share * h;
        if (k == 8) b.theta += share * h;
        double other[17] = {};
        if (anew) return costAt(g, b, other);
        const Vec<double, 3> e = made(association).error(g, BasePose<>(b));
        return e.dot(information * e);
      };
      const double held = (moved(1, false) - moved(-1, false)) / (2 * h);
      const double chosen = (moved(1, true) - moved(-1, true)) / (2 * h);
      largest = std::max(largest, std::abs(chosen));
      difference = std::max(difference, std::abs(held - chosen));
    }
    good += difference < 0.05 * largest ? 1 : 0;
  }
  EXPECT_GE(all, 100);
  // At nodes, and where another part of the set is as near, there is no gradient.
  EXPECT_GE(good, 8 * all / 10) << good << " of " << all;
}

}  // namespace
}  // namespace graft::lfd
