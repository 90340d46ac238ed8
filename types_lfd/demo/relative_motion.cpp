// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/relative_motion.hpp"

#include <algorithm>
#include <cmath>

#include "types_lfd/demo/accuracy.hpp"
#include "types_lfd/demo/statistics.hpp"

namespace graft::lfd {

namespace {

// Time at rest over which the object's first and last pose are averaged, s.
constexpr double kRestWindow = 0.3;
constexpr std::size_t kFewestAtRest = 5;
// Tuples in a row that have to agree before a change counts: one outlier that
// cleaning missed must not start a segment.
constexpr std::size_t kAgreeing = 3;
constexpr double kGapIntervals = 2.5;
constexpr double kNoiseFactor = 5;
// 4.3 sigma hold 99.97 % of the lengths of 3-D vectors.
constexpr double kWithin = 4.3;
// Hands slip on what they hold by up to about this, m.
constexpr double kLeastRadius = 0.02;
// Over this time an object that is moved by a person shows it, s.
constexpr double kMotionWindow = 0.5;
constexpr double kOnset = 1.0 / 6;
constexpr double kClearShare = 0.2;

/// Pose in the middle of a set: medians of translation and rotation vector as
/// seen from the first, whose axes, unlike the fixed frame's, move with the scene.
Pose medianPose(const std::vector<Pose>& poses, std::size_t first, std::size_t last) {
  const Pose first_T_world = poses[first].inverse();
  std::vector<double> values[6];
  for (std::size_t i = first; i <= last; ++i) {
    const Vec<double, 6> off = poseError(first_T_world * poses[i]);
    for (int k = 0; k < 6; ++k) values[k].push_back(off[k]);
  }
  Vec<double, 6> middle;
  for (int k = 0; k < 6; ++k) middle[k] = medianOf(std::move(values[k]));
  return poses[first] * Pose(middle.head<3>(), expSO3<double>(middle.tail<3>()));
}

/// White noise of a track; none where it is too short to tell.
TrackerAccuracy noiseOf(const std::vector<double>& times, const MatchedTrack& track) {
  Trajectory measured;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (track.measured[i] == 0) continue;
    measured.times.push_back(times[i]);
    measured.poses.push_back(track.poses[i]);
  }
  return measured.size() < 5 ? TrackerAccuracy() : estimateAccuracy(measured);
}

/// How far each pose is from where the object rests at the begin of `poses`.
struct Displacement {
  std::vector<double> away;  ///< 1 counts as moved
  double onset = 0;          ///< above this it is more than noise
};

Displacement displacement(const std::vector<Pose>& poses, std::size_t rest_last,
                          const TrackerAccuracy& noise, double distance, double angle) {
  const Pose reference = medianPose(poses, 0, rest_last);
  const double shift_noise = kNoiseFactor * noise.sigma_t;
  const double turn_noise = kNoiseFactor * noise.sigma_r;
  const double shift_unit = std::max(distance, shift_noise);
  const double turn_unit = std::max(angle, turn_noise);
  Displacement result;
  result.onset = std::max({kOnset, shift_noise / shift_unit, turn_noise / turn_unit});
  for (const Pose& pose : poses) {
    const double shift = (pose.translation - reference.translation).norm();
    const double turn = rotationAngle(reference.rotation.conjugate() * pose.rotation);
    result.away.push_back(std::max(shift / shift_unit, turn / turn_unit));
  }
  return result;
}

/// Index at which the motion away from rest shows first; size if there is none.
std::size_t motionOnset(const Displacement& displacement) {
  const std::vector<double>& away = displacement.away;
  const double furthest = *std::max_element(away.begin(), away.end());
  const double clear = std::max(1.0, kClearShare * furthest);
  std::size_t agreeing = 0;
  for (std::size_t i = 0; i < away.size(); ++i) {
    agreeing = away[i] > clear ? agreeing + 1 : 0;
    if (agreeing < kAgreeing) continue;
    std::size_t onset = i + 1 - kAgreeing;
    while (onset > 0 && away[onset - 1] > displacement.onset) --onset;
    return onset;
  }
  return away.size();
}

/// Per tuple 1 where the object moves by more than its noise within the window.
std::vector<char> movingTuples(const MatchedDemonstration& matched, const TrackerAccuracy& noise) {
  const std::size_t n = matched.size();
  const double least_shift = std::max(kNoiseFactor * noise.sigma_t, 0.01 * kMotionWindow);
  const double least_turn = std::max(kNoiseFactor * noise.sigma_r, 0.03 * kMotionWindow);
  std::vector<char> moving(n, 0);
  std::size_t from = 0;
  std::size_t to = 0;
  for (std::size_t i = 0; i < n; ++i) {
    while (matched.times[from] < matched.times[i] - 0.5 * kMotionWindow) ++from;
    while (to + 1 < n && matched.times[to + 1] <= matched.times[i] + 0.5 * kMotionWindow) ++to;
    const Pose& a = matched.object.poses[from];
    const Pose& b = matched.object.poses[to];
    moving[i] = static_cast<char>((b.translation - a.translation).norm() > least_shift ||
                                  rotationAngle(a.rotation.conjugate() * b.rotation) > least_turn);
  }
  return moving;
}

/// The place on the object at which the hand is found most often while the
/// object moves: the mode, not the median, as an object may also be moved by
/// something else for longer. Medians of the points within `radius` of it.
Eigen::Vector3d densestPoint(const std::vector<Eigen::Vector3d>& points,
                             const std::vector<char>& moving, const ContactRun& contact,
                             double radius) {
  std::vector<std::size_t> candidates;
  for (std::size_t i = contact.motion_first; i <= contact.motion_last; ++i) {
    if (moving[i] != 0) candidates.push_back(i);
  }
  if (candidates.empty()) {
    for (std::size_t i = contact.motion_first; i <= contact.motion_last; ++i) {
      candidates.push_back(i);
    }
  }
  std::size_t best_count = 0;
  std::size_t best = candidates.front();
  for (const std::size_t i : candidates) {
    const auto count = static_cast<std::size_t>(std::count_if(
        candidates.begin(), candidates.end(),
        [&](std::size_t j) { return (points[j] - points[i]).squaredNorm() < radius * radius; }));
    if (count > best_count) {
      best_count = count;
      best = i;
    }
  }
  Eigen::Vector3d middle;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const std::size_t j : candidates) {
      if ((points[j] - points[best]).norm() < radius) values.push_back(points[j][k]);
    }
    middle[k] = medianOf(std::move(values));
  }
  return middle;
}

