// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <vector>

#include "types_lfd/reach/reach_marks.hpp"
#include "types_lfd/robot/chain.hpp"
#include "types_lfd/robot/self_collision.hpp"

namespace graft::lfd {

/// Marks voxels from random joint vectors, at exactly the orientations of the
/// nodes: each joint vector is first corrected (Newton's method, within the
/// limits) until its gripper has the nearest node's orientation.
///
/// Joints whose effect is known in closed form are not sampled but swept: a
/// torso (height), a first joint about the vertical (psi, the base moving on a
/// circle), a last joint about the approach axis (roll).
///
/// Where the chain tests for self-collision, only configurations in which the robot
/// does not hit itself are marked: pan angles singly, heights voxel by voxel. The
/// last roll's own solids are tested as they stand at 0, or the limit nearest to it.
///
/// Arms with less than six freedoms cannot be corrected: what they reach is
/// thin. There all nodes around each sample are marked.
class ReachSampler {
 public:
  ReachSampler(const Chain& chain, const ReachGrid& grid, bool thin, double best_manipulability);

  /// Draws and marks `count` joint vectors.
  void run(std::mt19937_64& random, std::uint64_t count, ReachMarks& marks) const;

 private:
  struct Range {
    double low;
    double high;
  };
  struct Sample;

  bool toNode(Sample& sample) const;
  bool armHitsItself(Sample& sample) const;
  /// Sets the sample's clear heights for a turn of the pan joint.
  void findClear(Sample& sample, double turn, double voxel) const;
  void markRing(Sample& sample, ReachMarks& marks) const;
  void markPole(Sample& sample, std::mt19937_64& random, ReachMarks& marks) const;
  void markAround(Sample& sample, ReachMarks& marks) const;
  /// `position`: of the gripper seen from the base, which looks along psi.
  void mark(const Sample& sample, const Eigen::Vector2d& position, int ring, int roll, int psi,
            ReachMarks& marks) const;
  std::uint8_t quality(const Sample& sample) const;
  int wrapPsi(int psi) const;

  const Chain& chain_;
  ReachGrid grid_;
  bool thin_;
  double best_;
  int torso_;
  int pan_;
  bool rolls_;
  Range heights_{0, 0};
  Range pans_{0, 0};
  Range roll_range_{0, 0};
  Eigen::Vector2d pan_origin_ = Eigen::Vector2d::Zero();
  std::vector<int> sampled_;  // joints that are not swept
  // Pairs of solids that no swept joint, the pan but not the torso, and the torso move.
  SelfCollision::Subset arm_pairs_;
  SelfCollision::Subset pan_pairs_;
  SelfCollision::Subset torso_pairs_;
};

/// True if every roll of the gripper is as good as any other.
bool anyRoll(const Chain& chain);

/// Yoshikawa's manipulability: the product of the Jacobian's singular values.
/// Source: Yoshikawa, "Manipulability of robotic mechanisms", IJRR 1985.
double manipulability(const Chain::Jacobian& jacobian);

}  // namespace graft::lfd
