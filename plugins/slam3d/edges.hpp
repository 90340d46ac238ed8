// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types/plugin.hpp"
#include "plugins/slam3d/se3_offset.hpp"

namespace graft {

namespace slam3d {

/// Derivatives of quaternionVectorError(E) where the frame on the right of E
/// turns and moves: rows [translation; quaternion's vector part], columns
/// [d_t; d_r]. Here the rotation part: turns on the right of E.
inline Mat<double, 3> vectorPartRight(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  return 0.5 * sign * (q.w() * Mat<double, 3>::Identity() + skew<double>(Vec<double, 3>(q.vec())));
}
/// The same for a turn on the left of E's rotation.
inline Mat<double, 3> vectorPartLeft(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  return 0.5 * sign * (q.w() * Mat<double, 3>::Identity() - skew<double>(Vec<double, 3>(q.vec())));
}

}  // namespace slam3d

/// Relative pose of two poses: E = a_T_b(measured)^-1 * (a^-1 * b), error in g2o's
/// chart [translation; vector part of the quaternion].
struct EdgeSe3 : Edge<EdgeSe3, 6, SE3, SE3>, Measured<Pose> {
  static constexpr auto tag = "EDGE_SE3:QUAT";
  static constexpr auto doc = "measured pose of the second vertex in the first";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 6> error(const SE3<T>& a, const SE3<T>& b) const {
    return quaternionVectorError(measurement.inverse().template cast<T>() * (a.inverse() * b));
  }

  void jacobians(const Pose& a, const Pose& b, JacobianBlock<6, 6> by_a,
                 JacobianBlock<6, 6> by_b) const {
    const Pose inverse = measurement.inverse();
    const Pose a_T_b = a.inverse() * b;
    const Pose e = inverse * a_T_b;
    const Mat<double, 3> turn = inverse.rotation.toRotationMatrix();
    by_a.setZero();
    by_a.topLeftCorner<3, 3>() = -turn;
    by_a.topRightCorner<3, 3>() = turn * skew(a_T_b.translation);
    by_a.bottomRightCorner<3, 3>() = -slam3d::vectorPartLeft(e.rotation) * turn;
    by_b.setZero();
    by_b.topLeftCorner<3, 3>() = e.rotation.toRotationMatrix();
    by_b.bottomRightCorner<3, 3>() = slam3d::vectorPartRight(e.rotation);
  }

  bool propagate(int to, Pose& a, Pose& b) const {
    if (to == 1) {
      b = a * measurement;
    } else {
      a = b * measurement.inverse();
    }
    return true;
  }
};

/// A measured pose of a sensor that a vehicle carries:
/// E = world_T_sensor(measured)^-1 * (world_T_body * body_T_sensor).
struct EdgeSe3Prior : Edge<EdgeSe3Prior, 6, SE3>, Measured<Pose>, Using<Se3Offset> {
  static constexpr auto tag = "EDGE_SE3_PRIOR";
  static constexpr auto doc = "measured pose of the vertex's sensor in the world";

  template <class T>
  Vec<T, 6> error(const SE3<T>& body) const {
    return quaternionVectorError(measurement.inverse().template cast<T>() *
                                 (body * resource().body_T_sensor.template cast<T>()));
  }

  void jacobians(const Pose& body, JacobianBlock<6, 6> by_body) const {
    const Pose& sensor = resource().body_T_sensor;
    const Pose e = measurement.inverse() * (body * sensor);
    const Mat<double, 3> turn =
        (measurement.rotation.conjugate() * body.rotation).toRotationMatrix();
    by_body.setZero();
    by_body.topLeftCorner<3, 3>() = turn;
    by_body.topRightCorner<3, 3>() = -turn * skew(sensor.translation);
    by_body.bottomRightCorner<3, 3>() =
        slam3d::vectorPartRight(e.rotation) * sensor.rotation.conjugate().toRotationMatrix();
  }

  bool propagate(int, Pose& body) const {
    body = measurement * resource().body_T_sensor.inverse();
    return true;
  }
};

}  // namespace graft
