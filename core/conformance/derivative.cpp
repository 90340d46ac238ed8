// SPDX-License-Identifier: BSD-3-Clause
#include "core/conformance/derivative.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace graft::conformance {

namespace {

double largestDifference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double difference = std::abs(a[i] - b[i]);
    // A NaN counts as infinitely wrong.
    largest = difference <= largest ? largest : difference;
    if (std::isnan(difference)) return std::numeric_limits<double>::infinity();
  }
  return largest;
}

NumericDerivative ridders(const std::function<std::vector<double>(double)>& f, double step) {
  constexpr int kLevels = 10;
  constexpr double kShrink = 1.4;
  NumericDerivative best;
  best.error = std::numeric_limits<double>::infinity();
  std::vector<std::vector<double>> last;
  for (int i = 0; i < kLevels; ++i, step /= kShrink) {
    const std::vector<double> above = f(step);
    const std::vector<double> below = f(-step);
    std::vector<std::vector<double>> row(1, std::vector<double>(above.size()));
    for (std::size_t k = 0; k < above.size(); ++k) {
      row[0][k] = (above[k] - below[k]) / (2 * step);
    }
    if (best.value.empty()) best.value = row[0];
    double factor = kShrink * kShrink;
    for (std::size_t j = 1; j <= last.size(); ++j, factor *= kShrink * kShrink) {
      std::vector<double> next(above.size());
      for (std::size_t k = 0; k < next.size(); ++k) {
        next[k] = (factor * row[j - 1][k] - last[j - 1][k]) / (factor - 1);
      }
      const double error =
          std::max(largestDifference(next, row[j - 1]), largestDifference(next, last[j - 1]));
      if (error <= best.error) {
        best.error = error;
        best.value = next;
      }
      row.push_back(std::move(next));
    }
    last = std::move(row);
  }
  for (const double x : best.value) best.scale = std::max(best.scale, std::abs(x));
  return best;
}

}  // namespace

bool NumericDerivative::contradicts(double exact, std::size_t entry) const {
  const double tolerance = 1e-6 * std::max(scale, std::abs(exact)) + 10 * error;
  return !(std::abs(exact - value[entry]) <= tolerance);
}

NumericDerivative differentiate(const std::function<std::vector<double>(double)>& f, double step) {
  NumericDerivative coarse = ridders(f, step);
  if (coarse.reliable() && coarse.error < 1e-9 * coarse.scale) return coarse;
  NumericDerivative fine = ridders(f, step * 1e-2);
  return fine.error < coarse.error ? fine : coarse;
}

}  // namespace graft::conformance
