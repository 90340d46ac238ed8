// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/segment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/text.hpp"
#include "types_lfd/demo/arrival.hpp"
#include "types_lfd/demo/relative_motion.hpp"

namespace graft::lfd {

namespace {

[[noreturn]] void fail(const MatchedDemonstration& matched, const std::string& what) {
  throw Error(ExitCode::kInput, "demonstration " + quoted(matched.name) + ": " + what);
}

std::size_t nearestTuple(const MatchedDemonstration& matched, double time, const char* what) {
  const std::vector<double>& times = matched.times;
  if (!(time >= times.front() && time <= times.back())) {
    fail(matched, std::string(what) + " " + formatDouble(time) +
                      " is outside of the matched span " + formatDouble(times.front()) + " to " +
                      formatDouble(times.back()) + " s");
  }
  const auto after = std::lower_bound(times.begin(), times.end(), time);
  if (after == times.begin()) return 0;
  const auto before = after - 1;
  return static_cast<std::size_t>((time - *before <= *after - time ? before : after) -
                                  times.begin());
}

Segmentation checked(const MatchedDemonstration& matched, const Segmentation& segments) {
  if (segments.grasp < segments.release) return segments;
  fail(matched, "no manipulation between grasp at " + formatDouble(matched.times[segments.grasp]) +
                    " and release at " + formatDouble(matched.times[segments.release]) + " s");
}

/// The hand's way to the contact in one direction of time, as arrival.hpp wants
/// it: clock runs forward to the contact for the grasp, backward for release.
ArrivalSamples samplesTowards(const MatchedDemonstration& matched,
                              const std::vector<Eigen::Vector3d>& points,
                              const std::vector<char>& seen, const ContactRun& contact, bool grasp,
                              const SegmentOptions& options) {
  const std::size_t n = matched.size();
  const auto index = [&](std::size_t k) { return grasp ? k : n - 1 - k; };
  const auto clock = [&](std::size_t k) {
    const double t = matched.times[index(k)];
    return grasp ? t - matched.times.front() : matched.times.back() - t;
  };
  const std::size_t edge = grasp ? contact.first : n - 1 - contact.last;
  const std::size_t far = grasp ? contact.last : n - 1 - contact.first;
  const double middle = 0.5 * (clock(edge) + clock(far));
  const auto distance = [&](std::size_t k) { return (points[index(k)] - contact.point).norm(); };

  // The hand's furthest place before contact, at most one reach earlier.
  double furthest = 0;
  for (std::size_t k = edge; k-- > 0 && clock(k) > clock(edge) - options.longest;) {
    furthest = std::max(furthest, distance(k));
  }
  const double limit = std::min(0.5 * furthest, options.reach);
  std::size_t start = edge;
  while (start > 0 && (distance(start - 1) < limit || start == edge)) --start;
  // Where all of that was hidden, what was seen next to it tells when the hand came.
  constexpr int kTelling = 3;
  int telling = 0;
  for (std::size_t k = start; k < edge; ++k) telling += seen[index(k)] != 0 ? 1 : 0;
  const bool hidden = telling == 0;
  if (hidden) {
    while (start > 0 && telling < kTelling && clock(start - 1) > clock(edge) - options.longest) {
      --start;
      telling += seen[index(start)] != 0 ? 1 : 0;
    }
  }

  ArrivalSamples samples;
  samples.after_peak = !hidden;
  samples.edge = clock(edge);
  for (std::size_t k = start; k <= far; ++k) {
    if (clock(k) > clock(edge) + options.settle && clock(k) > middle) break;
    if (clock(k) > clock(edge) + 2 * options.settle) break;
    samples.all_times.push_back(clock(k));
    samples.distances.push_back(distance(k));
    if (seen[index(k)] == 0) continue;
    samples.times.push_back(clock(k));
    samples.points.push_back(points[index(k)]);
  }
  samples.latest = std::min(middle, clock(edge) + options.settle);
  // What moves is held: contact is not later than the object's first motion,
  // unless that lies so early that something else must have caused it.
  const std::size_t onset = grasp ? contact.motion_first : n - 1 - contact.motion_last;
  if (clock(onset) > clock(edge) - options.settle) {
    samples.latest = std::min(samples.latest, clock(onset));
  }
  return samples;
}

}  // namespace

Segmentation segmentDemonstration(const MatchedDemonstration& matched,
                                  const SegmentOptions& options, std::optional<double> grasp_time,
                                  std::optional<double> release_time) {
  Segmentation segments;
  if (grasp_time) segments.grasp = nearestTuple(matched, *grasp_time, "grasp_time");
  if (release_time) segments.release = nearestTuple(matched, *release_time, "release_time");

  const ContactRun contact = findContact(matched, options.moved_distance, options.moved_angle);
  if (!contact.object_moved) {
    if (grasp_time && release_time) return checked(matched, segments);
    fail(matched, "the object never moves (by " + formatDouble(options.moved_distance) + " m or " +
                      formatDouble(options.moved_angle) + " rad)");
  }
  const std::vector<Eigen::Vector3d> points = handInObject(matched);
  const std::vector<char> seen = seenTuples(matched);
  if (!grasp_time) {
    if (contact.first == 0) {
      fail(matched, "the hand holds the object from the first tuple on; no reaching was recorded");
    }
    const double clock =
        fitArrival(samplesTowards(matched, points, seen, contact, true, options), options);
    segments.grasp = nearestTuple(
        matched,
        std::clamp(matched.times.front() + clock, matched.times.front(), matched.times.back()),
        "grasp");
  }
  if (!release_time) {
    if (contact.last + 1 == matched.size()) {
      segments.release = contact.last;
    } else {
      const double clock =
          fitArrival(samplesTowards(matched, points, seen, contact, false, options), options);
      segments.release = nearestTuple(
          matched,
          std::clamp(matched.times.back() - clock, matched.times.front(), matched.times.back()),
          "release");
    }
  }
  const std::size_t first = std::max(segments.grasp, contact.motion_first);
  const std::size_t last = std::min(segments.release, contact.motion_last);
  segments.motion_share =
      last < first ? 0
                   : static_cast<double>(last - first + 1) /
                         static_cast<double>(contact.motion_last - contact.motion_first + 1);
  return checked(matched, segments);
}

}  // namespace graft::lfd
