// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

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

}  // namespace graft::lfd
