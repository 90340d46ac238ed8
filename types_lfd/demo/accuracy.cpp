// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/text.hpp"
#include "types_lfd/demo/statistics.hpp"

namespace graft::lfd {

namespace {

constexpr double kLeastSigmaT = 1e-4;
constexpr double kLeastSigmaR = 1e-3;

}  // namespace

TrackerAccuracy estimateAccuracy(const Trajectory& track) {
  if (track.size() < 5) {
    throw Error(ExitCode::kInput,
                "a track's accuracy needs at least 5 poses to be estimated, it has " +
                    std::to_string(track.size()));
  }
  std::vector<double> translation;
  std::vector<double> rotation;
  for (std::size_t i = 1; i + 1 < track.size(); ++i) {
    const double s =
        (track.times[i] - track.times[i - 1]) / (track.times[i + 1] - track.times[i - 1]);
    // Variance of x_i - (1-s) x_(i-1) - s x_(i+1) in units of the noise's.
    const double scale = 1 / std::sqrt(1 + s * s + (1 - s) * (1 - s));
    const Pose between = interpolate(track.poses[i - 1], track.poses[i + 1], s);
    const Vec<double, 6> residual = track.poses[i].minus(between);
    translation.push_back(scale * residual.head<3>().norm());
    rotation.push_back(scale * residual.tail<3>().norm());
  }
  return {std::max(kLeastSigmaT, medianOf(translation) / kMedianChi3),
          std::max(kLeastSigmaR, medianOf(rotation) / kMedianChi3)};
}

std::map<std::string, TrackerAccuracy> trackerAccuracies(
    const Task& task, const std::vector<Demonstration>& demonstrations, Diagnostics& diagnostics) {
  std::map<std::string, TrackerAccuracy> accuracies = task.trackers;
  const std::pair<const char*, Trajectory Demonstration::*> entities[] = {
      {"hand", &Demonstration::hand},
      {"object", &Demonstration::object},
      {"torso", &Demonstration::torso}};
  for (const auto& [entity, track] : entities) {
    if (accuracies.count(entity) != 0) continue;
    double sum_t = 0;
    double sum_r = 0;
    double count = 0;
    for (const Demonstration& demonstration : demonstrations) {
      if ((demonstration.*track).size() == 0) continue;
      const TrackerAccuracy one = estimateAccuracy(demonstration.*track);
      sum_t += one.sigma_t * one.sigma_t;
      sum_r += one.sigma_r * one.sigma_r;
      count += 1;
    }
    if (count == 0) continue;
    const TrackerAccuracy pooled{std::sqrt(sum_t / count), std::sqrt(sum_r / count)};
    accuracies[entity] = pooled;
    diagnostics.note({task.path, 0, 0}, std::string("no <tracker> for '") + entity +
                                            "': its accuracy is estimated from the tracks as " +
                                            formatDouble(pooled.sigma_t) + " m, " +
                                            formatDouble(pooled.sigma_r) + " rad");
  }
  return accuracies;
}

}  // namespace graft::lfd
