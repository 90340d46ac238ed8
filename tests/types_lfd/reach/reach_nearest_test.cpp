// SPDX-License-Identifier: BSD-3-Clause
// ReachMap::nearest against a search through all cells.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/types_lfd/reach/small_map.hpp"

namespace graft::lfd {
namespace {

using testing::smallMap;
using testing::smallRobotChain;
using testing::uniform;

struct Query {
  Pose gripper;
  Pose2 base;
};

Query makeQuery(const Chain& chain, std::mt19937_64& random, double away) {
  Query q;
  q.gripper = chain.forward(sampleJoints(chain, random));
  q.base =
      Pose2(uniform(random, -away, away), uniform(random, -away, away), uniform(random, -3.2, 3.2));
  return q;
}

double square(double x) { return x * x; }

/// All filled cells of the query's slice, each with its nearest point.
NearestBase bruteForce(const ReachMap& map, const Query& query, double sigma_t, double sigma_r,
                       const BaseFilter* filter) {
  const ReachGrid& g = map.grid();
  const GripperView view = g.view(query.gripper);
  const Pose2 base = baseInView(view, query.base);
  NearestBase best;
  best.cost = std::numeric_limits<double>::infinity();
  const int z = g.heightBin(view.position[2]);
  if (z < 0 || z >= g.nz) return best;
  const std::size_t offset = g.slice(z, view.tilt) * g.sliceSize();
  const auto filled = [&](int p, int y, int x) {
    if (x < 0 || y < 0 || x >= g.nx || y >= g.ny) return false;
    p = (p + g.turn) % g.turn;
    const auto cell = (static_cast<std::size_t>(p) * static_cast<std::size_t>(g.ny) +
                       static_cast<std::size_t>(y)) *
                          static_cast<std::size_t>(g.nx) +
                      static_cast<std::size_t>(x);
    return map.cells()[offset + cell] != 0;
  };
  const double mt = map.marginT();
  const double mr = map.marginR();
  for (int p = 0; p < g.turn; ++p) {
    for (int y = 0; y < g.ny; ++y) {
      for (int x = 0; x < g.nx; ++x) {
        if (!filled(p, y, x)) continue;
        const double x_low = (g.x0 + x) * g.resolution + (filled(p, y, x - 1) ? 0 : mt);
        const double x_high = (g.x0 + x + 1) * g.resolution - (filled(p, y, x + 1) ? 0 : mt);
        const double y_low = (g.y0 + y) * g.resolution + (filled(p, y - 1, x) ? 0 : mt);
        const double y_high = (g.y0 + y + 1) * g.resolution - (filled(p, y + 1, x) ? 0 : mt);
        const double a_low = (p - 0.5) * g.step() + (filled(p - 1, y, x) ? 0 : mr);
        const double a_high = (p + 0.5) * g.step() - (filled(p + 1, y, x) ? 0 : mr);
        const double px = std::clamp(base.x, x_low, x_high);
        const double py = std::clamp(base.y, y_low, y_high);
        // The same angle in all turns around the interval.
        double pa = 0;
        double da = std::numeric_limits<double>::infinity();
        for (int turn = -2; turn <= 2; ++turn) {
          const double a = base.theta + turn * 2 * M_PI;
          const double nearest = std::clamp(a, a_low, a_high);
          if (std::abs(nearest - a) < std::abs(da)) {
            da = nearest - a;
            pa = nearest;
          }
        }
        const double cost =
            (square(px - base.x) + square(py - base.y)) / square(sigma_t) + square(da / sigma_r);
        if (cost >= best.cost) continue;
        const Pose2 point = baseInWorld(view, Pose2(px, py, pa));
        if (filter != nullptr && !filter->isFree(point)) continue;
        best.found = true;
        best.cost = cost;
        best.base = point;
      }
    }
  }
  best.inside = best.found && best.cost == 0;
  return best;
}

void compare(const ReachMap& map, double sigma_t, double sigma_r, double away,
             const BaseFilter* filter, int count) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(7);
  for (int n = 0; n < count; ++n) {
    const Query q = makeQuery(chain, random, away);
    const NearestBase expected = bruteForce(map, q, sigma_t, sigma_r, filter);
    const NearestBase found = map.nearest(q.gripper, q.base, sigma_t, sigma_r, filter);
    ASSERT_EQ(found.found, expected.found);
    if (!found.found) continue;
    // Answers lie a nanometre (or nanoradian) past the faces.
    const double tolerance = 1e-8 / std::min(sigma_t, sigma_r);
    EXPECT_NEAR(found.cost, expected.cost, tolerance * (1 + expected.cost));
    EXPECT_EQ(found.inside, expected.inside);
    EXPECT_TRUE(map.contains(q.gripper, found.base));
    // The answer is as far away as its cost says.
    const double cost =
        (square(found.base.x - q.base.x) + square(found.base.y - q.base.y)) / square(sigma_t) +
        square(wrapAngle(found.base.theta - q.base.theta) / sigma_r);
    EXPECT_NEAR(cost, found.cost, 1e-9 * (1 + cost));
    if (filter != nullptr) {
      EXPECT_TRUE(filter->isFree(found.base));
    }
  }
}

/// Blocks everything but stripes and directions.
struct Stripes : BaseFilter {
  bool isFree(const Pose2& base) const override {
    return std::sin(9 * base.x) * std::cos(7 * base.y) > 0.3 && std::sin(2 * base.theta) > -0.2;
  }
};

struct Nothing : BaseFilter {
  bool isFree(const Pose2&) const override { return false; }
};

/// Counts how often it is asked.
struct HalfPlane : BaseFilter {
  bool isFree(const Pose2& base) const override {
    ++asked;
    return base.x > 0.1;
  }
  mutable int asked = 0;
};

TEST(ReachNearest, EqualsBruteForceNear) { compare(smallMap(), 0.05, 0.2, 0.5, nullptr, 2000); }
TEST(ReachNearest, EqualsBruteForceFar) { compare(smallMap(), 0.05, 0.2, 4, nullptr, 1000); }
TEST(ReachNearest, EqualsBruteForceForOtherSigmas) {
  compare(smallMap(), 1, 0.01, 1, nullptr, 500);
  compare(smallMap(), 0.01, 3, 1, nullptr, 500);
}
TEST(ReachNearest, EqualsBruteForceWithFilter) {
  const Stripes stripes;
  compare(smallMap(), 0.05, 0.2, 0.7, &stripes, 1000);
  compare(smallMap(), 0.05, 0.2, 3, &stripes, 200);
}
TEST(ReachNearest, EqualsBruteForceWithOtherMargins) {
  ReachMap map = smallMap();
  map.setMargins(0.04, 0.3);
  compare(map, 0.05, 0.2, 0.5, nullptr, 500);
  map.setMargins(0, 0);
  compare(map, 0.05, 0.2, 0.5, nullptr, 500);
  EXPECT_THROW(map.setMargins(0.05, 0), Error);
  EXPECT_THROW(map.setMargins(-1, 0), Error);
}

TEST(ReachNearest, LeavesWhatIsInsideAlone) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(8);
  int inside = 0;
  for (int n = 0; n < 1000; ++n) {
    const Query q = makeQuery(chain, random, 0.02);
    const NearestBase first = smallMap().nearest(q.gripper, q.base, 0.05, 0.2);
    if (!first.found) continue;
    // What was answered is inside, up to rounding at the face it lies on.
    const NearestBase again = smallMap().nearest(q.gripper, first.base, 0.05, 0.2);
    EXPECT_LT(again.cost, 1e-20);
    if (!first.inside) continue;
    ++inside;
    EXPECT_EQ(first.cost, 0);
    EXPECT_EQ(first.base.x, q.base.x);
    EXPECT_EQ(first.base.y, q.base.y);
    EXPECT_EQ(first.base.theta, q.base.theta);
  }
  EXPECT_GT(inside, 100);
}

