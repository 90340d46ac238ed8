// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/torso.hpp"

#include <cmath>

#include "types_lfd/demo/relative_motion.hpp"
#include "types_lfd/demo/segment.hpp"

namespace graft::lfd {

namespace {

// Below this mean way to the contact point its direction is noise, m.
constexpr double kLeastWay = 0.05;

/// Planar unit direction in which the hand approaches the object.
Eigen::Vector2d approachDirection(const MatchedDemonstration& matched) {
  const SegmentOptions segmentation;
  const ContactRun contact =
      findContact(matched, segmentation.moved_distance, segmentation.moved_angle);
  Eigen::Vector2d way = Eigen::Vector2d::Zero();
  Eigen::Vector2d fingers = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < matched.size(); ++i) {
    const Pose& hand = matched.hand.poses[i];
    fingers += (hand.rotation * Eigen::Vector3d::UnitX()).head<2>();
    if (!contact.object_moved || (i >= contact.first && i <= contact.last)) continue;
    const Eigen::Vector2d to_go =
        (matched.object.poses[i] * contact.point - hand.translation).head<2>();
    if (to_go.norm() > kLeastWay) way += to_go;
  }
  if (way.norm() > kLeastWay) return way.normalized();
  // Fingers that point straight down have no planar direction; along x then.
  return fingers.norm() > 1e-9 ? fingers.normalized() : Eigen::Vector2d::UnitX();
}

/// Planar hand position at a tuple, averaged over time with a Gaussian. Weights
/// count the time that a tuple stands for, so bursts of stamps do not pull.
Eigen::Vector2d smoothed(const MatchedDemonstration& matched, std::size_t at, double sigma) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double total = 0;
  const std::size_t n = matched.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double z = (matched.times[i] - matched.times[at]) / sigma;
    if (std::abs(z) > 4) continue;
    const double before = matched.times[i > 0 ? i - 1 : 0];
    const double after = matched.times[i + 1 < n ? i + 1 : n - 1];
    const double weight = std::exp(-0.5 * z * z) * (after - before);
    sum += weight * matched.hand.poses[i].translation.head<2>();
    total += weight;
  }
  return sum / total;
}

}  // namespace

MatchedTrack estimateTorso(const MatchedDemonstration& matched, const TorsoOptions& options) {
  const Eigen::Vector2d direction = approachDirection(matched);
  const double yaw = std::atan2(direction.y(), direction.x());
  const Eigen::Quaterniond rotation = expSO3<double>(Eigen::Vector3d(0, 0, yaw));
  MatchedTrack torso;
  torso.measured.assign(matched.size(), 0);
  for (std::size_t i = 0; i < matched.size(); ++i) {
    const Eigen::Vector2d planar =
        smoothed(matched, i, options.smoothing) - options.distance * direction;
    torso.poses.emplace_back(Eigen::Vector3d(planar.x(), planar.y(), options.height), rotation);
  }
  return torso;
}

}  // namespace graft::lfd
