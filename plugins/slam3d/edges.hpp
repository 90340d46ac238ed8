// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "plugins/slam3d/parts.hpp"

namespace graft {

/// Relative pose of two poses: E = a_T_b(measured)^-1 * (a^-1 * b), error in g2o's
/// chart [translation; vector part of the quaternion].
struct EdgeSe3 : Edge<EdgeSe3, 6, SE3, SE3>, Measured<Pose> {
  static constexpr auto tag = "EDGE_SE3:QUAT";
  static constexpr auto doc = "measured pose of the second vertex in the first";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;
  static constexpr int kRelaxedRows[2] = {3, 3};

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

  bool relax(int stage, const InformationBlock& information, const Pose& a, const Pose&,
             RelaxedEquations& equations) const {
    slam3d::relaxRelative(stage, information, measurement, a, equations);
    return true;
  }
};

/// Relative pose of two sensors that the vehicles carry, each at its own offset:
/// E = measured^-1 * ((a * offset_a)^-1 * (b * offset_b)), in the same chart.
struct EdgeSe3Offset : Edge<EdgeSe3Offset, 6, SE3, SE3>,
                       Measured<Pose>,
                       Using<Se3Offset, Se3Offset> {
  static constexpr auto tag = "EDGE_SE3_OFFSET";
  static constexpr auto doc = "measured pose of the second vertex's sensor in the first's";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;
  static constexpr int kRelaxedRows[2] = {3, 3};

  template <class T>
  Vec<T, 6> error(const SE3<T>& a, const SE3<T>& b) const {
    const SE3<T> at_a = a * resource<0>().body_T_sensor.template cast<T>();
    const SE3<T> at_b = b * resource<1>().body_T_sensor.template cast<T>();
    return quaternionVectorError(measurement.inverse().template cast<T>() *
                                 (at_a.inverse() * at_b));
  }

  bool propagate(int to, Pose& a, Pose& b) const {
    (to == 1 ? b : a) = to == 1 ? a * between() : b * between().inverse();
    return true;
  }

  bool relax(int stage, const InformationBlock& information, const Pose& a, const Pose&,
             RelaxedEquations& equations) const {
    slam3d::relaxRelative(stage, information, between(), a, equations);
    return true;
  }

 private:
  /// What the measurement says about the vertices themselves.
  Pose between() const {
    return resource<0>().body_T_sensor * measurement * resource<1>().body_T_sensor.inverse();
  }
};

/// A measured pose of a sensor that a vehicle carries:
/// E = world_T_sensor(measured)^-1 * (world_T_body * body_T_sensor).
struct EdgeSe3Prior : Edge<EdgeSe3Prior, 6, SE3>, Measured<Pose>, Using<Se3Offset> {
  static constexpr auto tag = "EDGE_SE3_PRIOR";
  static constexpr auto doc = "measured pose of the vertex's sensor in the world";
  static constexpr int kRelaxedRows[2] = {3, 3};

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

  bool relax(int stage, const InformationBlock& information, const Pose&,
             RelaxedEquations& equations) const {
    slam3d::relaxAbsolute(stage, information, measurement * resource().body_T_sensor.inverse(),
                          equations);
    return true;
  }
};

/// A measured position of a pose in the world: error = t - measured. As in g2o,
/// whose costs are to be met, the error does not use the offset.
struct EdgeSe3XyzPrior : Edge<EdgeSe3XyzPrior, 3, SE3>, Measured<Point3<double>>, Using<Se3Offset> {
  static constexpr auto tag = "EDGE_SE3_XYZ_PRIOR";
  static constexpr auto doc =
      "measured position of the vertex in the world; as in g2o the error leaves the offset out";
  static constexpr int kRelaxedRows[2] = {0, 3};

  template <class T>
  Vec<T, 3> error(const SE3<T>& pose) const {
    return pose.translation - measurement.coordinates.template cast<T>();
  }

  void jacobians(const Pose& pose, JacobianBlock<3, 6> by_pose) const {
    by_pose.setZero();
    by_pose.leftCols<3>() = pose.rotation.toRotationMatrix();
  }

  bool relax(int, const InformationBlock& information, const Pose&,
             RelaxedEquations& equations) const {
    const Mat<double, 3> weight = rootOf<3>(information);
    equations.matrix(0) = weight;
    equations.right() = weight * measurement.coordinates;
    return true;
  }
};

}  // namespace graft
