// SPDX-License-Identifier: BSD-3-Clause
// ReachMap::project: a local minimum of the distance to the set, which follows the gripper.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/types_lfd/reach/small_map.hpp"

namespace graft::lfd {
namespace {

using testing::smallMap;
using testing::smallRobotChain;
using testing::uniform;

constexpr double kSigmaT = 0.01;
constexpr double kSigmaR = 0.05;

struct Query {
  Pose gripper;
  Pose2 base;
};

Query makeQuery(std::mt19937_64& random, double away) {
  static const Chain chain = smallRobotChain();
  Query q;
  q.gripper = chain.forward(sampleJoints(chain, random));
  q.base =
      Pose2(uniform(random, -away, away), uniform(random, -away, away), uniform(random, -3.2, 3.2));
  return q;
}

double costBetween(const Pose2& a, const Pose2& b) {
  const double dx = (a.x - b.x) / kSigmaT;
  const double dy = (a.y - b.y) / kSigmaT;
  const double dr = wrapAngle(a.theta - b.theta) / kSigmaR;
  return dx * dx + dy * dy + dr * dr;
}

ProjectedBase project(const Query& q, const BaseFilter* filter = nullptr) {
  return smallMap().project(q.gripper, q.base, kSigmaT, kSigmaR, filter);
}

TEST(ReachProject, NoFurtherThanTheNearestBoxAndInTheSet) {
  std::mt19937_64 random(1);
  int nearer = 0;
  int outside = 0;
  for (int n = 0; n < 500; ++n) {
    const Query q = makeQuery(random, 0.6);
    const NearestBase box = smallMap().nearest(q.gripper, q.base, kSigmaT, kSigmaR);
    const ProjectedBase found = project(q);
    ASSERT_EQ(found.found, box.found);
    ASSERT_EQ(found.inside, box.inside);
    if (!found.found || found.inside) continue;
    ++outside;
    EXPECT_LE(found.cost, box.cost * (1 + 1e-9));
    nearer += found.cost < 0.99 * box.cost ? 1 : 0;
    EXPECT_NEAR(costBetween(found.base, q.base), found.cost, 1e-7 * found.cost);
    EXPECT_GE(smallMap().distance(q.gripper, found.base), smallMap().marginT() - 1e-9);
    // On the border: a step back towards the query leaves the set.
    const double back = 1e-4;
    const Pose2 out(found.base.x + back * (q.base.x - found.base.x),
                    found.base.y + back * (q.base.y - found.base.y),
                    found.base.theta + back * wrapAngle(q.base.theta - found.base.theta));
    EXPECT_LT(smallMap().distance(q.gripper, out), smallMap().marginT());
  }
  EXPECT_GT(outside, 200);
  EXPECT_GT(nearer, outside / 10) << "hardly ever better than the box: nothing was tested";
}

TEST(ReachProject, NothingNearbyIsNearer) {
  std::mt19937_64 random(2);
  int beaten = 0;
  int outside = 0;
  for (int n = 0; n < 200; ++n) {
    const Query q = makeQuery(random, 0.6);
    const ProjectedBase found = project(q);
    if (!found.found || found.inside) continue;
    ++outside;
    bool better = false;
    for (int k = 0; k < 400; ++k) {
      const double reach = k % 2 == 0 ? 0.05 : 0.5;  // of sigma
      const Pose2 other(found.base.x + reach * kSigmaT * uniform(random, -1, 1),
                        found.base.y + reach * kSigmaT * uniform(random, -1, 1),
                        found.base.theta + reach * kSigmaR * uniform(random, -1, 1));
      better = better || (costBetween(other, q.base) < found.cost * (1 - 1e-4) &&
                          smallMap().distance(q.gripper, other) >= smallMap().marginT());
    }
    beaten += better ? 1 : 0;
  }
  // The border has creases at its nodes, where the last few planes may not suffice.
  EXPECT_GT(outside, 100);
  EXPECT_LE(beaten, outside / 20) << beaten << " of " << outside;
}

TEST(ReachProject, SlopesAreThoseOfTheDistance) {
  std::mt19937_64 random(4);
  std::vector<double> errors;
  std::vector<double> slopes;
  const double h = 1e-5;
  for (int n = 0; n < 300; ++n) {
    const Query q = makeQuery(random, 0.4);
    const ProjectedBase found = project(q);
    if (!found.found || found.inside) continue;
    const auto root = [&](double share) {
      Query raised = q;
      raised.gripper.translation[2] += share * h;
      return std::sqrt(project(raised).cost);
    };
    const double numeric = (root(1) - root(-1)) / (2 * h);
    slopes.push_back(std::abs(numeric));
    errors.push_back(std::abs(numeric - found.by_height));
  }
  std::sort(slopes.begin(), slopes.end());
  std::sort(errors.begin(), errors.end());
  ASSERT_GT(errors.size(), 100u);
  // At nodes, and where another part of the set is as near, there is no slope.
  EXPECT_LT(errors[errors.size() / 2], 0.01 * slopes[slopes.size() / 2]);
  EXPECT_LT(errors[errors.size() * 4 / 5], 0.05 * slopes[slopes.size() * 4 / 5]);
}

/// Free where n . (x, y) >= offset.
struct HalfPlane : BaseFilter {
  HalfPlane(double angle, double o) : c(std::cos(angle)), s(std::sin(angle)), offset(o) {}
  bool isFree(const Pose2& b) const override { return c * b.x + s * b.y >= offset; }
  double c;
  double s;
  double offset;
};

TEST(ReachProject, AnObstacleIsLeftByTheShortestWay) {
  std::mt19937_64 random(5);
  int tested = 0;
  for (int n = 0; n < 3000 && tested < 60; ++n) {
    Query q = makeQuery(random, 0.4);
    if (!project(q).inside) continue;
    const double angle = uniform(random, -3, 3);
    const double depth = uniform(random, 0.2, 2);  // in sigma
    const HalfPlane wall(angle,
                         std::cos(angle) * q.base.x + std::sin(angle) * q.base.y + depth * kSigmaT);
    const Pose2 foot(q.base.x + depth * kSigmaT * std::cos(angle),
                     q.base.y + depth * kSigmaT * std::sin(angle), q.base.theta);
    if (smallMap().distance(q.gripper, foot) < smallMap().marginT() + 0.02) continue;
    ++tested;
    const ProjectedBase found = project(q, &wall);
    ASSERT_TRUE(found.found);
    EXPECT_TRUE(found.at_obstacle);
    EXPECT_TRUE(wall.isFree(found.base));
    EXPECT_EQ(found.by_height, 0);
    EXPECT_NEAR(std::sqrt(found.cost), depth, 1e-3 * depth);
  }
  EXPECT_EQ(tested, 60);
}

}  // namespace
}  // namespace graft::lfd
