// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/geometry/se2.hpp"
#include "core/geometry/se3.hpp"

namespace graft::lfd {

/// Joint pose of gripper and base at one time, in the world frame. The base
/// stands upright on the floor (z = 0).
struct MotionSample {
  double time = 0;
  Pose gripper;
  Pose2 base;
};

/// Coordinates in which motions are learned: gripper position (3, m) and
/// orientation chart (3, rad) in the object's frame, base x, y (m), yaw (rad) in
/// the object's heading frame on the floor.
constexpr int kStateDimension = 9;
using MotionState = Vec<double, kStateDimension>;

/// The frame on the floor below the object: its origin's x and y, x axis along
/// the projection of the object's axis `heading_axis` (0, 1, 2). It moves with the
/// object when that is moved over the floor or turned about the vertical; of a
/// tilt only the turn of the projected axis remains, because the base is planar.
/// Throws Error(kNoResult) where that axis is vertical.
Pose2 headingFrame(const Pose& world_T_object, int heading_axis);

/// The axis whose shortest projection on the floor over all poses is longest;
/// an earlier axis wins unless a later one is longer by a tenth.
int mostLevelAxis(const std::vector<Pose>& world_T_objects);

/// Frechet mean on SO(3): the rotation with the least sum of squared angles to
/// all of them. Signs of the quaternions do not matter. Result has w >= 0.
/// Source: Moakher, "Means and averaging in the group of rotations", 2002, with
/// the eigenvector mean of Markley et al. 2007 as start.
Eigen::Quaterniond meanRotation(const std::vector<Eigen::Quaterniond>& rotations);

/// One coordinate system for all demonstrations of a segment. Orientations q are
/// written as log(orientation_mean^-1 q), which is accurate while they stay
/// within about 90 degrees of the mean, and continuous up to a full turn.
struct SegmentChart {
  int heading_axis = 0;
  Eigen::Quaterniond orientation_mean = Eigen::Quaterniond::Identity();

  /// Coordinates of world poses for an object at world_T_object.
  MotionState encode(const Pose& gripper, const Pose2& base, const Pose& world_T_object) const;
  /// As above, with the turns of rotation vector and yaw nearest to `near`.
  MotionState encode(const Pose& gripper, const Pose2& base, const Pose& world_T_object,
                     const MotionState& near) const;
  Pose decodeGripper(const MotionState& state, const Pose& world_T_object) const;
  /// The yaw is not wrapped: it follows the state's continuously.
  Pose2 decodeBase(const MotionState& state, const Pose& world_T_object) const;
  /// Covariance of a state (9 x 9) as that of world poses: gripper position along
  /// world axes, gripper rotation in the gripper's frame, base x y along world
  /// axes, yaw. First order.
  Mat<double, kStateDimension> decodeCovariance(const MotionState& state,
                                                const Mat<double, kStateDimension>& covariance,
                                                const Pose& world_T_object) const;
};

}  // namespace graft::lfd
