// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "types_lfd/edges/base_pose.hpp"
#include "types_lfd/edges/pose_jacobians.hpp"

namespace graft::lfd {

// Edges along the trajectories of one demonstration. Errors are [translation
// (m); rotation vector (rad)], see poseError().

/// E1, paper eq. 1: e = x^-1 x_hat. Keeps an estimate at its measurement.
struct ObservationEdge : Edge<ObservationEdge, 6, SE3>, Measured<Pose> {
  static constexpr auto tag = "LFD_OBSERVATION";
  static constexpr auto doc = "E1: measured pose of hand, object or torso (paper eq. 1)";
  template <class T>
  Vec<T, 6> error(const SE3<T>& x) const {
    return poseError(measurement.cast<T>().inverse() * x);
  }
  void jacobians(const Pose& x, JacobianBlock<6, 6> by_x) const {
    PoseChainDerivatives(measurement, Pose(), x).byB(by_x);
  }
  bool propagate(int, Pose& x) const {
    x = measurement;
    return true;
  }
};

/// E2, paper eq. 2: e = (x_i^-1 x_j)^-1 (x^_i^-1 x^_j). Keeps the observed
/// motion from one tuple to the next.
struct RelativeMotionEdge : Edge<RelativeMotionEdge, 6, SE3, SE3>, Measured<Pose> {
  static constexpr auto tag = "LFD_RELATIVE_MOTION";
  static constexpr auto doc = "E2: observed motion between consecutive poses (paper eq. 2)";
  template <class T>
  Vec<T, 6> error(const SE3<T>& a, const SE3<T>& b) const {
    return poseError(measurement.cast<T>().inverse() * (a.inverse() * b));
  }
  void jacobians(const Pose& a, const Pose& b, JacobianBlock<6, 6> by_a,
                 JacobianBlock<6, 6> by_b) const {
    const PoseChainDerivatives d(measurement, a, b);
    d.byA(by_a);
    d.byB(by_b);
  }
};

/// E3, paper eq. 3, for the gripper: e = x_i^-1 x_j.
struct GripperSmoothEdge : Edge<GripperSmoothEdge, 6, SE3, SE3> {
  static constexpr auto tag = "LFD_GRIPPER_SMOOTH";
  static constexpr auto doc = "E3: consecutive gripper poses change little (paper eq. 3)";
  template <class T>
  Vec<T, 6> error(const SE3<T>& a, const SE3<T>& b) const {
    return poseError(a.inverse() * b);
  }
  void jacobians(const Pose& a, const Pose& b, JacobianBlock<6, 6> by_a,
                 JacobianBlock<6, 6> by_b) const {
    const PoseChainDerivatives d(Pose(), a, b);
    d.byA(by_a);
    d.byB(by_b);
  }
};

/// E3, paper eq. 3, for the base: e = [dx dy dyaw] of b_i^-1 b_j.
struct BaseSmoothEdge : Edge<BaseSmoothEdge, 3, BasePose, BasePose> {
  static constexpr auto tag = "LFD_BASE_SMOOTH";
  static constexpr auto doc = "E3: consecutive base poses change little (paper eq. 3)";
  template <class T>
  Vec<T, 3> error(const BasePose<T>& a, const BasePose<T>& b) const {
    return poseError(a.inverse() * b);
  }
};

/// The low weight on the base's absolute position (paper, end of IV-C):
/// e = [dx dy dyaw] of z^-1 b, z = the torso made upright.
struct BasePriorEdge : Edge<BasePriorEdge, 3, BasePose>, Measured<SE2<double>> {
  static constexpr auto tag = "LFD_BASE_PRIOR";
  static constexpr auto doc = "base near the demonstrated torso, low weight (paper IV-C)";
  template <class T>
  Vec<T, 3> error(const BasePose<T>& b) const {
    return poseError(measurement.cast<T>().inverse() * b);
  }
};

/// Time steps of three consecutive poses, s.
struct TimeSteps : Numbers<2> {
  static constexpr const char* kFields = "dt_1 dt_2";
  static TimeSteps fromArray(const double* p) {
    TimeSteps steps;
    steps.values = Vec<double, 2>(p[0], p[1]);
    return steps;
  }
  static const char* normalize(double* p) {
    return p[0] > 0 && p[1] > 0 ? nullptr : "time steps must be positive";
  }
};

/// White-noise-acceleration prior on hand and object, beyond the paper's edges:
/// e = v(b, c) - v(a, b), the change of velocity (m/s along the world's axes;
/// rad/s in the body). E2 alone carries the trackers' noise along; this does not.
/// Source: Bar-Shalom, Li, Kirubarajan, "Estimation with Applications to
/// Tracking and Navigation", 6.2.2.
struct SteadyMotionEdge : Edge<SteadyMotionEdge, 6, SE3, SE3, SE3>, Measured<TimeSteps> {
  static constexpr auto tag = "LFD_STEADY_MOTION";
  static constexpr auto doc = "velocity changes little from step to step (motion prior)";
  template <class T>
  Vec<T, 6> error(const SE3<T>& a, const SE3<T>& b, const SE3<T>& c) const {
    const double inverse_1 = 1.0 / measurement.values[0];
    const double inverse_2 = 1.0 / measurement.values[1];
    const Eigen::Quaternion<T> turn_1 = a.rotation.conjugate() * b.rotation;
    const Eigen::Quaternion<T> turn_2 = b.rotation.conjugate() * c.rotation;
    const Vec<T, 3> w_1 = logSO3(turn_1);
    const Vec<T, 3> w_2 = logSO3(turn_2);
    Vec<T, 6> e;
    for (int i = 0; i < 3; ++i) {
      e[i] = (c.translation[i] - b.translation[i]) * inverse_2 -
             (b.translation[i] - a.translation[i]) * inverse_1;
      e[3 + i] = w_2[i] * inverse_2 - w_1[i] * inverse_1;
    }
    return e;
  }
  void jacobians(const Pose& a, const Pose& b, const Pose& c, JacobianBlock<6, 6> by_a,
                 JacobianBlock<6, 6> by_b, JacobianBlock<6, 6> by_c) const {
    const double inverse_1 = 1.0 / measurement.values[0];
    const double inverse_2 = 1.0 / measurement.values[1];
    const Eigen::Quaterniond turn_1 = a.rotation.conjugate() * b.rotation;
    const Eigen::Quaterniond turn_2 = b.rotation.conjugate() * c.rotation;
    const Mat<double, 3> right_1 = inverseRightJacobianSO3(logSO3(turn_1));
    const Mat<double, 3> right_2 = inverseRightJacobianSO3(logSO3(turn_2));
    by_a.setZero();
    by_b.setZero();
    by_c.setZero();
    by_a.topLeftCorner<3, 3>() = inverse_1 * a.rotation.toRotationMatrix();
    by_b.topLeftCorner<3, 3>() = -(inverse_1 + inverse_2) * b.rotation.toRotationMatrix();
    by_c.topLeftCorner<3, 3>() = inverse_2 * c.rotation.toRotationMatrix();
    // log(turn exp(d)) has slope Jr^-1, log(exp(-d) turn) has -Jr^-1 turn'.
    by_a.bottomRightCorner<3, 3>() = inverse_1 * right_1 * turn_1.conjugate().toRotationMatrix();
    by_b.bottomRightCorner<3, 3>() =
        -inverse_2 * right_2 * turn_2.conjugate().toRotationMatrix() - inverse_1 * right_1;
    by_c.bottomRightCorner<3, 3>() = inverse_2 * right_2;
  }
};

}  // namespace graft::lfd
