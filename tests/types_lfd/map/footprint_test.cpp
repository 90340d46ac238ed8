// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/map/footprint.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "tests/types_lfd/map/random_map.hpp"

namespace graft::lfd {
namespace {

using testing::randomMap;
using testing::uniform;

const double kPi = std::acos(-1.0);

/// A star-shaped (often concave) polygon around a point near the base.
Polygon randomPolygon(std::mt19937_64& random, double size) {
  const int corners = 3 + static_cast<int>(random() % 7);
  const Eigen::Vector2d center(uniform(random, -size, size), uniform(random, -size, size));
  Polygon polygon;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * kPi * (i + uniform(random, 0.1, 0.9)) / corners;
    const double radius = uniform(random, 0.2, 1) * size;
    polygon.emplace_back(center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  if (random() % 2 == 0) std::reverse(polygon.begin(), polygon.end());
  return polygon;
}

/// Whether a sampled point lies in both the placed polygon and an occupied
/// square, and the least distance of a sampled border point from a square.
struct Sampled {
  bool overlap = false;
  double gap = std::numeric_limits<double>::infinity();
};

bool insideByWinding(const Polygon& polygon, const Eigen::Vector2d& p) {
  double turn = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d a = polygon[i] - p;
    const Eigen::Vector2d b = polygon[(i + 1) % polygon.size()] - p;
    turn += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  return std::abs(turn) > kPi;
}

Sampled sample(const OccupancyMap& map, const Polygon& footprint, const Pose2& base) {
  Sampled result;
  Polygon placed;
  for (const Eigen::Vector2d& corner : footprint) placed.push_back(base * corner);
  constexpr int kPerEdge = 60;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    for (int k = 0; k < kPerEdge; ++k) {
      const Eigen::Vector2d p =
          placed[i] + k / double(kPerEdge) * (placed[(i + 1) % placed.size()] - placed[i]);
      if (map.occupied(p.x(), p.y())) result.overlap = true;
      result.gap = std::min(result.gap, map.clearance(p.x(), p.y()));
    }
  }
  for (int row = 0; row < map.height(); ++row) {
    for (int column = 0; column < map.width(); ++column) {
      if (map.cell(column, row) != Cell::kOccupied) continue;
      for (int k = 0; k < 25; ++k) {
        const Eigen::Vector2d p =
            map.origin() * Eigen::Vector2d((column + (k % 5) / 4.0) * map.resolution(),
                                           (row + (k / 5) / 4.0) * map.resolution());
        if (insideByWinding(placed, p)) result.overlap = true;
      }
    }
  }
  return result;
}

TEST(FootprintChecker, EqualsDenseSampling) {
  std::mt19937_64 random(1);
  int hits = 0;
  int misses = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const OccupancyMap map = randomMap(random, trial % 2 == 0 ? 0.01 : 0.08, 16);
    const double extent = map.resolution() * std::max(map.width(), map.height());
    const Polygon polygon = randomPolygon(random, uniform(random, 0.5, 4) * map.resolution());
    const FootprintChecker checker(map, polygon);
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector2d at =
          map.origin() *
          Eigen::Vector2d(uniform(random, -0.2, 1.2) * extent, uniform(random, -0.2, 1.2) * extent);
      const Pose2 base(at.x(), at.y(), uniform(random, -4, 4));
      const Sampled truth = sample(map, polygon, base);
      const bool found = checker.inCollision(base);
      EXPECT_LE(checker.clearanceLowerBound(base), truth.gap + 1e-9);
      if (truth.overlap) {
        ASSERT_TRUE(found);
        EXPECT_EQ(checker.clearanceLowerBound(base), 0);
        ++hits;
      } else if (found) {
        // What sampling missed can only be a grazing contact.
        ASSERT_LT(truth.gap, 0.2 * map.resolution());
      } else {
        ++misses;
      }
    }
  }
  EXPECT_GT(hits, 300);
  EXPECT_GT(misses, 300);
}

