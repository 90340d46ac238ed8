// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/chi_square.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace graft {
namespace {

TEST(ChiSquare, QuantilesAreThoseOfTables) {
  struct Row {
    int freedom;
    double probability;
    double quantile;  ///< Abramowitz and Stegun, table 26.8, and R's qchisq()
  };
  const Row rows[] = {
      {1, 0.5, 0.454936423119573},   {1, 0.95, 3.841458820694124},   {1, 0.99, 6.634896601021213},
      {2, 0.95, 5.991464547107979},  {2, 0.99, 9.210340371976180},   {3, 0.99, 11.344866730144373},
      {3, 0.05, 0.351846317749272},  {4, 0.999, 18.466826952903151}, {6, 0.5, 5.348120627447120},
      {6, 0.99, 16.811893829770927}, {6, 0.9999, 27.856341236056},   {30, 0.95, 43.772971825742189},
      {100, 0.01, 70.064894925399}};
  for (const Row& row : rows) {
    EXPECT_NEAR(chiSquareQuantile(row.probability, row.freedom), row.quantile, 1e-10 * row.quantile)
        << row.freedom << ' ' << row.probability;
  }
}

TEST(ChiSquare, ProbabilitiesHaveClosedForms) {
  for (const double x : {1e-6, 0.1, 0.9, 2.0, 3.7, 8.0, 20.0, 60.0}) {
    EXPECT_NEAR(chiSquareProbability(x, 1), std::erf(std::sqrt(x / 2)), 1e-14) << x;
    EXPECT_NEAR(chiSquareProbability(x, 2), -std::expm1(-x / 2), 1e-14) << x;
    EXPECT_NEAR(chiSquareProbability(x, 4), 1 - std::exp(-x / 2) * (1 + x / 2), 1e-14) << x;
    EXPECT_NEAR(
        chiSquareProbability(x, 3),
        std::erf(std::sqrt(x / 2)) - std::sqrt(2 * x / 3.141592653589793) * std::exp(-x / 2), 1e-14)
        << x;
  }
  EXPECT_EQ(chiSquareProbability(0, 3), 0);
  EXPECT_EQ(chiSquareProbability(-1, 3), 0);
  EXPECT_EQ(chiSquareQuantile(0, 3), 0);
}

TEST(ChiSquare, QuantileIsTheInverse) {
  for (int freedom = 1; freedom < 400; freedom = 1 + freedom * 3 / 2) {
    for (const double p : {1e-8, 0.01, 0.3, 0.5, 0.9, 0.99, 0.9999999}) {
      EXPECT_NEAR(chiSquareProbability(chiSquareQuantile(p, freedom), freedom), p, 1e-13)
          << freedom << ' ' << p;
    }
  }
}

}  // namespace
}  // namespace graft
