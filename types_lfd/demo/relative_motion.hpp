// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "types_lfd/demo/match.hpp"

namespace graft::lfd {

/// Median of values; must not be empty.
double medianOf(std::vector<double> values);

/// Where the hand holds the object, coarsely: the run of tuples in which the
/// hand stays at one point of the object while the object is moved.
struct ContactRun {
  bool object_moved = false;     ///< false: nothing below is set
  std::size_t motion_first = 0;  ///< tuples between which the object moves
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

/// Finds the contact run. The object counts as moved where it leaves its first
/// pose (median of the first 0.3 s) by `distance` m or `angle` rad, or by five
/// times its own noise where that is more.
ContactRun findContact(const MatchedDemonstration& matched, double distance, double angle);

}  // namespace graft::lfd