/// Squares on a grid whose corners hit the polygon exactly: closed sets touch.
TEST(FootprintChecker, KnowsContainmentAndTouch) {
  std::vector<Cell> cells(49, Cell::kFree);
  cells[3 * 7 + 3] = Cell::kOccupied;  // the square [3, 4] x [3, 4]
  const OccupancyMap map(7, 7, 1, Pose2(), cells);
  const FootprintChecker around(map, {{-3, -3}, {3, -3}, {3, 3}, {-3, 3}});
  EXPECT_TRUE(around.inCollision(Pose2(3.5, 3.5, 0.3)));
  const FootprintChecker within(map, {{-.1, -.1}, {.1, -.1}, {.1, .1}, {-.1, .1}});
  EXPECT_TRUE(within.inCollision(Pose2(3.5, 3.5, 0.3)));
  const FootprintChecker unit(map, {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  for (int x = 0; x < 7; ++x) {
    for (int y = 0; y < 7; ++y) {
      const bool touches = x >= 2 && x <= 4 && y >= 2 && y <= 4;
      EXPECT_EQ(unit.inCollision(Pose2(x, y, 0)), touches) << x << ' ' << y;
      const bool overlaps = x + 0.5 > 2.4 && x < 4.4 && y + 0.5 > 2.4 && y < 4.4;
      EXPECT_EQ(unit.inCollision(Pose2(x + 0.5, y + 0.5, 0)),
                overlaps && x >= 2 && x <= 3 && y >= 2 && y <= 3)
          << x << ' ' << y;
    }
  }
}

TEST(FootprintChecker, SeesIntoConcavePolygons) {
  std::vector<Cell> cells(49, Cell::kFree);
  cells[3 * 7 + 3] = Cell::kOccupied;
  const OccupancyMap map(7, 7, 1, Pose2(), cells);
  // A U open to the top around the square without touching it.
  const Polygon u = {{-3, -3}, {3, -3}, {3, 3}, {1, 3}, {1, -1}, {-1, -1}, {-1, 3}, {-3, 3}};
  const FootprintChecker checker(map, u);
  EXPECT_FALSE(checker.inCollision(Pose2(3.5, 3.5, 0)));
  EXPECT_TRUE(checker.inCollision(Pose2(3.5 + 0.6, 3.5, 0)));
  EXPECT_TRUE(checker.inCollision(Pose2(3.5, 3.5 + 0.6, 0)));
  EXPECT_FALSE(checker.inCollision(Pose2(3.5, 3.5 - 0.6, 0)));
  EXPECT_FALSE(checker.inCollision(Pose2(3.5, 3.5, 0.3)));
}

TEST(FootprintChecker, PathSeesWhatStandsBetween) {
  std::vector<Cell> cells(100 * 20, Cell::kFree);
  for (int row = 0; row < 9; ++row) cells[row * 100 + 50] = Cell::kOccupied;
  const OccupancyMap map(100, 20, 0.05, Pose2(), cells);
  const FootprintChecker checker(map, {{.1, .1}, {-.1, .1}, {-.1, -.1}, {.1, -.1}});
  EXPECT_FALSE(checker.pathFree(Pose2(1, 0.3, 0), Pose2(4, 0.3, 0)));
  EXPECT_TRUE(checker.pathFree(Pose2(1, 0.7, 0), Pose2(4, 0.7, 0)));
  EXPECT_TRUE(checker.pathFree(Pose2(1, 0.3, 0), Pose2(1, 0.3, 0)));
  EXPECT_FALSE(checker.pathFree(Pose2(2.52, 0.3, 0), Pose2(2.52, 0.3, 0)));
  // A long arm that sweeps across the wall while both ends are free of it.
  const FootprintChecker arm(map, {{0, -.01}, {.6, -.01}, {.6, .01}, {0, .01}});
  EXPECT_FALSE(arm.inCollision(Pose2(2.3, 0.3, kPi / 2)));
  EXPECT_FALSE(arm.inCollision(Pose2(2.3, 0.3, -kPi / 2)));
  EXPECT_FALSE(arm.pathFree(Pose2(2.3, 0.3, 1.5), Pose2(2.3, 0.3, -1.5)));
  // The shorter way from 170 to -170 degrees leads away from the wall.
  EXPECT_TRUE(arm.pathFree(Pose2(2.3, 0.3, 2.96), Pose2(2.3, 0.3, -2.96)));
}

TEST(FootprintChecker, RefusesPolygonsThatAreNotSimple) {
  const OccupancyMap map;
  const double nan = std::nan("");
  const Polygon bad[] = {{},
                         {{0, 0}, {1, 0}},
                         {{0, 0}, {1, 1}, {1, 0}, {0, 1}},
                         {{0, 0}, {1, 0}, {2, 0}},
                         {{0, 0}, {1, 0}, {1, 0}, {0, 1}},
                         {{0, 0}, {2, 0}, {1, 0}, {1, 1}},
                         {{0, 0}, {1, 0}, {nan, 1}}};
  for (const Polygon& polygon : bad) {
    try {
      FootprintChecker checker(map, polygon);
      ADD_FAILURE() << "accepted a polygon of " << polygon.size() << " corners";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      EXPECT_EQ(std::string(error.what()).rfind("footprint: ", 0), 0u) << error.what();
    }
  }
  EXPECT_FALSE(FootprintChecker(map, {{0, 0}, {1, 0}, {1, 1}}).inCollision(Pose2()));
}

// Timed for the record only; nothing is asserted of it.
TEST(FootprintChecker, ReportsItsSpeed) {
  std::vector<Cell> cells(240 * 240, Cell::kFree);
  for (int i = 0; i < 240; ++i) cells[120 * 240 + i] = Cell::kOccupied;
  const OccupancyMap map(240, 240, 0.05, Pose2(-6, -6, 0.1), cells);
  const FootprintChecker checker(map, {{.334, .334}, {-.334, .334}, {-.334, -.334}, {.334, -.334}});
  std::mt19937_64 random(5);
  std::vector<Pose2> poses;
  for (int i = 0; i < 20000; ++i) {
    poses.emplace_back(uniform(random, -5, 5), uniform(random, -5, 5), uniform(random, -4, 4));
  }
  const auto start = std::chrono::steady_clock::now();
  int hits = 0;
  for (const Pose2& pose : poses) hits += checker.inCollision(pose);
  const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - start;
  EXPECT_GT(hits, 0);
  RecordProperty("nanoseconds_per_query", static_cast<int>(1000 * spent.count() / poses.size()));
}

}  // namespace
}  // namespace graft::lfd
