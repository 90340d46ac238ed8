// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "types_lfd/model/motion_model.hpp"
#include "types_lfd/motion/time_scaling.hpp"

namespace graft::lfd {

/// One sample of a generated motion, in the world frame.
struct MotionPoint {
  double time = 0;  ///< s from the start of the whole motion
  Pose gripper;
  Pose2 base;       ///< yaw continuous over the motion, not wrapped
  int segment = 0;  ///< index into the model's segments; a joint belongs to the earlier one
  int action = 0;   ///< index into the chain of models
  /// What the demonstrations leave open here: covariance of the regression as
  /// that of the poses (see SegmentChart::decodeCovariance).
  Mat<double, kStateDimension> covariance = Mat<double, kStateDimension>::Zero();
};

struct ReproduceOptions {
  double rate = 50;  ///< samples per second
  SpeedLimits limits;
  /// Where the robot stands; default: where the demonstrations start.
  std::optional<Pose> start_gripper;
  std::optional<Pose2> start_base;
  /// The grasp to end reaching at; default: the mean of the demonstrations.
  std::optional<Pose> object_T_gripper;
  /// A start that differs from the demonstrations' is blended out over this share
  /// of reaching; from then on the approach is the demonstrated one.
  double blend_share = 0.8;
};

/// A learned model and where its object stands now.
struct PlacedModel {
  MotionModel model;
  Pose world_T_object;
};

/// Generates the motion of a learned task for an object at world_T_object: the
/// regression of every segment, moved to the object, its ends carried to the
/// common states between the segments (and to the start given) by offsets that
/// fade with the minimum-jerk polynomial (Flash and Hogan 1985), and brought to
/// rest there, where the gripper closes and opens; then slowed down where a speed
/// limit asks for it, and sampled. The first point is the start and
/// the end of every segment is a point. The path depends on the start only while
/// the offset fades, so the grasp is met exactly from anywhere. Throws
/// Error(kUsage) for options out of range, Error(kNoResult) for a model without
/// segments, Error(kResources) for more than ten million samples.
std::vector<MotionPoint> reproduceMotion(const MotionModel& model, const Pose& world_T_object,
                                         const ReproduceOptions& options);

/// The same for several tasks in a row: each starts where the one before ended,
/// without a planner between (paper, experiment D). The start in `options` is
/// that of the first, and so is object_T_gripper.
std::vector<MotionPoint> reproduceChain(const std::vector<PlacedModel>& chain,
                                        const ReproduceOptions& options);

/// Weight that rises from 0 to 1 over s in [0, 1] with no speed and no
/// acceleration at both ends: 10 s^3 - 15 s^4 + 6 s^5, clamped outside.
double minimumJerk(double s);

}  // namespace graft::lfd
