// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/robot/self_collision.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "types_lfd/robot/arm_ik.hpp"
#include "types_lfd/robot/chain.hpp"

namespace graft::lfd {
namespace {

using Vector = Eigen::Vector3d;

double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * double(random() >> 11) * 0x1p-53;
}

Eigen::Matrix3d randomRotation(std::mt19937_64& random) {
  const auto u = [&] { return uniform(random, -1, 1); };
  return Eigen::Quaterniond(u(), u(), u(), u() + 1e-3).normalized().toRotationMatrix();
}

PlacedSolid randomSolid(std::mt19937_64& random, double spread) {
  PlacedSolid solid;
  solid.type = UrdfSolid::Type(random() % 3);
  solid.rotation = randomRotation(random);
  for (int k = 0; k < 3; ++k) {
    solid.center[k] = uniform(random, -spread, spread);
    solid.half[k] = uniform(random, 0.02, 0.4);
  }
  return solid;
}

/// The solid's point nearest to p, in closed form.
Vector nearestPoint(const PlacedSolid& solid, const Vector& p) {
  Vector local = solid.rotation.transpose() * (p - solid.center);
  if (solid.type == UrdfSolid::Type::kBox) {
    local = local.cwiseMax(-solid.half).cwiseMin(solid.half);
  } else if (solid.type == UrdfSolid::Type::kCylinder) {
    const double across = local.head<2>().norm();
    if (across > solid.half[0]) local.head<2>() *= solid.half[0] / across;
    local[2] = std::clamp(local[2], -solid.half[1], solid.half[1]);
  } else if (local.norm() > solid.half[0]) {
    local *= solid.half[0] / local.norm();
  }
  return solid.center + solid.rotation * local;
}

/// An upper bound that falls to the distance: nearest points of each other in turn
/// (Cheney, Goldstein 1959).
double distanceByProjections(const PlacedSolid& a, const PlacedSolid& b) {
  Vector p = a.center;
  double distance = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector q = nearestPoint(b, p);
    p = nearestPoint(a, q);
    const double now = (p - q).norm();
    if (i > 0 && distance - now < 1e-13) return now;
    distance = now;
  }
  return distance;
}

TEST(SolidDistance, IsThatOfNearestPointsFoundInTurn) {
  std::mt19937_64 random(3);
  int apart = 0;
  for (int i = 0; i < 3000; ++i) {
    const PlacedSolid a = randomSolid(random, 0.6);
    const PlacedSolid b = randomSolid(random, 0.6);
    const double truth = distanceByProjections(a, b);
    if (truth < 1e-3) continue;  // projections creep where solids graze
    ++apart;
    EXPECT_NEAR(solidDistance(a, b), truth, 2e-5) << i;
    EXPECT_LE(solidDistance(a, b), truth + 1e-6) << i;
    EXPECT_FALSE(solidsOverlap(a, b)) << i;
  }
  EXPECT_GT(apart, 1000);
}

TEST(SolidDistance, IsZeroWhereASampledPointLiesInBoth) {
  std::mt19937_64 random(4);
  int overlapping = 0;
  for (int i = 0; i < 2000; ++i) {
    const PlacedSolid a = randomSolid(random, 0.3);
    const PlacedSolid b = randomSolid(random, 0.3);
    bool shared = false;
    for (int k = 0; k < 300 && !shared; ++k) {
      Vector p;
      for (int c = 0; c < 3; ++c) p[c] = uniform(random, -1, 1);
      p = a.center + a.bound() * p;
      shared = (nearestPoint(a, p) - p).norm() < 1e-12 && (nearestPoint(b, p) - p).norm() < 1e-12;
    }
    if (!shared) continue;
    ++overlapping;
    EXPECT_EQ(solidDistance(a, b), 0) << i;
    EXPECT_TRUE(solidsOverlap(a, b)) << i;
  }
  EXPECT_GT(overlapping, 500);
}

