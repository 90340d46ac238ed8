// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/relative_motion.hpp"

#include <algorithm>
#include <cmath>

namespace graft::lfd {

namespace {

// Time at rest over which the object's first and last pose are averaged, s.
constexpr double kRestWindow = 0.3;
// Tuples in a row that have to agree before a change counts: one outlier that
// cleaning missed must not start a segment.
constexpr std::size_t kAgreeing = 3;

/// Pose in the middle of a set: medians of translation, and of the rotation
/// vectors relative to the first.
Pose medianPose(const std::vector<Pose>& poses, std::size_t first, std::size_t last) {
  Vec<double, 6> middle;
  for (int k = 0; k < 6; ++k) {
    std::vector<double> values;
    for (std::size_t i = first; i <= last; ++i) {
      const Pose& pose = poses[i];
      values.push_back(k < 3 ? pose.translation[k]
                             : logSO3(Eigen::Quaterniond(poses[first].rotation.conjugate() *
                                                         pose.rotation))[k - 3]);
    }
    middle[k] = medianOf(std::move(values));
  }
  return Pose(middle.head<3>(), poses[first].rotation * expSO3<double>(middle.tail<3>()));
}

/// How far each pose is from a reference, in units in which 1 counts as moved.
std::vector<double> displacement(const std::vector<Pose>& poses, const Pose& reference,
                                 std::size_t rest_first, std::size_t rest_last, double distance,
                                 double angle) {
  std::vector<double> shift(poses.size());
  std::vector<double> turn(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    shift[i] = (poses[i].translation - reference.translation).norm();
    turn[i] = rotationAngle(reference.rotation.conjugate() * poses[i].rotation);
  }
  const auto noise = [&](const std::vector<double>& values) {
    return medianOf(
        std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(rest_first),
                            values.begin() + static_cast<std::ptrdiff_t>(rest_last) + 1));
  };
  // The median length of a noise vector is 1.54 sigma per axis; 5 sigma.
  const double shift_unit = std::max(distance, 5 / 1.538 * noise(shift));
  const double turn_unit = std::max(angle, 5 / 1.538 * noise(turn));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    shift[i] = std::max(shift[i] / shift_unit, turn[i] / turn_unit);
  }
  return shift;
}

/// First index from which on `kAgreeing` values in a row exceed 1; size if none.
std::size_t firstSustained(const std::vector<double>& values) {
  std::size_t agreeing = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    agreeing = values[i] > 1 ? agreeing + 1 : 0;
    if (agreeing == kAgreeing) return i + 1 - kAgreeing;
  }
  return values.size();
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

}  // namespace

double medianOf(std::vector<double> values) {
  const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  if (values.size() % 2 == 1) return *half;
  return 0.5 * (*half + *std::max_element(values.begin(), half));
}

std::vector<Eigen::Vector3d> handInObject(const MatchedDemonstration& matched) {
  std::vector<Eigen::Vector3d> points(matched.size());
  for (std::size_t i = 0; i < matched.size(); ++i) {
    points[i] = matched.object.poses[i].inverse() * matched.hand.poses[i].translation;
  }
  return points;
}

ContactRun findContact(const MatchedDemonstration& matched, double distance, double angle) {
  ContactRun contact;
  const std::size_t n = matched.size();
  const std::vector<Pose>& object = matched.object.poses;
  std::size_t head = 0;
  while (head + 1 < n && matched.times[head + 1] <= matched.times[0] + kRestWindow) ++head;
  std::size_t tail = n - 1;
  while (tail > 0 && matched.times[tail - 1] >= matched.times[n - 1] - kRestWindow) --tail;

  std::vector<double> away =
      displacement(object, medianPose(object, 0, head), 0, head, distance, angle);
  contact.motion_first = firstSustained(away);
  std::vector<double> to_go =
      displacement(object, medianPose(object, tail, n - 1), tail, n - 1, distance, angle);
  std::reverse(to_go.begin(), to_go.end());
  const std::size_t from_end = firstSustained(to_go);
  if (contact.motion_first == n || from_end == n) return contact;
  contact.motion_last = n - 1 - from_end;
  if (contact.motion_last <= contact.motion_first) return contact;
  contact.object_moved = true;

  const std::vector<Eigen::Vector3d> points = handInObject(matched);
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (std::size_t i = contact.motion_first; i <= contact.motion_last; ++i) {
      values.push_back(points[i][k]);
    }
    contact.point[k] = medianOf(std::move(values));
  }
  std::vector<double> from_contact(n);
  for (std::size_t i = 0; i < n; ++i) from_contact[i] = (points[i] - contact.point).norm();
  contact.spread =
      medianOf(std::vector<double>(
          from_contact.begin() + static_cast<std::ptrdiff_t>(contact.motion_first),
          from_contact.begin() + static_cast<std::ptrdiff_t>(contact.motion_last) + 1)) /
      1.538;
  // Three sigma of a 3-D distance (99.97 % is at 4.3); below 1 cm it is the
  // palm that gives way, not the hand that leaves.
  growRun(from_contact, std::max(0.01, 4.3 * contact.spread), contact);
  return contact;
}

}  // namespace graft::lfd
