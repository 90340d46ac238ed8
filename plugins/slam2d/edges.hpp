// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "plugins/slam2d/parts.hpp"

namespace graft {

/// Relative pose in the plane: error [x y theta] of measured^-1 * (a^-1 * b).
struct EdgeSe2 : Edge<EdgeSe2, 3, SE2, SE2>, Measured<Pose2> {
  static constexpr auto tag = "EDGE_SE2";
  static constexpr auto doc = "measured pose of the second vertex in the first";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;
  static constexpr int kRelaxedRows[2] = {2, 2};

  template <class T>
  Vec<T, 3> error(const SE2<T>& a, const SE2<T>& b) const {
    return poseError(measurement.inverse().template cast<T>() * (a.inverse() * b));
  }

  void jacobians(const Pose2& a, const Pose2& b, JacobianBlock<3, 3> by_a,
                 JacobianBlock<3, 3> by_b) const {
    const Pose2 a_T_b = a.inverse() * b;
    by_a.setZero();
    by_a.topRows<2>() =
        slam2d::rotation(-measurement.theta) * slam2d::seenByPose(Vec<double, 2>(a_T_b.x, a_T_b.y));
    by_a(2, 2) = -1;
    by_b.setZero();
    by_b.topLeftCorner<2, 2>() = slam2d::rotation(a_T_b.theta - measurement.theta);
    by_b(2, 2) = 1;
  }

  bool propagate(int to, Pose2& a, Pose2& b) const {
    if (to == 1) {
      b = a * measurement;
      b.renormalize();
    } else {
      a = b * measurement.inverse();
      a.renormalize();
    }
    return true;
  }

  bool relax(int stage, const InformationBlock& information, const Pose2& a, const Pose2&,
             RelaxedEquations& equations) const {
    slam2d::relaxRelative(stage, information, measurement, a, equations);
    return true;
  }
};

/// Relative pose of two sensors that the vehicles carry, each at its own offset:
/// error [x y theta] of measured^-1 * ((a * offset_a)^-1 * (b * offset_b)).
struct EdgeSe2Offset : Edge<EdgeSe2Offset, 3, SE2, SE2>,
                       Measured<Pose2>,
                       Using<Se2Offset, Se2Offset> {
  static constexpr auto tag = "EDGE_SE2_OFFSET";
  static constexpr auto doc = "measured pose of the second vertex's sensor in the first's";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;
  static constexpr int kRelaxedRows[2] = {2, 2};

  template <class T>
  Vec<T, 3> error(const SE2<T>& a, const SE2<T>& b) const {
    const SE2<T> at_a = a * resource<0>().body_T_sensor.template cast<T>();
    const SE2<T> at_b = b * resource<1>().body_T_sensor.template cast<T>();
    return poseError(measurement.inverse().template cast<T>() * (at_a.inverse() * at_b));
  }

  bool propagate(int to, Pose2& a, Pose2& b) const {
    (to == 1 ? b : a) = to == 1 ? a * between() : b * between().inverse();
    (to == 1 ? b : a).renormalize();
    return true;
  }

  bool relax(int stage, const InformationBlock& information, const Pose2& a, const Pose2&,
             RelaxedEquations& equations) const {
    slam2d::relaxRelative(stage, information, between(), a, equations);
    return true;
  }

 private:
  /// What the measurement says about the vertices themselves.
  Pose2 between() const {
    return resource<0>().body_T_sensor * measurement * resource<1>().body_T_sensor.inverse();
  }
};

/// A measured pose in the world: error [x y theta] of measured^-1 * pose.
struct EdgePriorSe2 : Edge<EdgePriorSe2, 3, SE2>, Measured<Pose2> {
  static constexpr auto tag = "EDGE_PRIOR_SE2";
  static constexpr auto doc = "measured pose of the vertex in the world";
  static constexpr int kRelaxedRows[2] = {2, 2};

  template <class T>
  Vec<T, 3> error(const SE2<T>& pose) const {
    return poseError(measurement.inverse().template cast<T>() * pose);
  }

  void jacobians(const Pose2& pose, JacobianBlock<3, 3> by_pose) const {
    by_pose.setZero();
    by_pose.topLeftCorner<2, 2>() = slam2d::rotation(pose.theta - measurement.theta);
    by_pose(2, 2) = 1;
  }

  bool propagate(int, Pose2& pose) const {
    pose = measurement;
    pose.renormalize();
    return true;
  }

  bool relax(int stage, const InformationBlock& information, const Pose2&,
             RelaxedEquations& equations) const {
    slam2d::relaxAbsolute(stage, information, measurement, equations);
    return true;
  }
};

/// A measured position in the world, as of a satellite receiver: error = t - measured.
struct EdgePriorSe2Xy : Edge<EdgePriorSe2Xy, 2, SE2>, Measured<Point2<double>> {
  static constexpr auto tag = "EDGE_PRIOR_SE2_XY";
  static constexpr auto doc = "measured position of the vertex in the world";
  static constexpr int kRelaxedRows[2] = {0, 2};

  template <class T>
  Vec<T, 2> error(const SE2<T>& pose) const {
    return Vec<T, 2>(pose.x, pose.y) - measurement.coordinates.template cast<T>();
  }

  void jacobians(const Pose2& pose, JacobianBlock<2, 3> by_pose) const {
    by_pose.setZero();
    by_pose.leftCols<2>() = slam2d::rotation(pose.theta);
  }

  bool relax(int, const InformationBlock& information, const Pose2&,
             RelaxedEquations& equations) const {
    const Mat<double, 2> weight = rootOf<2>(information);
    equations.matrix(0) = weight;
    equations.right() = weight * measurement.coordinates;
    return true;
  }
};

}  // namespace graft
