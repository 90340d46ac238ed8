// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "types_lfd/demo/match.hpp"

namespace graft::lfd {

/// Where the hand holds the object, coarsely: the run of tuples in which the
/// hand stays at one point of the object while the object is moved.
struct ContactRun {
  bool object_moved = false;     ///< false: nothing below is set
  std::size_t motion_first = 0;  ///< tuples at which the object's motion shows first, last
  std::size_t motion_last = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< contact point in the object frame, m
  double spread = 0;      ///< robust sigma of the hand's distance to it while held, m
  std::size_t first = 0;  ///< first and last tuple of the run
  std::size_t last = 0;
};

/// Position of the hand in the object frame per tuple, m. The rotation is left
/// out on purpose: of a hand tracker it is by far the noisier half (10 to 20
/// degrees), and a hand that turns on the handle still holds it.
std::vector<Eigen::Vector3d> handInObject(const MatchedDemonstration& matched);

/// Per tuple 1 where hand and object are measured or interpolated between
/// neighbouring samples, 0 where either is interpolated across an occlusion: a
/// gap of more than 2.5 of the track's median intervals. A straight line across
/// an occlusion looks like motion, or rest, that nobody saw.
std::vector<char> seenTuples(const MatchedDemonstration& matched);

/// Finds the contact run: the point of the object at which the hand is most
/// often while the object moves, and the run of tuples there (within 4.3 of its
/// spread, at least 1 cm) that covers most of that motion.
/// The object counts as moved where it is away from its first pose (median of
/// the first 0.3 s, at least 5 tuples) by `distance` m or `angle` rad, or by
/// five times its white noise where that is more. When that motion begins is
/// traced back to a sixth of it (again at least five times the noise) from
/// where a fifth of the whole way is done, so that a burst of noise while the
/// object rests begins nothing; its end likewise in reverse.
ContactRun findContact(const MatchedDemonstration& matched, double distance, double angle);

}  // namespace graft::lfd
