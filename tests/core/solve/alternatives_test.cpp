// SPDX-License-Identifier: BSD-3-Clause
// Edges that choose: other choices are tried, and what refused steps run into counts.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>

#include "core/solve/optimizer.hpp"
#include "tests/core/solve/solve_types.hpp"

namespace graft::testing {
namespace {

double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

/// A chain of points that hangs between priors, whose first point is at one of three anchors:
/// stiff enough there to stay with any anchor that it is close to.
struct Chain {
  explicit Chain(std::uint64_t seed, double choice_information = 500)
      : information(choice_information) {
    std::mt19937_64 random(seed);
    for (double& a : anchors) a = uniform(random, -3, 3);
    for (int i = 0; i < kPoints; ++i) wanted.push_back(uniform(random, -3, 3));
  }

  /// With all anchors, or one of them three times.
  TestGraph graph(int only = -1) const {
    TestGraph g;
    for (int i = 0; i < kPoints; ++i) {
      g.point(i, 0, 0);
      g.edge("TEST_PRIOR", {i}, {wanted[std::size_t(i)], 0}, {2, 0, 1});
      if (i > 0) g.edge("TEST_DIFFERENCE", {i - 1, i}, {0.5, 0}, {3, 0, 3});
    }
    std::vector<double> numbers = anchors;
    for (int k = 0; only >= 0 && k < 6; ++k)
      numbers[std::size_t(k)] = anchors[std::size_t(2 * only + k % 2)];
    g.edge("TEST_CHOICE", {0}, numbers, {information, 0, information});
    return g;
  }

  /// Number of the anchor that is nearest to a point.
  int nearest(const double* x) const {
    int best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const double d =
          std::hypot(x[0] - anchors[std::size_t(2 * k)], x[1] - anchors[std::size_t(2 * k + 1)]);
      if (d < least) best = k;
      least = std::min(least, d);
    }
    return best;
  }

  static constexpr int kPoints = 6;
  double information;
  std::vector<double> anchors = std::vector<double>(6);
  std::vector<double> wanted;
};

double solved(TestGraph g, int alternatives, Summary* summary = nullptr) {
  SolveOptions options;
  options.alternatives = alternatives;
  options.association_tolerance = 1e-12;
  const Summary s = optimize(g.graph, g.values, testRegistry(), options);
  EXPECT_EQ(s.status, Status::kConverged) << s.reason;
  EXPECT_NEAR(s.chi2_final, evaluateChi2(g.graph, g.values), 1e-9 * (1 + s.chi2_final));
  if (summary != nullptr) *summary = s;
  return s.chi2_final;
}

TEST(Alternatives, TheBestOfAllChoicesIsFound) {
  int poor = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Chain chain(seed);
    double best = std::numeric_limits<double>::infinity();
    for (int only = 0; only < 3; ++only) best = std::min(best, solved(chain.graph(only), 0));
    const double nearest = solved(chain.graph(), 0);
    Summary summary;
    const double found = solved(chain.graph(), 3, &summary);
    EXPECT_NEAR(found, best, 1e-8 * best) << "seed " << seed;
    EXPECT_LE(summary.alternatives_tried, 2) << "no choice twice, not the own one either";
    EXPECT_EQ(summary.alternatives_taken > 0, nearest > best * (1 + 1e-8)) << "seed " << seed;
    poor += nearest > best * (1 + 1e-8) ? 1 : 0;
    for (std::size_t i = 1; i < summary.iterations.size(); ++i) {
      EXPECT_LE(summary.iterations[i].chi2, summary.iterations[i - 1].chi2);
    }
  }
  EXPECT_GE(poor, 5) << "the nearest choice is hardly ever poor: nothing was tested";
}

/// Other edges that choose make valleys: a chain's points are at the nearest of three anchors.
TestGraph valleys(const Chain& chain, std::uint64_t seed, int only = -1) {
  TestGraph g = chain.graph(only);
  std::mt19937_64 random(seed + 1000);
  for (int i = 1; i < Chain::kPoints; ++i) {
    std::vector<double> anchors(6);
    for (double& a : anchors) a = uniform(random, -2, 2);
    g.edge("TEST_NEAREST", {i}, anchors, {2, 0, 2});
  }
  return g;
}

/// Which valley a choice ends in depends on where it begins: attempts begin where the solve
/// did, as if there was no other choice.
TEST(Alternatives, NoChoiceAloneLeadsLower) {
  int poor = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Chain chain(seed, 50);
    double best = std::numeric_limits<double>::infinity();
    for (int only = 0; only < 3; ++only) {
      best = std::min(best, solved(valleys(chain, seed, only), 0));
    }
    Summary summary;
    // What promises too little is not tried, and ends far above.
    EXPECT_LE(solved(valleys(chain, seed), 100, &summary), best * (1 + 1e-12)) << "seed " << seed;
    poor += summary.alternatives_taken > 0 ? 1 : 0;
  }
  EXPECT_GE(poor, 20) << "the nearest choice is hardly ever poor: nothing was tested";
}

TEST(Alternatives, AChoiceThatDoesNotHoldIsNotTaken) {
  for (std::uint64_t seed = 1; seed <= 600; ++seed) {
    solved(valleys(Chain(seed, 1), seed), 100);  // compares with new associations
  }
}

