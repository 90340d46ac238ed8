// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/point.hpp"
#include "core/types/plugin.hpp"

namespace graft {

template <>
struct VertexTag<Point2> {
  static constexpr const char* kTag = "VERTEX_XY";
  static constexpr const char* kDoc = "point in the plane: metres";
};

namespace slam2d {

/// R(theta).
inline Mat<double, 2> rotation(double theta) {
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  Mat<double, 2> r;
  r << c, -s, s, c;
  return r;
}

/// Derivative of R(-phi) (p - t) by a step of the pose (t, phi) on the right, for
/// a point that it sees at `seen`: columns [d_t d_phi].
inline Mat<double, 2, 3> seenByPose(const Vec<double, 2>& seen) {
  Mat<double, 2, 3> j;
  j << -1, 0, seen[1], 0, -1, -seen[0];
  return j;
}

}  // namespace slam2d

/// Relative pose in the plane: error [x y theta] of measured^-1 * (a^-1 * b).
struct EdgeSe2 : Edge<EdgeSe2, 3, SE2, SE2>, Measured<Pose2> {
  static constexpr auto tag = "EDGE_SE2";
  static constexpr auto doc = "measured pose of the second vertex in the first";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

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
};

/// A point seen from a pose: error = pose^-1 * point - measured, metres.
struct EdgeSe2Xy : Edge<EdgeSe2Xy, 2, SE2, Point2>, Measured<Point2<double>> {
  static constexpr auto tag = "EDGE_SE2_XY";
  static constexpr auto doc = "measured point, in the frame of the pose that sees it";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 2> error(const SE2<T>& pose, const Point2<T>& point) const {
    return pose.inverse() * point.coordinates - measurement.coordinates.template cast<T>();
  }

  void jacobians(const Pose2& pose, const Point2<double>& point, JacobianBlock<2, 3> by_pose,
                 JacobianBlock<2, 2> by_point) const {
    by_pose = slam2d::seenByPose(pose.inverse() * point.coordinates);
    by_point = slam2d::rotation(-pose.theta);
  }

  bool propagate(int to, Pose2& pose, Point2<double>& point) const {
    if (to != 1) return false;
    point.coordinates = pose * measurement.coordinates;
    return true;
  }
};

/// A measured pose in the world: error [x y theta] of measured^-1 * pose.
struct EdgePriorSe2 : Edge<EdgePriorSe2, 3, SE2>, Measured<Pose2> {
  static constexpr auto tag = "EDGE_PRIOR_SE2";
  static constexpr auto doc = "measured pose of the vertex in the world";

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
};

}  // namespace graft