TEST(SolidDistance, HasClosedFormsBetweenAlignedSolids) {
  const auto solid = [](UrdfSolid::Type type, Vector half, Vector center) {
    PlacedSolid s;
    s.type = type;
    s.half = half;
    s.center = center;
    return s;
  };
  const auto box = solid(UrdfSolid::Type::kBox, {1, 2, 3}, {0, 0, 0});
  EXPECT_NEAR(solidDistance(box, solid(UrdfSolid::Type::kBox, {1, 1, 1}, {4, 0, 0})), 2, 1e-9);
  EXPECT_NEAR(solidDistance(box, solid(UrdfSolid::Type::kSphere, {0.5, 0, 0}, {4, 6, 3})), 4.5,
              1e-9);
  EXPECT_NEAR(solidDistance(box, solid(UrdfSolid::Type::kCylinder, {0.5, 1, 0}, {0, 0, 5})), 1,
              1e-9);
  EXPECT_NEAR(solidDistance(box, solid(UrdfSolid::Type::kCylinder, {0.5, 1, 0}, {3, 0, 0})), 1.5,
              1e-6);
  EXPECT_EQ(solidDistance(box, box), 0);
  EXPECT_NEAR(solid(UrdfSolid::Type::kCylinder, {3, 4, 0}, {0, 0, 0}).bound(), 5, 1e-15);
}

/// A planar arm of three links that folds back on its column.
constexpr const char* kFolding = R"(<robot name="folding">
  <link name="base">
    <collision><origin xyz="0 0 0.5"/><geometry><box size="0.2 0.2 1"/></geometry></collision>
  </link>
  <link name="upper">
    <collision><origin xyz="0.35 0 0"/><geometry><box size="0.4 0.08 0.08"/></geometry></collision>
  </link>
  <link name="lower">
    <collision><origin xyz="0.3 0 0"/><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
  <link name="hand">
    <collision><geometry><mesh filename="hand.stl"/></geometry></collision>
  </link>
  <joint name="first" type="revolute">
    <parent link="base"/> <child link="upper"/> <origin xyz="0 0 0.8"/> <axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/>
  </joint>
  <joint name="second" type="revolute">
    <parent link="upper"/> <child link="lower"/> <origin xyz="0.6 0 0"/> <axis xyz="0 0 1"/>
    <limit lower="-3.2" upper="3.2" velocity="1" effort="1"/>
  </joint>
  <joint name="third" type="prismatic">
    <parent link="lower"/> <child link="hand"/> <origin xyz="0.4 0 0"/> <axis xyz="1 0 0"/>
    <limit lower="0" upper="0.2" velocity="1" effort="1"/>
  </joint>
</robot>)";

struct Folding {
  explicit Folding(const std::string& srdf_text = "<robot name='folding'/>",
                   const std::string& urdf_text = kFolding) {
    model = readUrdfText("folding.urdf", urdf_text, diagnostics);
    diagnostics.throwIfErrors();
    chain = std::make_unique<Chain>(model, "base", "hand");
    const Srdf srdf = readSrdfText("folding.srdf", srdf_text, model, diagnostics);
    self = std::make_shared<SelfCollision>(model, srdf, *chain, diagnostics);
  }
  double distance(double first, double second) const {
    const Eigen::Vector3d q(first, second, 0);
    BodyFrames frames;
    chain->bodies(q.data(), frames);
    return self->distance(frames);
  }

  Diagnostics diagnostics;
  UrdfModel model;
  std::unique_ptr<Chain> chain;
  std::shared_ptr<SelfCollision> self;
};

TEST(SelfCollision, FollowsTheJoints) {
  const Folding folding;
  // Base and lower: upper is connected to both.
  EXPECT_EQ(folding.self->pairCount(), 1U);
  EXPECT_NEAR(folding.distance(0, 0), 0.9 - 0.1 - 0.1, 1e-9);
  // Straight back: the ball ends at 0.3 - 0.1, the column at 0.1.
  EXPECT_NEAR(folding.distance(0, 3.14159265358979), 0.1, 1e-9);
  // Off by 0.3 sin: still the face of the column.
  EXPECT_NEAR(folding.distance(0, 3.0), 0.6 + 0.3 * std::cos(3.0) - 0.2, 1e-9);
  bool noted = false;
  for (const std::string& line : folding.diagnostics.lines()) {
    noted = noted || line.find("1 links have only meshes to collide with") != std::string::npos;
  }
  EXPECT_TRUE(noted);
}

