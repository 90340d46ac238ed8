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

/// The definition, word by word, through the map's own distances only.
class BruteForce {
 public:
  BruteForce(const ReachMap& map, const Query& query, double sigma_t, double sigma_r)
      : map_(map),
        query_(query),
        view_(ReachGrid::view(query.gripper)),
        base_(baseInView(view_, query.base)),
        sigma_t_(sigma_t),
        sigma_r_(sigma_r) {
    findNodes();
  }

  NearestBase run(const BaseFilter* filter) {
    NearestBase result;
    const auto free = [&](const Pose2& b) {
      return filter == nullptr || filter->isFree(baseInWorld(view_, b));
    };
    if (keeps(base_) && free(base_)) {
      result.found = result.inside = true;
      result.base = query_.base;
      return result;
    }
    std::vector<std::pair<double, Pose2>> points = boxes();
    std::stable_sort(points.begin(), points.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [cost, point] : points) {
      for (const Pose2& p : {drawnBack(point), point}) {
        if (!free(p)) continue;
        result.found = true;
        result.base = baseInWorld(view_, p);
        result.cost = costOf(p);
        return result;
      }
    }
    return result;
  }

 private:
  bool keeps(const Pose2& b) const {
    for (const double turn : {0.0, -map_.marginR(), map_.marginR()}) {
      const Pose2 turned(b.x, b.y, b.theta + turn);
      if (map_.distance(query_.gripper, baseInWorld(view_, turned)) <
          std::max(1e-6, map_.marginT())) {
        return false;
      }
    }
    return true;
  }

  void findNodes() {
    const ReachGrid& g = map_.grid();
    for (int p = 0; p < g.psiCount(); ++p) {
      for (int y = 0; y < g.ny; ++y) {
        for (int x = 0; x < g.nx; ++x) {
          nodes_.push_back(
              keeps(Pose2((g.x0 + x) * g.resolution, (g.y0 + y) * g.resolution, p * g.nodeStep())));
        }
      }
    }
  }

  bool node(int p, int y, int x) const {
    const ReachGrid& g = map_.grid();
    return nodes_[static_cast<std::size_t>(((p % g.psiCount()) * g.ny + y) * g.nx + x)];
  }

  std::vector<std::pair<double, Pose2>> boxes() const {
    const ReachGrid& g = map_.grid();
    std::vector<std::pair<double, Pose2>> points;
    for (int p = 0; p < g.psiCount(); ++p) {
      for (int y = 0; y + 1 < g.ny; ++y) {
        for (int x = 0; x + 1 < g.nx; ++x) {
          bool all = true;
          for (int i = 0; i < 8 && all; ++i)
            all = node(p + (i >> 2), y + (i >> 1 & 1), x + (i & 1));
          if (!all) continue;
          Pose2 point(std::clamp(base_.x, (g.x0 + x) * g.resolution, (g.x0 + x + 1) * g.resolution),
                      std::clamp(base_.y, (g.y0 + y) * g.resolution, (g.y0 + y + 1) * g.resolution),
                      0);
          // The same angle in all turns around the interval.
          double nearest = std::numeric_limits<double>::infinity();
          for (int turn = -2; turn <= 2; ++turn) {
            const double a = base_.theta + turn * 2 * M_PI;
            const double d = std::clamp(a, p * g.nodeStep(), (p + 1) * g.nodeStep()) - a;
            if (std::abs(d) < std::abs(nearest)) nearest = d;
          }
          point.theta = base_.theta + nearest;
          points.emplace_back(costOf(point), point);
        }
      }
    }
    return points;
  }

  double costOf(const Pose2& p) const {
    return (square(p.x - base_.x) + square(p.y - base_.y)) / square(sigma_t_) +
           square((p.theta - base_.theta) / sigma_r_);
  }

