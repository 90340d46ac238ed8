// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/chi_square.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace graft {

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr int kTerms = 10000;

/// log Gamma(freedom / 2). Not std::lgamma, which writes a global variable.
double logGammaOfHalf(int freedom) {
  double result = freedom % 2 == 0 ? 0.0 : 0.5 * std::log(3.141592653589793238);
  for (int k = freedom % 2 == 0 ? 2 : 1; k < freedom; k += 2) result += std::log(0.5 * k);
  return result;
}

/// P(a, x) by its power series: fast for x < a + 1.
double lowerSeries(double a, double x, double front) {
  double term = 1 / a;
  double sum = term;
  for (int n = 1; n < kTerms && term > sum * kEpsilon; ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return front * sum;
}

/// 1 - P(a, x) by its continued fraction (Lentz's method): fast for x > a + 1.
double upperFraction(double a, double x, double front) {
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a;
  double c = 1 / kTiny;
  double d = 1 / b;
  double value = d;
  for (int n = 1; n < kTerms; ++n) {
    const double factor = -n * (n - a);
    b += 2;
    d = factor * d + b;
    if (std::abs(d) < kTiny) d = kTiny;
    c = b + factor / c;
    if (std::abs(c) < kTiny) c = kTiny;
    d = 1 / d;
    const double change = c * d;
    value *= change;
    if (std::abs(change - 1) < kEpsilon) break;
  }
  return front * value;
}

}  // namespace

double chiSquareProbability(double x, int freedom) {
  if (!(x > 0)) return 0;
  const double a = 0.5 * freedom;
  const double half = 0.5 * x;
  const double front = std::exp(a * std::log(half) - half - logGammaOfHalf(freedom));
  return half < a + 1 ? lowerSeries(a, half, front) : 1 - upperFraction(a, half, front);
}

double chiSquareQuantile(double probability, int freedom) {
  if (!(probability > 0)) return 0;
  double low = 0;
  double high = freedom;
  while (chiSquareProbability(high, freedom) < probability && high < 1e6 * freedom) high *= 2;
  // Bisection: sure, and quick enough for what is done once per dimension.
  while (high - low > 4 * kEpsilon * high) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    (chiSquareProbability(middle, freedom) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace graft
