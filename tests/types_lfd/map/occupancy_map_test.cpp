// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/map/occupancy_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/types_lfd/map/random_map.hpp"
#include "types_lfd/map/distance_transform.hpp"

namespace graft::lfd {
namespace {

using testing::randomMap;
using testing::uniform;

/// A point on or around the map, in the world.
Eigen::Vector2d randomPoint(std::mt19937_64& random, const OccupancyMap& map, double margin) {
  const double r = map.resolution();
  return map.origin() * Eigen::Vector2d(uniform(random, -margin, map.width() + margin) * r,
                                        uniform(random, -margin, map.height() + margin) * r);
}

double bruteClearance(const OccupancyMap& map, const Eigen::Vector2d& world) {
  const Eigen::Vector2d p = map.toGrid(world.x(), world.y());
  double best = std::numeric_limits<double>::infinity();
  for (int row = 0; row < map.height(); ++row) {
    for (int column = 0; column < map.width(); ++column) {
      if (map.cell(column, row) != Cell::kOccupied) continue;
      const double dx = std::max({column - p.x(), p.x() - column - 1, 0.0});
      const double dy = std::max({row - p.y(), p.y() - row - 1, 0.0});
      best = std::min(best, std::hypot(dx, dy));
    }
  }
  return best * map.resolution();
}

TEST(DistanceTransform, EqualsBruteForce) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 60; ++trial) {
    const int width = 1 + static_cast<int>(random() % 30);
    const int height = 1 + static_cast<int>(random() % 30);
    const double share = trial % 3 == 0 ? 0.005 : trial % 3 == 1 ? 0.05 : 0.5;
    std::vector<bool> marked(static_cast<std::size_t>(width) * height);
    for (std::size_t i = 0; i < marked.size(); ++i) marked[i] = uniform(random, 0, 1) < share;
    const std::vector<std::int32_t> squared = squaredDistances(marked, width, height);
    for (int i = 0; i < width * height; ++i) {
      std::int32_t best = kNoDistance;
      for (int j = 0; j < width * height; ++j) {
        if (!marked[j]) continue;
        const int dx = i % width - j % width;
        const int dy = i / width - j / width;
        best = std::min(best, dx * dx + dy * dy);
      }
      ASSERT_EQ(squared[i], best) << trial << ' ' << i;
    }
  }
}

TEST(OccupancyMap, ClearanceEqualsBruteForceAndLiesWithinItsBounds) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 60; ++trial) {
    const OccupancyMap map = randomMap(random, trial % 2 == 0 ? 0.02 : 0.3, 25);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector2d p = randomPoint(random, map, i % 4 == 0 ? 10 : 0);
      const double truth = bruteClearance(map, p);
      const double found = map.clearance(p.x(), p.y());
      if (std::isinf(truth)) {
        ASSERT_EQ(found, truth);
        continue;
      }
      ASSERT_NEAR(found, truth, 1e-12);
      const OccupancyMap::Bounds bounds = map.clearanceBounds(p.x(), p.y());
      ASSERT_LE(bounds.low, truth + 1e-12);
      ASSERT_GE(bounds.high, truth - 1e-12);
      if (map.inside(p.x(), p.y())) {
        ASSERT_LT(bounds.high - bounds.low, 2.7 * map.resolution());
      }
    }
  }
}

TEST(OccupancyMap, OriginTurnsTheGrid) {
  std::vector<Cell> cells(6, Cell::kFree);
  cells[2] = Cell::kOccupied;  // column 2, row 0 of 3 x 2
  cells[4] = Cell::kUnknown;   // column 1, row 1
  const OccupancyMap map(3, 2, 0.5, Pose2(10, 20, std::acos(-1.0) / 2), cells);
  // Turned by 90 degrees: columns go along world y, rows along world -x.
  EXPECT_TRUE(map.occupied(10 - 0.25, 20 + 1.25));
  EXPECT_FALSE(map.occupied(10 + 0.25, 20 + 1.25));
  EXPECT_TRUE(map.unknown(10 - 0.75, 20 + 0.75));
  EXPECT_FALSE(map.occupied(10 - 0.75, 20 + 0.75));
  EXPECT_TRUE(map.inside(10 - 0.99, 20 + 1.49));
  EXPECT_FALSE(map.inside(10 - 1.01, 20 + 1.49));
  EXPECT_NEAR(map.cellCenter(2, 0).x(), 9.75, 1e-12);
  EXPECT_NEAR(map.cellCenter(2, 0).y(), 21.25, 1e-12);
  EXPECT_NEAR(map.clearance(9.75, 20.5), 0.5, 1e-12);
}