  Pose2 drawnBack(const Pose2& p) const {
    const ReachGrid& g = map_.grid();
    const Pose2 d(p.x - base_.x, p.y - base_.y, p.theta - base_.theta);
    const double cells =
        std::max(std::hypot(d.x, d.y) / g.resolution, std::abs(d.theta) / g.nodeStep());
    if (cells == 0) return p;
    const auto along = [&](double s) {
      return Pose2(base_.x + s * d.x, base_.y + s * d.y, base_.theta + s * d.theta);
    };
    double out = std::max(0.0, 1 - 1 / cells);
    if (keeps(along(out))) return along(out);
    double in = 1;
    for (int i = 0; i < 6; ++i) (keeps(along(0.5 * (in + out))) ? in : out) = 0.5 * (in + out);
    return along(in);
  }

  const ReachMap& map_;
  Query query_;
  GripperView view_;
  Pose2 base_;
  double sigma_t_;
  double sigma_r_;
  std::vector<char> nodes_;
};

void compare(const ReachMap& map, double sigma_t, double sigma_r, double away,
             const BaseFilter* filter, int count) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(7);
  for (int n = 0; n < count; ++n) {
    const Query q = makeQuery(chain, random, away);
    const NearestBase expected = BruteForce(map, q, sigma_t, sigma_r).run(filter);
    const NearestBase found = map.nearest(q.gripper, q.base, sigma_t, sigma_r, filter);
    ASSERT_EQ(found.found, expected.found);
    if (!found.found) continue;
    EXPECT_NEAR(found.cost, expected.cost, 1e-9 * (1 + expected.cost));
    EXPECT_EQ(found.inside, expected.inside);
    EXPECT_TRUE(map.contains(q.gripper, found.base));
    EXPECT_GE(map.distance(q.gripper, found.base), map.marginT() - 1e-9);
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

TEST(ReachNearest, EqualsBruteForceNear) { compare(smallMap(), 0.05, 0.2, 0.5, nullptr, 200); }
TEST(ReachNearest, EqualsBruteForceFar) { compare(smallMap(), 0.05, 0.2, 4, nullptr, 100); }
TEST(ReachNearest, EqualsBruteForceForOtherSigmas) {
  compare(smallMap(), 1, 0.01, 1, nullptr, 50);
  compare(smallMap(), 0.01, 3, 1, nullptr, 50);
}
TEST(ReachNearest, EqualsBruteForceWithFilter) {
  const Stripes stripes;
  compare(smallMap(), 0.05, 0.2, 0.7, &stripes, 150);
  compare(smallMap(), 0.05, 0.2, 3, &stripes, 50);
}
TEST(ReachNearest, EqualsBruteForceWithOtherMargins) {
  ReachMap map = smallMap();
  map.setMargins(0.04, 0.3);
  compare(map, 0.05, 0.2, 0.5, nullptr, 50);
  map.setMargins(0, 0);
  compare(map, 0.05, 0.2, 0.5, nullptr, 50);
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

TEST(ReachNearest, NumbersThatAreNotFiniteAreOutOfReach) {
  const Chain chain = smallRobotChain();
  std::mt19937_64 random(12);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    for (int k = 0; k < 10; ++k) {
      Query q = makeQuery(chain, random, 0.1);
      if (k < 3) q.gripper.translation[k] = bad;
      if (k >= 3 && k < 7) q.gripper.rotation.coeffs()[k - 3] = bad;
      if (k == 7) q.base.x = bad;
      if (k == 8) q.base.y = bad;
      if (k == 9) q.base.theta = bad;
      if (bad == 1e300 && k >= 3 && k != 7 && k != 8) continue;
      EXPECT_FALSE(smallMap().contains(q.gripper, q.base)) << k;
      EXPECT_EQ(smallMap().quality(q.gripper, q.base), 0) << k;
      EXPECT_FALSE(smallMap().nearest(q.gripper, q.base, 0.05, 0.2).inside) << k;
    }
  }
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
    // What is inside, or free where it is nearest, costs no search.
    const int asked = filter.asked;
    if (found.inside) {
      EXPECT_EQ(asked, 1);
    }
    const NearestBase nearest = smallMap().nearest(q.gripper, q.base, 0.05, 0.2);
    if (!nearest.inside && filter.isFree(nearest.base)) {
      EXPECT_LE(asked, 2);
    }
  }
}

}  // namespace
}  // namespace graft::lfd
