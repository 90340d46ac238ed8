// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/inspection.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "tests/core/solve/solve_types.hpp"

namespace graft {
namespace {

using testing::TestGraph;

std::vector<FreeDirection> freeDirections(const TestGraph& g) {
  return findFreeDirections(Problem(g.graph, InformationPolicy::kError), g.values);
}

TEST(Jacobians, OfEveryTagAgreeOrAreNamed) {
  TestGraph g;
  g.point(1, 0.5, 2);
  g.point(2, 3, 4);
  g.vertex("VERTEX_SE2", 3, {1, 2, 3.1});
  g.vertex("VERTEX_SE2", 4, {-1, 2, -3.1});
  g.edge("TEST_RANGE", {1, 2}, {1});
  g.edge("TEST_PRIOR", {1}, {0, 0});
  g.edge("TEST_WRONG", {2}, {0, 0});
  g.edge("TEST_WRONG", {1}, {0, 0});
  // The angle of its error jumps at 3.14159: 1e-5 away from here.
  g.edge("TEST_BETWEEN2", {3, 4}, {0, 0, -6.2 + 3.14159265358979 + 1e-4});
  const std::vector<JacobianCheck> checks =
      checkJacobians(Problem(g.graph, InformationPolicy::kError), g.values);
  ASSERT_EQ(checks.size(), 4u);
  for (const JacobianCheck& check : checks) {
    const bool wrong = check.tag == "TEST_WRONG";
    EXPECT_EQ(check.suspicious, wrong ? 2 : 0) << check.tag << " " << check.worst;
    EXPECT_EQ(check.edges, wrong ? 2 : 1);
    EXPECT_EQ(check.worst > 0.5, wrong);
    EXPECT_EQ(check.worst_edge.substr(0, check.tag.size()), check.tag);
  }
}

TEST(Jacobians, ThatAreNotFiniteAreSuspicious) {
  TestGraph g;
  g.point(1, 4.9999, 2);
  g.edge("TEST_NAN", {1}, {0, 0});
  const std::vector<JacobianCheck> checks =
      checkJacobians(Problem(g.graph, InformationPolicy::kError), g.values);
  EXPECT_EQ(checks[0].suspicious, 0);  // the step that stays below 5 counts
}

TEST(Weights, FarFromTheMedianAreNamed) {
  TestGraph g;
  g.point(1, 0, 0);
  for (int i = 0; i < 6; ++i) {
    const double second = i == 2 ? 2e6 : i == 4 ? 1e-5 : 2 + 0.1 * i;
    g.edge("TEST_PRIOR", {1}, {double(i), 0}, {3.0, 0.0, second});
  }
  const std::vector<OddWeight> odd = findOddWeights(Problem(g.graph, InformationPolicy::kError));
  ASSERT_EQ(odd.size(), 2u);
  EXPECT_NEAR(odd[0].ratio, 2e6 / 2.3, 1e6 * 0.2);
  EXPECT_NEAR(odd[1].ratio, 1e-5 / 2.3, 1e-6);
  EXPECT_EQ(odd[0].edge, "TEST_PRIOR 1");
}

TEST(Weights, OfFewEdgesAreNotJudged) {
  TestGraph g;
  g.point(1, 0, 0);
  g.edge("TEST_PRIOR", {1}, {0, 0}, {1, 0, 1});
  g.edge("TEST_PRIOR", {1}, {1, 0}, {1e9, 0, 1e9});
  EXPECT_TRUE(findOddWeights(Problem(g.graph, InformationPolicy::kError)).empty());
}

TEST(FreeDirections, AreNoneWhereEverythingIsDetermined) {
  TestGraph g;
  g.point(1, 0, 0, true);
  g.point(2, 1, 2);
  g.edge("TEST_DIFFERENCE", {1, 2}, {1, 2});
  EXPECT_TRUE(freeDirections(g).empty());
}

TEST(FreeDirections, OfSinglePointsAreAcrossTheirRange) {
  TestGraph g;
  g.point(1, 0, 0, true);
  for (int i = 2; i < 40; ++i) {
    g.point(i, 3, 4);
    g.edge("TEST_RANGE", {1, i}, {1});
  }
  const std::vector<FreeDirection> free = freeDirections(g);
  ASSERT_EQ(free.size(), 38u);
  for (const FreeDirection& one : free) {
    EXPECT_NEAR(std::abs(one.direction[0] * 4 - one.direction[1] * 3), 5, 1e-9);
    EXPECT_EQ(one.share, 1);
  }
  EXPECT_EQ(g.graph.id(free[0].vertex), 2);
}

TEST(FreeDirections, OfPointsThatMoveTogetherAreShared) {
  // Two points, a fixed difference apart, hang on the origin by one range: both can
  // move across it. Each block alone is regular.
  TestGraph g;
  g.point(1, 0, 0, true);
  g.point(2, 1, 0);
  g.point(3, 2, 0);
  g.edge("TEST_RANGE", {1, 2}, {1});
  g.edge("TEST_DIFFERENCE", {2, 3}, {1, 0});
  const std::vector<FreeDirection> free = freeDirections(g);
  ASSERT_EQ(free.size(), 2u);
  for (const FreeDirection& one : free) {
    EXPECT_NEAR(one.share, 0.5, 1e-6);
    EXPECT_NEAR(std::abs(one.direction[1]), 1, 1e-6);
  }
}

TEST(WeakAnchor, IsWhatLeavesAPartOfEveryVertexOpen) {
  const auto weak = [](const std::vector<double>& first, const std::vector<double>& second) {
    TestGraph g;
    g.point(1, 0, 0);
    g.point(2, 1, 0);
    g.edge("TEST_DIFFERENCE", {1, 2}, {1, 0});
    if (!first.empty()) g.edge("TEST_PRIOR", {1}, {0, 0}, first);
    if (!second.empty()) g.edge("TEST_PRIOR", {2}, {1, 0}, second);
    g.point(8, 5, 5, true);
    g.point(9, 5, 5);
    g.edge("TEST_DIFFERENCE", {8, 9}, {1, 0});
    return hasWeakAnchor(Problem(g.graph, InformationPolicy::kError));
  };
  EXPECT_FALSE(weak({}, {})) << "one vertex is held";
  EXPECT_FALSE(weak({1, 0, 1}, {}));
  EXPECT_TRUE(weak({1, 0, 0}, {}));
  EXPECT_TRUE(weak({1, 1, 1}, {0, 0, 1})) << "not known to be firm: to be looked at";
  EXPECT_FALSE(weak({1, 0, 0}, {1, 0, 1}));
}

TEST(FreeDirections, OfAVertexWithoutWeightAreAll) {
  TestGraph g;
  g.point(1, 0, 0);
  g.edge("TEST_PRIOR", {1}, {0, 0}, {0, 0, 0});
  EXPECT_EQ(freeDirections(g).size(), 2u);
}

}  // namespace
}  // namespace graft