TEST(OccupancyMap, WhatIsNotOnTheMapIsFree) {
  const OccupancyMap map(2, 2, 1, Pose2(), std::vector<Cell>(4, Cell::kOccupied));
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(map.occupied(0, 0));
  for (const double far : {-1e-9, 2.0, 1e30, -1e30, inf, std::nan("")}) {
    EXPECT_FALSE(map.occupied(far, 1)) << far;
    EXPECT_FALSE(map.inside(far, 1)) << far;
    EXPECT_FALSE(map.unknown(1, far)) << far;
  }
  EXPECT_TRUE(map.segmentFree({-1, -1}, {-1, 5}));
  const OccupancyMap nothing;
  EXPECT_FALSE(nothing.occupied(0, 0));
  EXPECT_TRUE(nothing.segmentFree({0, 0}, {1, 1}));
  EXPECT_EQ(nothing.clearance(0, 0), inf);
}

TEST(OccupancyMap, RefusesSizesThatDisagree) {
  EXPECT_THROW(OccupancyMap(2, 2, 1, Pose2(), std::vector<Cell>(3)), Error);
  EXPECT_THROW(OccupancyMap(0, 2, 1, Pose2(), {}), Error);
  EXPECT_THROW(OccupancyMap(1, 1, 0, Pose2(), std::vector<Cell>(1)), Error);
  EXPECT_THROW(OccupancyMap(1, 1, std::nan(""), Pose2(), std::vector<Cell>(1)), Error);
}

/// Length of the part of segment p-q within a closed unit cell shrunk by
/// `margin`: an independent test by half-plane clipping.
bool passesCell(const Eigen::Vector2d& p, const Eigen::Vector2d& q, int column, int row,
                double margin) {
  double enter = 0;
  double leave = 1;
  const double low[2] = {column + margin, row + margin};
  for (int k = 0; k < 2; ++k) {
    const double high = low[k] + 1 - 2 * margin;
    const double d = q[k] - p[k];
    if (d == 0) {
      if (p[k] < low[k] || p[k] > high) return false;
      continue;
    }
    const double a = (low[k] - p[k]) / d;
    const double b = (high - p[k]) / d;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

TEST(OccupancyMap, SegmentFreeEqualsBruteForce) {
  std::mt19937_64 random(3);
  int free = 0;
  int blocked = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const OccupancyMap map = randomMap(random, 0.03, 25);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector2d a = randomPoint(random, map, 5);
      const Eigen::Vector2d b = i % 10 == 0 ? a : randomPoint(random, map, 5);
      bool touches = false;
      bool surely = false;
      for (int row = 0; row < map.height(); ++row) {
        for (int column = 0; column < map.width(); ++column) {
          if (map.cell(column, row) != Cell::kOccupied) continue;
          const Eigen::Vector2d p = map.toGrid(a.x(), a.y());
          const Eigen::Vector2d q = map.toGrid(b.x(), b.y());
          touches = touches || passesCell(p, q, column, row, -1e-9);
          surely = surely || passesCell(p, q, column, row, 1e-9);
        }
      }
      if (touches != surely) continue;  // along a border, to rounding
      ASSERT_EQ(map.segmentFree(a, b), !surely);
      ASSERT_EQ(map.segmentFree(b, a), !surely);
      ++(surely ? blocked : free);
    }
  }
  EXPECT_GT(free, 1000);
  EXPECT_GT(blocked, 1000);
}

TEST(OccupancyMap, SegmentThroughACornerTouchesAllFourCells) {
  for (int occupied = 0; occupied < 4; ++occupied) {
    std::vector<Cell> cells(4, Cell::kFree);
    cells[occupied] = Cell::kOccupied;
    const OccupancyMap map(2, 2, 1, Pose2(), cells);
    EXPECT_FALSE(map.segmentFree({0.5, 0.5}, {1.5, 1.5})) << occupied;
    EXPECT_FALSE(map.segmentFree({1.5, 0.5}, {0.5, 1.5})) << occupied;
  }
}

}  // namespace
}  // namespace graft::lfd
