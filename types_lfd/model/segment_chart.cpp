// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/model/segment_chart.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"

namespace graft::lfd {

namespace {

constexpr double kTurn = 2 * 3.14159265358979323846;
/// Shortest projection on the floor that still gives a heading (3 degrees off
/// the vertical).
constexpr double kShortestHeading = 0.05;

/// The rotation vector of the same rotation, whole turns added about its own
/// axis, that lies nearest to `near`.
Vec<double, 3> nearestTurn(const Vec<double, 3>& rotation, const Vec<double, 3>& near) {
  const double angle = rotation.norm();
  if (angle < 1e-9) return rotation;
  const Vec<double, 3> axis = rotation / angle;
  return rotation + axis * (kTurn * std::round((axis.dot(near) - angle) / kTurn));
}

}  // namespace

Pose2 headingFrame(const Pose& world_T_object, int heading_axis) {
  const Vec<double, 3> axis = world_T_object.rotation * Vec<double, 3>::Unit(heading_axis);
  if (std::hypot(axis[0], axis[1]) < kShortestHeading) {
    throw Error(ExitCode::kNoResult,
                "the object's axis that gives its heading on the floor is vertical");
  }
  return Pose2(world_T_object.translation[0], world_T_object.translation[1],
               std::atan2(axis[1], axis[0]));
}

int mostLevelAxis(const std::vector<Pose>& world_T_objects) {
  int best = 0;
  double best_length = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double shortest = 1;
    for (const Pose& pose : world_T_objects) {
      const Vec<double, 3> v = pose.rotation * Vec<double, 3>::Unit(axis);
      shortest = std::min(shortest, std::hypot(v[0], v[1]));
    }
    if (shortest > 1.1 * best_length) {
      best = axis;
      best_length = shortest;
    }
  }
  return best;
}

Eigen::Quaterniond meanRotation(const std::vector<Eigen::Quaterniond>& rotations) {
  if (rotations.empty()) throw Error(ExitCode::kInternal, "mean of no rotations");
  Mat<double, 4> scatter = Mat<double, 4>::Zero();
  for (const auto& q : rotations) scatter += q.coeffs() * q.coeffs().transpose();
  const Eigen::SelfAdjointEigenSolver<Mat<double, 4>> eigen(scatter);
  Eigen::Quaterniond mean(Vec<double, 4>(eigen.eigenvectors().col(3)));
  for (int iteration = 0; iteration < 50; ++iteration) {
    Vec<double, 3> step = Vec<double, 3>::Zero();
    for (const auto& q : rotations) step += logSO3(Eigen::Quaterniond(mean.conjugate() * q));
    step /= static_cast<double>(rotations.size());
    mean = (mean * expSO3<double>(step)).normalized();
    if (step.norm() < 1e-14) break;
  }
  if (mean.w() < 0) mean.coeffs() = -mean.coeffs();
  normalizeQuaternion(mean.coeffs().data());
  return mean;
}

MotionState SegmentChart::encode(const Pose& gripper, const Pose2& base,
                                 const Pose& world_T_object) const {
  const Pose object_T_gripper = world_T_object.inverse() * gripper;
  const Pose2 heading_T_base = headingFrame(world_T_object, heading_axis).inverse() * base;
  MotionState state;
  state.head<3>() = object_T_gripper.translation;
  state.segment<3>(3) =
      logSO3(Eigen::Quaterniond(orientation_mean.conjugate() * object_T_gripper.rotation));
  state[6] = heading_T_base.x;
  state[7] = heading_T_base.y;
  state[8] = wrapAngle(heading_T_base.theta);
  return state;
}

MotionState SegmentChart::encode(const Pose& gripper, const Pose2& base, const Pose& world_T_object,
                                 const MotionState& near) const {
  MotionState state = encode(gripper, base, world_T_object);
  state.segment<3>(3) = nearestTurn(state.segment<3>(3), near.segment<3>(3));
  state[8] = near[8] + wrapAngle(state[8] - near[8]);
  return state;
}

Pose SegmentChart::decodeGripper(const MotionState& state, const Pose& world_T_object) const {
  const Vec<double, 3> turn = state.segment<3>(3);
  Pose gripper = world_T_object * Pose(state.head<3>(), orientation_mean * expSO3<double>(turn));
  gripper.renormalize();
  return gripper;
}

Pose2 SegmentChart::decodeBase(const MotionState& state, const Pose& world_T_object) const {
  return headingFrame(world_T_object, heading_axis) * Pose2(state[6], state[7], state[8]);
}

Mat<double, kStateDimension> SegmentChart::decodeCovariance(
    const MotionState& state, const Mat<double, kStateDimension>& covariance,
    const Pose& world_T_object) const {
  Mat<double, kStateDimension> j = Mat<double, kStateDimension>::Zero();
  j.block<3, 3>(0, 0) = world_T_object.rotation.toRotationMatrix();
  j.block<3, 3>(3, 3) = inverseRightJacobianSO3(state.segment<3>(3)).inverse();
  const double yaw = headingFrame(world_T_object, heading_axis).theta;
  j.block<2, 2>(6, 6) << std::cos(yaw), -std::sin(yaw), std::sin(yaw), std::cos(yaw);
  j(8, 8) = 1;
  const Mat<double, kStateDimension> world = j * covariance * j.transpose();
  return 0.5 * (world + world.transpose());
}

}  // namespace graft::lfd
