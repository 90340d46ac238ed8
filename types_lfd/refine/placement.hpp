// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "types_lfd/build/scene.hpp"
#include "types_lfd/eval/metrics.hpp"
#include "types_lfd/robot/arm_ik.hpp"

namespace graft::lfd {

/// How far a base stands from where the optimizer left it: along the axes that
/// the base has at the grasp (m; the same for the whole demonstration, and moving
/// with the scene), and yaw (rad).
struct BaseOffset {
  double x = 0;
  double y = 0;
  double yaw = 0;

  bool zero() const { return x == 0 && y == 0 && yaw == 0; }
  /// Distance, a turn counted as the way of a point 0.3 m from the centre (the
  /// radius of a mobile robot's base).
  double length() const;
  BaseOffset operator-(const BaseOffset& o) const { return {x - o.x, y - o.y, yaw - o.yaw}; }
};

/// (1 - f) a + f b; exactly a or b where both are equal.
BaseOffset interpolate(const BaseOffset& a, const BaseOffset& b, double f);

/// Base and arm at one tuple; `joints` is empty where no solution is known.
struct Placed {
  BaseOffset offset;
  Eigen::VectorXd joints;
  bool solved() const { return joints.size() > 0; }
};

/// What may be done at the tuples of one demonstration.
class Placement {
 public:
  /// The arguments must outlive it.
  Placement(const DemonstrationEstimate& demo, const TaskScene& scene);

  std::size_t size() const { return demo_.size(); }
  double seconds(std::size_t a, std::size_t b) const { return demo_.times[b] - demo_.times[a]; }
  const Chain& chain() const { return *scene_.chain; }

  /// From now on arms are solved with the height joint held at this value; not
  /// a number = free. Without effect on a chain that has none.
  void holdHeight(double height);

  Pose2 base(std::size_t i, const BaseOffset& offset) const;
  /// What the arm is solved for: base_T_gripper, of rounded poses.
  Pose baseToGripper(std::size_t i, const BaseOffset& offset) const;
  /// Offset of a tuple on the way between two others: none if neither has one,
  /// else the straight way of the base (jumps of the optimized one are left out).
  BaseOffset between(std::size_t i, std::size_t begin, const BaseOffset& at_begin, std::size_t end,
                     const BaseOffset& at_end) const;
  /// Free of the map and within the reachability map.
  bool stands(std::size_t i, const BaseOffset& offset) const;
  bool collides(std::size_t i, const BaseOffset& offset) const;
  bool reaches(std::size_t i, const BaseOffset& offset) const;
  /// No collision on the way from tuple i to i + 1.
  bool wayFree(std::size_t i, const BaseOffset& a, const BaseOffset& b) const;
  /// Shoulder sees wrist and gripper.
  bool sees(std::size_t i, const Placed& placed) const;
  /// Solves the arm from a start; nothing if that fails or a wall is between.
  std::optional<Eigen::VectorXd> solveArm(std::size_t i, const BaseOffset& offset,
                                          const Eigen::VectorXd& start) const;
  /// The same with every joint within `factor` of its speed from both
  /// neighbours (either may be null).
  std::optional<Eigen::VectorXd> solveArmBetween(std::size_t i, const BaseOffset& offset,
                                                 const Eigen::VectorXd& start,
                                                 const Eigen::VectorXd* before,
                                                 const Eigen::VectorXd* after, double factor) const;
  /// What turns joints a into b; continuous joints go the short way round.
  Eigen::VectorXd jointStep(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;
  /// Largest ratio of a joint's speed to its limit.
  double speedRatio(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double seconds) const;
  /// Ratio of the base's speed from tuple a to b to what a mobile robot does at
  /// a walk: 1.5 m/s, 2 rad/s.
  double baseSpeedRatio(std::size_t a, const BaseOffset& at_a, std::size_t b,
                        const BaseOffset& at_b) const;
  /// Postures of the arm far from each other, found at some tuples.
  std::vector<Eigen::VectorXd> findPostures(std::uint64_t seed) const;

 private:
  /// Base as the one at the grasp sees it; its axes are those of offsets.
  Pose2 seenBase(std::size_t i, const BaseOffset& offset) const;

  const DemonstrationEstimate& demo_;
  const TaskScene& scene_;
  IkBox box_;
  IkOptions ik_;
  double cosine_ = 1;  ///< of the heading of the offsets' axes
  double sine_ = 0;
  std::vector<Pose2> base_;    ///< where the base at the grasp sees them, rounded
  std::vector<Pose> gripper_;  ///< the same
};

}  // namespace graft::lfd