/// Where the edge is soft, its point may leave the choice that was predicted to be best; the
/// next best is then tried from where the first attempt began.
TEST(Alternatives, ASecondChoiceFollowsAFirstThatFailed) {
  int second = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Chain chain(seed, 3);
    double best = std::numeric_limits<double>::infinity();
    for (int only = 0; only < 3; ++only) {
      TestGraph g = chain.graph(only);
      SolveOptions options;
      options.association_tolerance = 1e-12;
      const double chi2 = optimize(g.graph, g.values, testRegistry(), options).chi2_final;
      if (chain.nearest(g.at(0).data()) == only) best = std::min(best, chi2);
    }
    Summary summary;
    EXPECT_NEAR(solved(chain.graph(), 5, &summary), best, 1e-8 * best) << "seed " << seed;
    second +=
        summary.alternatives_taken > 0 && summary.alternatives_tried > summary.alternatives_taken
            ? 1
            : 0;
  }
  EXPECT_GE(second, 5) << "no attempt fails before one succeeds: nothing was tested";
}

TEST(Alternatives, OnePredictionIsEnoughWhereTheRestIsLinear) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Chain chain(seed);
    EXPECT_NEAR(solved(chain.graph(), 1), solved(chain.graph(), 3), 1e-8) << "seed " << seed;
  }
}

TEST(Alternatives, AnInterruptEndsTheSearch) {
  std::atomic<int> interrupt{0};
  TestGraph g = Chain(1).graph();
  SolveOptions options;
  options.alternatives = 3;
  options.interrupt = &interrupt;
  options.callback = [&](const IterationRecord&, const Values&) {
    interrupt = 1;
    return true;
  };
  const Summary summary = optimize(g.graph, g.values, testRegistry(), options);
  EXPECT_EQ(summary.status, Status::kInterrupted);
  EXPECT_EQ(summary.alternatives_tried, 0);
}

TEST(Alternatives, NegativeCountsAreRefused) {
  SolveOptions options;
  options.alternatives = -1;
  EXPECT_NE(options.validate().find("alternatives is -1"), std::string::npos);
}

/// Points drawn out of a wedge that they can only see from outside: quadratic program
/// min sum |p_i - w_i|^2 + 20 |p_i - p_(i-1)|^2 + 1e4 (violation)^2.
TestGraph wedge(int points) {
  TestGraph g;
  for (int i = 0; i < points; ++i) {
    const double u = double(i) / (points - 1);
    g.point(i, 1 - 2 * u, 4);
    g.edge("TEST_PRIOR", {i}, {2 * std::sin(7 * u), 2 * std::cos(5 * u) - 1}, {1, 0, 1});
    g.edge("TEST_BEYOND", {i}, {0.8, 0.6, 0}, {1e4});
    g.edge("TEST_BEYOND", {i}, {-0.8, 0.6, 0}, {1e4});
    if (i > 0) g.edge("TEST_DIFFERENCE", {i - 1, i}, {0, 0}, {20, 0, 20});
  }
  return g;
}

/// Its minimum by itself: semismooth Newton steps of a dense system, halved until F falls.
/// F is convex, so that there is no other.
double wedgeMinimum(int points) {
  const auto term = [&](auto take) {
    for (int i = 0; i < points; ++i) {
      const double u = double(i) / (points - 1);
      for (int k = 0; k < 2; ++k) {
        Eigen::VectorXd row = Eigen::VectorXd::Zero(2 * points);
        row[2 * i + k] = 1;
        take(1.0, row, k == 0 ? 2 * std::sin(7 * u) : 2 * std::cos(5 * u) - 1, false);
        if (i > 0) row[2 * i - 2 + k] = -1;
        if (i > 0) take(20.0, row, 0.0, false);
        row.setZero();
        row.segment<2>(2 * i) << (k == 0 ? 0.8 : -0.8), 0.6;
        take(1e4, row, 0.0, true);
      }
    }
  };
  const auto cost = [&](const Eigen::VectorXd& x) {
    double sum = 0;
    term([&](double weight, const Eigen::VectorXd& row, double right, bool one_sided) {
      const double e = row.dot(x) - right;
      if (!one_sided || e < 0) sum += weight * e * e;
    });
    return sum;
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(2 * points);
  for (int iteration = 0; iteration < 1000; ++iteration) {
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(2 * points, 2 * points);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(2 * points);
    term([&](double weight, const Eigen::VectorXd& row, double right, bool one_sided) {
      const double e = row.dot(x) - right;
      if (one_sided && !(e < 0)) return;
      hessian += weight * row * row.transpose();
      gradient += weight * e * row;
    });
    Eigen::VectorXd step = -hessian.ldlt().solve(gradient);
    while (step.norm() > 1e-13 && !(cost(x + step) < cost(x))) step *= 0.5;
    if (step.norm() <= 1e-13) break;
    x += step;
  }
  return cost(x);
}

TEST(Anticipation, HalfPlanesOutOfSightDoNotStallASolve) {
  for (const int points : {20, 100}) {
    TestGraph g = wedge(points);
    SolveOptions options;
    options.association_tolerance = 1e-10;
    const Summary summary = optimize(g.graph, g.values, testRegistry(), options);
    EXPECT_EQ(summary.status, Status::kConverged) << summary.reason;
    EXPECT_NEAR(summary.chi2_final, wedgeMinimum(points), 1e-6 * summary.chi2_final);
    int factorizations = 0;
    for (const IterationRecord& record : summary.iterations) factorizations += record.linear_solves;
    EXPECT_LE(factorizations, 30) << points;
  }
}

}  // namespace
}  // namespace graft::testing