TEST(ReachNearest, SaysSoWhereNothingIsReachable) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(9);
  const Query q = makeQuery(chain, random, 0.3);
  const Nothing nothing;
  const NearestBase blocked = smallMap().nearest(q.gripper, q.base, 0.05, 0.2, &nothing);
  EXPECT_FALSE(blocked.found);
  EXPECT_FALSE(blocked.inside);
  EXPECT_TRUE(smallMap().contains(q.gripper, blocked.base));

  Pose high = q.gripper;
  high.translation[2] = 5;
  const NearestBase lower = smallMap().nearest(high, q.base, 0.05, 0.2);
  EXPECT_FALSE(lower.found);
  EXPECT_TRUE(std::isfinite(lower.cost));
  high.translation[2] = std::numeric_limits<double>::max();
  EXPECT_FALSE(smallMap().nearest(high, q.base, 0.05, 0.2).found);
  EXPECT_THROW(smallMap().nearest(high, q.base, 0, 0.2), Error);
}

TEST(ReachNearest, AsksTheFilterLazily) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(10);
  HalfPlane filter;
  for (int n = 0; n < 200; ++n) {
    const Query q = makeQuery(chain, random, 0.1);
    filter.asked = 0;
    const NearestBase found = smallMap().nearest(q.gripper, q.base, 0.05, 0.2, &filter);
    if (!found.found) continue;
    // No more than the cells nearer than the answer, and the answer.
    const GripperView view = smallMap().grid().view(q.gripper);
    const auto slice =
        smallMap().grid().slice(smallMap().grid().heightBin(view.position[2]), view.tilt);
    const auto* begin = smallMap().cells().data() + slice * smallMap().grid().sliceSize();
    const auto cells = std::count_if(begin, begin + smallMap().grid().sliceSize(),
                                     [](std::uint8_t c) { return c != 0; });
    EXPECT_LE(filter.asked, cells + 2);
    if (found.base.x == q.base.x) {
      EXPECT_EQ(filter.asked, 1);
    }
  }
}

}  // namespace
}  // namespace graft::lfd
