// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/clean.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "core/base/text.hpp"
#include "types_lfd/demo/accuracy.hpp"
#include "types_lfd/demo/statistics.hpp"

namespace graft::lfd {

namespace {

// Sigmas of the difference of two poses that noise alone may make.
constexpr double kNoiseMargin = 5;
// With fewer samples there is no local line to be off from.
constexpr std::size_t kFewest = 5;

void keepOnly(Trajectory& track, const std::vector<char>& keep) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < track.size(); ++i) {
    if (keep[i] == 0) continue;
    track.times[kept] = track.times[i];
    track.poses[kept] = track.poses[i];
    ++kept;
  }
  track.times.resize(kept);
  track.poses.resize(kept);
}

/// Marks the longest chain of mutually reachable samples (dynamic programming).
std::vector<char> longestChain(const Trajectory& track, const SpeedLimit& limit) {
  const std::size_t n = track.size();
  const TrackerAccuracy noise = estimateAccuracy(track);
  const double margin_t = kNoiseMargin * std::sqrt(2.0) * noise.sigma_t;
  const double margin_r = kNoiseMargin * std::sqrt(2.0) * noise.sigma_r;
  const auto reachable = [&](std::size_t i, std::size_t j) {
    const double dt = track.times[j] - track.times[i];
    const Pose& a = track.poses[i];
    const Pose& b = track.poses[j];
    return (b.translation - a.translation).norm() <= limit.linear * dt + margin_t &&
           rotationAngle(a.rotation.conjugate() * b.rotation) <= limit.angular * dt + margin_r;
  };
  std::vector<std::size_t> length(n, 1);
  std::vector<std::size_t> longest(n, 1);  // of length[0..i]; bounds the search
  std::vector<std::size_t> before(n);
  for (std::size_t j = 0; j < n; ++j) {
    before[j] = j;
    for (std::size_t i = j; i-- > 0 && longest[i] + 1 > length[j];) {
      if (length[i] + 1 <= length[j] || !reachable(i, j)) continue;
      length[j] = length[i] + 1;
      before[j] = i;
    }
    longest[j] = j == 0 ? 1 : std::max(longest[j - 1], length[j]);
  }
  auto at =
      static_cast<std::size_t>(std::max_element(length.begin(), length.end()) - length.begin());
  std::vector<char> keep(n, 0);
  for (;;) {
    keep[at] = 1;
    if (before[at] == at) return keep;
    at = before[at];
  }
}

struct Residual {
  double shift = 0;
  double turn = 0;
};

/// Sigma of a sample minus its prediction by a line through others, in units of
/// the samples' sigma (least squares): grows from the middle to the ends.
double predictionSigma(const std::vector<double>& times, double at) {
  const auto n = static_cast<double>(times.size());
  const double mean = std::accumulate(times.begin(), times.end(), 0.0) / n;
  double spread = 0;
  for (const double time : times) spread += (time - mean) * (time - mean);
  return std::sqrt(1 + 1 / n + (at - mean) * (at - mean) / spread);
}

/// How far sample i is off the line of samples [first, last], in units in which
/// samples in the middle and at the ends of a track compare.
Residual offTheLine(const Trajectory& track, std::size_t i, std::size_t first, std::size_t last) {
  // In the frame of the rotation's medoid, the sample nearest to all others and
  // never an outlier: medians by axis depend on the axes, and those of the fixed
  // frame would let its choice decide.
  std::size_t medoid = first;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t j = first; j <= last; ++j) {
    double sum = 0;
    for (std::size_t k = first; k <= last; ++k) {
      sum += rotationAngle(track.poses[j].rotation.conjugate() * track.poses[k].rotation);
    }
    if (sum < least) {
      least = sum;
      medoid = j;
    }
  }
  const Pose medoid_T_world = track.poses[medoid].inverse();
  std::vector<double> times;
  std::vector<double> values[6];
  for (std::size_t j = first; j <= last; ++j) {
    if (j == i) continue;
    times.push_back(track.times[j]);
    const Vec<double, 6> off = poseError(medoid_T_world * track.poses[j]);
    for (int k = 0; k < 6; ++k) values[k].push_back(off[k]);
  }
  Vec<double, 6> line;
  for (int k = 0; k < 6; ++k) line[k] = repeatedMedianLine(times, values[k], track.times[i]);
  const Pose here = medoid_T_world * track.poses[i];
  const Eigen::Quaterniond rotation = expSO3<double>(line.tail<3>());
  const double scale = 1 / predictionSigma(times, track.times[i]);
  return {scale * (here.translation - line.head<3>()).norm(),
          scale * rotationAngle(rotation.conjugate() * here.rotation)};
}

