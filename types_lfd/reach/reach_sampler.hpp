// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <vector>

#include "types_lfd/reach/reach_marks.hpp"
#include "types_lfd/robot/chain.hpp"

namespace graft::lfd {

/// Marks cells from random joint vectors. A cell is reachable if its centre is,
/// within a share `core` of the cell in each direction: marking a cell for any
/// pose in it would let a map reach up to a cell further than the arm.
///
/// Joints whose effect on the cell is known in closed form are not sampled but
/// swept, and hit centres exactly: a torso (height), a first joint about the
/// vertical (psi, with the base moving on a circle), a last joint about the
/// approach axis (roll; in a cap, where roll turns the heading, psi).
class ReachSampler {
 public:
  ReachSampler(const Chain& chain, const ReachGrid& grid, double core, double best_manipulability);

  /// Draws and marks `count` joint vectors.
  void run(std::mt19937_64& random, std::uint64_t count, ReachMarks& marks) const;

 private:
  struct Range {
    double low;
    double high;
  };
  struct Sample;

  void markRing(const Sample& sample, ReachMarks& marks) const;
  void markCap(const Sample& sample, std::mt19937_64& random, ReachMarks& marks) const;
  void mark(const Sample& sample, double x, double y, int psi, Range rolls,
            ReachMarks& marks) const;
  std::uint8_t quality(const Sample& sample) const;
  /// Can the angle be brought within half a core of `target` by adding
  /// something of the range?
  bool turnsTo(double angle, double target, Range range) const;

  const Chain& chain_;
  ReachGrid grid_;
  double half_core_;
  double half_core_angle_;
  double best_;
  int torso_;
  int pan_;
  bool rolls_;
  Range heights_{0, 0};
  Range pans_{0, 0};
  Range roll_range_{0, 0};
  Eigen::Vector2d pan_origin_ = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> turned_pan_origin_;  // per psi
};

/// Yoshikawa's manipulability: the product of the Jacobian's singular values.
/// Source: Yoshikawa, "Manipulability of robotic mechanisms", IJRR 1985.
double manipulability(const Chain::Jacobian& jacobian);

}  // namespace graft::lfd
