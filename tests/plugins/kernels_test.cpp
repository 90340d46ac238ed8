// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/kernels/kernels.hpp"

#include <gtest/gtest.h>

#include <array>

#include "tests/support/derivatives.hpp"

namespace graft {
namespace {

struct KernelCase {
  const char* name;
  void (*evaluate)(double, double, double*);
  double kink;         ///< squared error where a derivative jumps, per width; 0 = none
  bool squared_width;  ///< the width is in units of the squared error
  double limit;        ///< of rho for s to infinity, width 1; 0 = it grows
};

class KernelTest : public ::testing::TestWithParam<KernelCase> {
 protected:
  std::array<double, 3> rho(double s, double w) const {
    std::array<double, 3> r{};
    GetParam().evaluate(s, w, r.data());
    return r;
  }
  double kink(double w) const { return GetParam().kink * (GetParam().squared_width ? w : w * w); }
};

TEST_P(KernelTest, StartsLikeThePlainSquare) {
  for (const double w : {0.1, 1.0, 7.0}) {
    EXPECT_EQ(rho(0, w)[0], 0);
    EXPECT_NEAR(rho(0, w)[1], 1, 1e-15);
    for (const double s : {1e-14, 1e-10}) EXPECT_NEAR(rho(s, w)[0] / s, 1, 1e-3);
  }
}

TEST_P(KernelTest, DerivativesAreExact) {
  for (const double w : {0.5, 1.0, 3.0}) {
    for (const double s : {0.05, 0.3, 0.9, 1.7, 4.0, 11.0, 40.0}) {
      const double step = 0.02 * s;
      if (std::abs(s - kink(w)) < 2 * step) continue;
      const auto f = [&](const Eigen::VectorXd& d) {
        const auto r = rho(s + d[0], w);
        return Eigen::VectorXd(Eigen::Vector2d(r[0], r[1]));
      };
      const Eigen::MatrixXd j = testing::riddersJacobian(f, 1, step);
      EXPECT_NEAR(rho(s, w)[1], j(0, 0), 1e-8) << s << ' ' << w;
      EXPECT_NEAR(rho(s, w)[2], j(1, 0), 1e-7) << s << ' ' << w;
    }
  }
}

TEST_P(KernelTest, WeightFallsAndStaysBetweenZeroAndOne) {
  double last = 1;
  for (double s = 0; s < 100; s += 0.01) {
    const double weight = rho(s, 1.3)[1];
    EXPECT_LE(weight, last + 1e-15);
    EXPECT_GE(weight, 0);
    last = weight;
  }
}

TEST_P(KernelTest, CostIsContinuousAndNeverFalls) {
  double last = 0;
  for (double s = 0; s < 30; s += 0.001) {
    const double value = rho(s, 1.3)[0];
    EXPECT_GE(value, last - 1e-15);
    EXPECT_LE(value - last, 0.0011);
    last = value;
  }
}

TEST_P(KernelTest, LimitForLargeErrorsAndForLargeWidths) {
  if (GetParam().limit > 0) {
    EXPECT_NEAR(rho(1e12, 1)[0], GetParam().limit, 1e-9);
  } else {
    EXPECT_GT(rho(1e12, 1)[0], 10);
  }
  EXPECT_NEAR(rho(2.5, 1e9)[0], 2.5, 1e-7);
}

INSTANTIATE_TEST_SUITE_P(
    , KernelTest,
    ::testing::Values(KernelCase{"Huber", &Huber::evaluate, 1, false, 0},
                      KernelCase{"PseudoHuber", &PseudoHuber::evaluate, 0, false, 0},
                      KernelCase{"Cauchy", &Cauchy::evaluate, 0, false, 0},
                      KernelCase{"GemanMcClure", &GemanMcClure::evaluate, 0, true, 1},
                      KernelCase{"Welsch", &Welsch::evaluate, 0, false, 1},
                      KernelCase{"Fair", &Fair::evaluate, 0, false, 0},
                      KernelCase{"Tukey", &Tukey::evaluate, 1, false, 1.0 / 3},
                      KernelCase{"Saturated", &Saturated::evaluate, 1, false, 1},
                      KernelCase{"DCS", &Dcs::evaluate, 1, true, 3}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(Kernels, HuberByHand) {
  double r[3];
  Huber::evaluate(9, 2, r);  // error 3, width 2: 2 * 3 * 2 - 4
  EXPECT_EQ(r[0], 8);
  EXPECT_EQ(r[1], 2.0 / 3.0);
}

/// g2o's kernels as the literature gives them, by value and weight, written independently
/// (Zhang, "Parameter estimation techniques", 1997; for Geman and McClure the width takes
/// the place of a squared error).
std::array<double, 2> asInG2o(const std::string& name, double s, double w) {
  const double e = std::sqrt(s);
  const double q = s / (w * w);
  const bool inside = e <= w;
  if (name == "Huber") return {inside ? s : w * (2 * e - w), inside ? 1 : w / e};
  if (name == "PseudoHuber") return {2 * w * w * (std::sqrt(1 + q) - 1), 1 / std::sqrt(1 + q)};
  if (name == "Cauchy") return {w * w * std::log(1 + q), 1 / (1 + q)};
  if (name == "GemanMcClure") return {w * s / (w + s), std::pow(w / (w + s), 2)};
  if (name == "Welsch") return {w * w * (1 - std::exp(-q)), std::exp(-q)};
  if (name == "Fair") return {2 * w * w * (e / w - std::log(1 + e / w)), 1 / (1 + e / w)};
  if (name == "Tukey") {
    return {w * w / 3 * (inside ? 1 - std::pow(1 - q, 3) : 1), inside ? std::pow(1 - q, 2) : 0};
  }
  return {inside ? s : w * w, inside ? 1.0 : 0.0};  // Saturated
}

TEST_P(KernelTest, IsThatOfG2o) {
  const std::string name = GetParam().name;
  if (name == "DCS") return;  // on purpose, see Kernels.DcsHasTheWeightOfItsPaper
  for (const double w : {0.3, 1.0, 2.5}) {
    for (const double s : {0.01, 0.5, 0.99, 1.01, 4.0, 9.0, 100.0}) {
      const auto expected = asInG2o(name, s, w);
      EXPECT_NEAR(rho(s, w)[0], expected[0], 1e-12 * (1 + expected[0])) << s << ' ' << w;
      EXPECT_NEAR(rho(s, w)[1], expected[1], 1e-14) << s << ' ' << w;
    }
  }
}

TEST(Kernels, DcsHasTheWeightOfItsPaper) {
  const auto cost = [](double s, double w) {
    double r[3];
    Dcs::evaluate(s, w, r);
    return r[0];
  };
  for (const double w : {0.3, 1.0, 2.5}) {
    for (const double s : {0.01, 0.5, 0.99, 1.01, 4.0, 9.0, 100.0}) {
      double r[3];
      Dcs::evaluate(s, w, r);
      const auto scale = [w](double t) { return std::min(1.0, 2 * w / (w + t)); };
      EXPECT_NEAR(r[1], std::pow(scale(s), 2), 1e-14);
      // g2o's cost, scale^2 s, falls where s > w, which no descent can use.
      const double more = 1.1 * s;
      EXPECT_EQ(std::pow(scale(more), 2) * more < std::pow(scale(s), 2) * s, s >= w) << s;
      EXPECT_GT(cost(more, w), cost(s, w));
    }
  }
}

}  // namespace
}  // namespace graft