TEST(SelfCollision, LeavesOutWhatTheSrdfDisables) {
  const Folding folding(
      "<robot name='folding'><disable_collisions link1='lower' link2='base' reason='x'/></robot>");
  EXPECT_TRUE(folding.self->empty());
  EXPECT_EQ(folding.distance(0, 0), std::numeric_limits<double>::infinity());
  Chain chain = *folding.chain;
  const std::uint64_t before = chain.hash();
  chain.setSelfCollision(folding.self);
  EXPECT_EQ(chain.hash(), before);
  EXPECT_EQ(chain.selfCollision(), nullptr);
}

/// The same with a longer first solid of the last link, that reaches the column.
std::string longFolding() {
  std::string text = kFolding;
  const std::string from = "<origin xyz=\"0.3 0 0\"/><geometry><sphere radius=\"0.1\"/>";
  text.replace(text.find(from), from.size(),
               "<origin xyz=\"0.3 0 0\"/><geometry><box size=\"0.5 0.06 0.06\"/>");
  return text;
}

TEST(SelfCollision, RefusesArmConfigurations) {
  const Folding folding("<robot name='folding'/>", longFolding());
  Chain guarded = *folding.chain;
  guarded.setSelfCollision(folding.self);
  EXPECT_NE(guarded.hash(), folding.chain->hash());
  const Eigen::Vector3d back(0, 3.14159265358979, 0.02);
  const Eigen::Vector3d out(0, 1, 0.02);
  EXPECT_TRUE(guarded.hitsItself(back));
  EXPECT_FALSE(guarded.hitsItself(out));
  EXPECT_FALSE(folding.chain->hitsItself(back));
  Eigen::VectorXd q = back;
  EXPECT_TRUE(refineIk(*folding.chain, folding.chain->forward(back), IkOptions(), q));
  EXPECT_FALSE(solveIk(guarded, guarded.forward(back), back).has_value());
  EXPECT_TRUE(solveIk(guarded, guarded.forward(out), out).has_value());
}

TEST(SelfCollision, SubsetsShareOutAllPairs) {
  const Folding folding("<robot name='folding'/>", longFolding());
  std::mt19937_64 random(5);
  const auto by_first = folding.self->pairsMovedBy({0}, {});
  const auto others = folding.self->pairsMovedBy({}, {0});
  BodyFrames frames;
  SelfCollision::Subset near;
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    folding.chain->bodies(sampleJoints(*folding.chain, random).data(), frames);
    const bool hit = folding.self->collides(frames);
    hits += hit ? 1 : 0;
    EXPECT_EQ(hit,
              folding.self->collides(frames, by_first) || folding.self->collides(frames, others));
    const Eigen::Vector2d axis(0, 0);
    folding.self->keepNear(frames, by_first, 0.1, &axis, near);
    EXPECT_TRUE(!hit || !near.empty());
  }
  EXPECT_GT(hits, 10);
  EXPECT_LT(hits, 490);
}

TEST(Srdf, BadInputsAreNamed) {
  Diagnostics diagnostics;
  const UrdfModel model = readUrdfText("folding.urdf", kFolding, diagnostics);
  const struct {
    const char* text;
    const char* message;
  } cases[] = {
      {"<robot", "a.srdf:1"},
      {"<sdf/>", "a.srdf:1: error: expected <robot>, found <sdf>"},
      {"<robot/>", "name"},
      {"<robot name='pr2'/>", "this describes the robot 'pr2', the URDF 'folding'"},
      {"<robot name='folding'>\n<disable_collisions link1='base'/></robot>", "a.srdf:2"},
  };
  for (const auto& c : cases) {
    try {
      readSrdfText("a.srdf", c.text, model, diagnostics);
      ADD_FAILURE() << c.text;
    } catch (const Error& error) {
      const std::string line = error.formatted();
      EXPECT_NE(line.find(c.message), std::string::npos) << line;
    }
  }
  readSrdfText("a.srdf",
               "<robot name='folding'>\n<disable_collisions link1='base' link2='tail'/></robot>",
               model, diagnostics);
  ASSERT_FALSE(diagnostics.lines().empty());
  EXPECT_EQ(diagnostics.lines().back(), "a.srdf:2: warning: the URDF has no link 'tail'");
  EXPECT_EQ(diagnostics.text().find("no link 'base'"), std::string::npos) << diagnostics.text();
}

}  // namespace
}  // namespace graft::lfd