/// Longest run of tuples whose distance stays below `limit`, measured by how
/// much of [motion_first, motion_last] it covers; single tuples above the limit
/// do not end it.
void growRun(const std::vector<double>& distance, double limit, ContactRun& contact) {
  const std::size_t n = distance.size();
  std::size_t best = 0;
  std::size_t i = 0;
  while (i < n) {
    if (distance[i] > limit) {
      ++i;
      continue;
    }
    std::size_t last = i;
    std::size_t outside = 0;
    for (std::size_t j = i + 1; j < n && outside < kAgreeing; ++j) {
      outside = distance[j] > limit ? outside + 1 : 0;
      if (outside == 0) last = j;
    }
    const std::size_t from = std::max(i, contact.motion_first);
    const std::size_t to = std::min(last, contact.motion_last);
    const std::size_t covered = to >= from ? to - from + 1 : 0;
    if (covered > best) {
      best = covered;
      contact.first = i;
      contact.last = last;
    }
    i = last + 1;
  }
}

/// Clears the tuples that a track covers only by interpolation across a gap.
void clearGaps(const std::vector<double>& times, const MatchedTrack& track,
               std::vector<char>& seen) {
  std::vector<std::size_t> measured;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (track.measured[i] != 0) measured.push_back(i);
  }
  if (measured.size() < 2) return;
  std::vector<double> intervals;
  for (std::size_t k = 1; k < measured.size(); ++k) {
    intervals.push_back(times[measured[k]] - times[measured[k - 1]]);
  }
  const double longest = kGapIntervals * medianOf(intervals);
  for (std::size_t k = 1; k < measured.size(); ++k) {
    if (intervals[k - 1] <= longest) continue;
    for (std::size_t i = measured[k - 1] + 1; i < measured[k]; ++i) seen[i] = 0;
  }
}

}  // namespace

std::vector<Eigen::Vector3d> handInObject(const MatchedDemonstration& matched) {
  std::vector<Eigen::Vector3d> points(matched.size());
  for (std::size_t i = 0; i < matched.size(); ++i) {
    points[i] = matched.object.poses[i].inverse() * matched.hand.poses[i].translation;
  }
  return points;
}

std::vector<char> seenTuples(const MatchedDemonstration& matched) {
  std::vector<char> seen(matched.size(), 1);
  clearGaps(matched.times, matched.hand, seen);
  clearGaps(matched.times, matched.object, seen);
  return seen;
}

ContactRun findContact(const MatchedDemonstration& matched, double distance, double angle) {
  ContactRun contact;
  const std::size_t n = matched.size();
  const std::vector<Pose>& object = matched.object.poses;
  const TrackerAccuracy noise = noiseOf(matched.times, matched.object);
  // Last index, counted from either end, that belongs to the rest there.
  const auto restLast = [&](bool forward) {
    const auto elapsed = [&](std::size_t k) {
      return forward ? matched.times[k] - matched.times[0]
                     : matched.times[n - 1] - matched.times[n - 1 - k];
    };
    std::size_t k = 0;
    while (k + 1 < n && (k + 1 < kFewestAtRest || elapsed(k + 1) <= kRestWindow)) ++k;
    return k;
  };
  contact.motion_first = motionOnset(displacement(object, restLast(true), noise, distance, angle));
  const std::vector<Pose> reversed(object.rbegin(), object.rend());
  const std::size_t from_end =
      motionOnset(displacement(reversed, restLast(false), noise, distance, angle));
  if (contact.motion_first == n || from_end == n) return contact;
  contact.motion_last = n - 1 - from_end;
  if (contact.motion_last <= contact.motion_first) return contact;
  contact.object_moved = true;

  const double hand_sigma = noiseOf(matched.times, matched.hand).sigma_t;
  const double radius = std::max(kLeastRadius, kWithin * std::hypot(hand_sigma, noise.sigma_t));
  const std::vector<Eigen::Vector3d> points = handInObject(matched);
  contact.point = densestPoint(points, movingTuples(matched, noise), contact, radius);
  std::vector<double> from_contact(n);
  std::vector<double> held;
  for (std::size_t i = 0; i < n; ++i) {
    from_contact[i] = (points[i] - contact.point).norm();
    const bool inside = i >= contact.motion_first && i <= contact.motion_last;
    if (inside && from_contact[i] < 2 * radius) held.push_back(from_contact[i]);
  }
  contact.spread = medianOf(std::move(held)) / kMedianChi3;
  // Below 1 cm it is the palm that gives way, not the hand that leaves.
  growRun(from_contact, std::max(0.01, kWithin * contact.spread), contact);
  return contact;
}

}  // namespace graft::lfd
