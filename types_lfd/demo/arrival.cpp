// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/arrival.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace graft::lfd {

namespace {

/// Residual sum of squares of the fit for one g and T.
double residual(const ArrivalSamples& samples, double g, double duration) {
  const auto n = static_cast<double>(samples.times.size());
  double sum_h = 0;
  double sum_hh = 0;
  Eigen::Vector3d sum_p = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum_hp = Eigen::Vector3d::Zero();
  double sum_pp = 0;
  const Eigen::Vector3d origin = samples.points.back();
  for (std::size_t i = 0; i < samples.times.size(); ++i) {
    const double h = minimumJerkToGo((g - samples.times[i]) / duration);
    const Eigen::Vector3d p = samples.points[i] - origin;
    sum_h += h;
    sum_hh += h * h;
    sum_p += p;
    sum_hp += h * p;
    sum_pp += p.squaredNorm();
  }
  const double var_h = sum_hh - sum_h * sum_h / n;
  const double total = sum_pp - sum_p.squaredNorm() / n;
  if (var_h < 1e-12) return total;
  return total - (sum_hp - sum_h / n * sum_p).squaredNorm() / var_h;
}

/// Mean distance from where the hand rests between two clocks, 0 where there is none.
double meanDistance(const ArrivalSamples& samples, double begin, double end) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < samples.all_times.size(); ++i) {
    if (samples.all_times[i] < begin || samples.all_times[i] > end) continue;
    sum += samples.distances[i];
    ++count;
  }
  return count == 0 ? 0 : sum / count;
}

/// Distance at the last sample before the hand is at rest.
double lastSeenDistance(const ArrivalSamples& samples) {
  const auto after = std::lower_bound(samples.times.begin(), samples.times.end(), samples.edge);
  if (after == samples.times.begin()) return 0;
  return meanDistance(samples, *(after - 1), *(after - 1));
}

}  // namespace

double minimumJerkToGo(double rest) {
  const double r = std::clamp(rest, 0.0, 1.0);
  return r * r * r * (10 - 15 * r + 6 * r * r);
}

double fitArrival(const ArrivalSamples& samples, const SegmentOptions& options) {
  const double otherwise = std::min(samples.edge, samples.latest);
  if (samples.times.size() < 5 || samples.latest <= samples.times.front()) return otherwise;
  std::vector<double> moments;
  std::vector<double> costs;
  double best = std::numeric_limits<double>::infinity();
  const double earliest = samples.times.front();
  std::vector<double> durations{options.shortest};
  while (durations.back() * 1.1 <= options.longest) durations.push_back(durations.back() * 1.1);
  const int steps = int((samples.latest - earliest) / options.step);
  for (int k = 0; k <= steps; ++k) {
    const double g = earliest + k * options.step;
    double cost = std::numeric_limits<double>::infinity();
    for (const double t : durations) {
      // Peak speed is half-way in time.
      if (g - earliest > (samples.after_peak ? 0.6 : 1.0) * t) continue;
      cost = std::min(cost, residual(samples, g, t));
    }
    moments.push_back(g);
    costs.push_back(cost);
    best = std::min(best, cost);
  }
  // Two standard deviations: minus twice the log likelihood rises by 4. Sigma^2
  // is what the fit leaves (3 numbers a sample, 8 parameters), at least that of
  // the soft hand.
  const double freedom = std::max(1.0, 3.0 * static_cast<double>(samples.times.size()) - 8.0);
  const double variance = std::max(best / freedom, options.softness * options.softness);
  const double limit = best + 4 * variance;
  // At rest the distance is the tracker's noise. Where the whole approach was hidden, it is
  // that of a line across the gap, of which no hand is behind by more than half.
  constexpr double kAround = 0.15;  // s
  constexpr double kEver = std::numeric_limits<double>::infinity();
  double near = options.near + meanDistance(samples, samples.edge, kEver);
  if (!samples.after_peak) near = std::max(near, 0.5 * lastSeenDistance(samples));
  for (std::size_t i = 0; i < moments.size(); ++i) {
    const double distance = meanDistance(samples, moments[i] - kAround, moments[i] + kAround);
    if (costs[i] <= limit && distance <= near) return moments[i];
  }
  return otherwise;
}

}  // namespace graft::lfd