/// First sample of the window by which sample i is judged: around it, but where that
/// spans an occlusion (more than twice the usual time) the window with i that lasts
/// least, for nobody saw that the motion across it was straight.
std::size_t windowAround(const std::vector<double>& times, std::size_t i, std::size_t window,
                         double usual_span) {
  const std::size_t n = times.size();
  const auto span = [&](std::size_t first) { return times[first + window - 1] - times[first]; };
  std::size_t best = std::min(i - std::min(i, window / 2), n - window);
  if (span(best) <= 2 * usual_span) return best;
  const std::size_t last = std::min(i, n - window);
  for (std::size_t first = i - std::min(i, window - 1); first <= last; ++first) {
    if (span(first) < span(best)) best = first;
  }
  return best;
}

/// Marks samples whose residual is neither small nor usual.
void markSpikes(const std::vector<double>& residuals, double sigmas, double least,
                std::size_t window, std::vector<char>& keep) {
  const std::size_t n = residuals.size();
  const double usual = medianOf(residuals) / kMedianChi3;
  for (std::size_t i = 0; i < n; ++i) {
    if (residuals[i] <= std::max(least, sigmas * usual)) continue;
    const std::size_t first = std::min(i - std::min(i, window / 2), n - window);
    const auto begin = residuals.begin() + static_cast<std::ptrdiff_t>(first);
    const double local =
        medianOf(std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(window))) /
        kMedianChi3;
    if (residuals[i] > sigmas * local) keep[i] = 0;
  }
}

void describe(const char* name, const CleanCounts& counts, std::string& text) {
  if (counts.dropped() == 0) return;
  text += (text.empty() ? "" : "; ") + std::string(name) + ": " + std::to_string(counts.dropped()) +
          " of " + std::to_string(counts.samples) + " poses dropped (" +
          std::to_string(counts.speed) + " too fast, " + std::to_string(counts.spikes) +
          " off the line of their neighbours)";
}

}  // namespace

CleanCounts removeOutliers(Trajectory& track, const SpeedLimit& limit,
                           const CleanOptions& options) {
  CleanCounts counts;
  counts.samples = track.size();
  if (track.size() < kFewest) return counts;
  const std::vector<char> chain = longestChain(track, limit);
  const auto kept = static_cast<std::size_t>(std::count(chain.begin(), chain.end(), 1));
  if (2 * kept < track.size()) {
    throw Error(ExitCode::kInput,
                "only " + std::to_string(kept) + " of " + std::to_string(track.size()) +
                    " poses are consistent with motion of at most " + formatDouble(limit.linear) +
                    " m/s and " + formatDouble(limit.angular) +
                    " rad/s; it is unclear which are right");
  }
  counts.speed = track.size() - kept;
  keepOnly(track, chain);

  const std::size_t n = track.size();
  const std::size_t window = std::min(options.window, n);
  if (window < kFewest) return counts;
  std::vector<double> spans;
  for (std::size_t i = 0; i + window <= n; ++i) {
    spans.push_back(track.times[i + window - 1] - track.times[i]);
  }
  const double usual_span = medianOf(spans);
  std::vector<double> shifts(n);
  std::vector<double> turns(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t first = windowAround(track.times, i, window, usual_span);
    const Residual residual = offTheLine(track, i, first, first + window - 1);
    shifts[i] = residual.shift;
    turns[i] = residual.turn;
  }
  std::vector<char> keep(n, 1);
  markSpikes(shifts, options.sigmas, options.least_shift, window, keep);
  markSpikes(turns, options.sigmas, options.least_turn, window, keep);
  counts.spikes = static_cast<std::size_t>(std::count(keep.begin(), keep.end(), 0));
  keepOnly(track, keep);
  return counts;
}

std::string CleanReport::text() const {
  std::string all;
  describe("hand", hand, all);
  describe("object", object, all);
  describe("torso", torso, all);
  return all;
}

CleanReport removeOutliers(Demonstration& demonstration, const CleanOptions& options) {
  const auto clean = [&](const char* name, Trajectory& track, const SpeedLimit& limit) {
    try {
      const std::vector<double> stamps = track.times;
      const CleanCounts counts = removeOutliers(track, limit, options);
      std::set_difference(stamps.begin(), stamps.end(), track.times.begin(), track.times.end(),
                          std::back_inserter(demonstration.dropped_stamps));
      return counts;
    } catch (const Error& error) {
      throw Error(error.code(), "demonstration " + quoted(demonstration.name) + ", " + name +
                                    " track: " + error.what());
    }
  };
  CleanReport report;
  report.hand = clean("hand", demonstration.hand, options.hand);
  report.object = clean("object", demonstration.object, options.object);
  report.torso = clean("torso", demonstration.torso, options.torso);
  return report;
}

}  // namespace graft::lfd
