// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "plugins/slam3d/camera.hpp"
#include "plugins/slam3d/parts.hpp"

namespace graft {

/// A point seen by a vehicle's sensor:
/// error = (pose * offset)^-1 * point - measured, metres.
struct EdgeSe3TrackXyz : Edge<EdgeSe3TrackXyz, 3, SE3, Point3>,
                         Measured<Point3<double>>,
                         Using<Se3Offset> {
  static constexpr auto tag = "EDGE_SE3_TRACKXYZ";
  static constexpr auto doc = "measured point, in the frame of the vertex's sensor";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;
  static constexpr int kRelaxedRows[2] = {0, 3};

  template <class T>
  Vec<T, 3> error(const SE3<T>& pose, const Point3<T>& point) const {
    const SE3<T> sensor = pose * resource().body_T_sensor.template cast<T>();
    return sensor.inverse() * point.coordinates - measurement.coordinates.template cast<T>();
  }

  void jacobians(const Pose& pose, const Point3<double>& point, JacobianBlock<3, 6> by_pose,
                 JacobianBlock<3, 3> by_point) const {
    const Mat<double, 3> sensor_R_body =
        resource().body_T_sensor.rotation.conjugate().toRotationMatrix();
    by_pose = sensor_R_body * slam3d::seenByPose(pose.inverse() * point.coordinates);
    by_point = sensor_R_body * pose.rotation.conjugate().toRotationMatrix();
  }

  bool propagate(int to, Pose& pose, Point3<double>& point) const {
    if (to != 1) return false;
    point.coordinates = pose * (resource().body_T_sensor * measurement.coordinates);
    return true;
  }

  bool relax(int, const InformationBlock& information, const Pose& pose, const Point3<double>&,
             RelaxedEquations& equations) const {
    const Pose& offset = resource().body_T_sensor;
    const Mat<double, 3> weight =
        rootOf<3>(information) *
        Eigen::Quaterniond(pose.rotation * offset.rotation).conjugate().toRotationMatrix();
    equations.matrix(0) = -weight;
    equations.matrix(1) = weight;
    equations.right() = weight * (pose.rotation * (offset * measurement.coordinates));
    return true;
  }
};

/// Base of what a camera sees: derived says what the third number is.
template <class Derived>
struct EdgeProject : Edge<Derived, 3, SE3, Point3>, Measured<Numbers<3>>, Using<Camera> {
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  /// error = [u v third(depth)] - measured, pixels u v = the first two of
  /// K * camera_p by its depth. Not finite where the depth is zero.
  template <class T>
  Vec<T, 3> error(const SE3<T>& pose, const Point3<T>& point) const {
    const SE3<T> camera = pose * this->resource().body_T_camera.template cast<T>();
    const Vec<T, 3> p =
        this->resource().k.template cast<T>() * (camera.inverse() * point.coordinates);
    return Vec<T, 3>(p[0] / p[2] - this->measurement.values[0],
                     p[1] / p[2] - this->measurement.values[1],
                     Derived::third(p[2]) - this->measurement.values[2]);
  }

  bool propagate(int to, Pose& pose, Point3<double>& point) const {
    const double depth = Derived::depth(this->measurement.values[2]);
    if (to != 1 || !std::isfinite(depth)) return false;
    const Vec<double, 3> pixel(this->measurement.values[0], this->measurement.values[1], 1);
    const Vec<double, 3> seen = this->resource().k.inverse() * (depth * pixel);
    point.coordinates = pose * (this->resource().body_T_camera * seen);
    return true;
  }
};

/// A point in a camera that measures depth.
struct EdgeProjectDepth : EdgeProject<EdgeProjectDepth> {
  static constexpr auto tag = "EDGE_PROJECT_DEPTH";
  static constexpr auto doc = "pixel and depth of a point in the vertex's camera";
  static constexpr auto fields = "u v depth";
  template <class T>
  static T third(const T& depth) {
    return depth;
  }
  static double depth(double measured) { return measured; }
};

/// A point in a camera that measures disparity, here 1 / depth.
struct EdgeProjectDisparity : EdgeProject<EdgeProjectDisparity> {
  static constexpr auto tag = "EDGE_PROJECT_DISPARITY";
  static constexpr auto doc = "pixel and inverse depth of a point in the vertex's camera";
  static constexpr auto fields = "u v inverse_depth";
  template <class T>
  static T third(const T& depth) {
    return 1.0 / depth;
  }
  static double depth(double measured) { return 1.0 / measured; }
};

/// Difference of two points: error = b - a - measured.
struct EdgePointXyz : Edge<EdgePointXyz, 3, Point3, Point3>, Measured<Point3<double>> {
  static constexpr auto tag = "EDGE_POINTXYZ";
  static constexpr auto doc = "measured difference, second point minus first";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;
  static constexpr int kRelaxedRows[2] = {0, 3};

  template <class T>
  Vec<T, 3> error(const Point3<T>& a, const Point3<T>& b) const {
    return b.coordinates - a.coordinates - measurement.coordinates.template cast<T>();
  }

  void jacobians(const Point3<double>&, const Point3<double>&, JacobianBlock<3, 3> by_a,
                 JacobianBlock<3, 3> by_b) const {
    by_a = -Mat<double, 3>::Identity();
    by_b.setIdentity();
  }

  bool propagate(int to, Point3<double>& a, Point3<double>& b) const {
    if (to == 1) {
      b.coordinates = a.coordinates + measurement.coordinates;
    } else {
      a.coordinates = b.coordinates - measurement.coordinates;
    }
    return true;
  }

  bool relax(int, const InformationBlock& information, const Point3<double>&, const Point3<double>&,
             RelaxedEquations& equations) const {
    const Mat<double, 3> weight = rootOf<3>(information);
    equations.matrix(0) = -weight;
    equations.matrix(1) = weight;
    equations.right() = weight * measurement.coordinates;
    return true;
  }
};

/// A measured point in the world: error = point - measured.
struct EdgePointXyzPrior : Edge<EdgePointXyzPrior, 3, Point3>, Measured<Point3<double>> {
  static constexpr auto tag = "EDGE_POINTXYZ_PRIOR";
  static constexpr auto doc = "measured position of the point in the world";
  static constexpr int kRelaxedRows[2] = {0, 3};

  template <class T>
  Vec<T, 3> error(const Point3<T>& point) const {
    return point.coordinates - measurement.coordinates.template cast<T>();
  }

  void jacobians(const Point3<double>&, JacobianBlock<3, 3> by_point) const {
    by_point.setIdentity();
  }

  bool propagate(int, Point3<double>& point) const {
    point = measurement;
    return true;
  }

  bool relax(int, const InformationBlock& information, const Point3<double>&,
             RelaxedEquations& equations) const {
    const Mat<double, 3> weight = rootOf<3>(information);
    equations.matrix(0) = weight;
    equations.right() = weight * measurement.coordinates;
    return true;
  }
};

/// Any number of points seen at once, with one information matrix for all.
struct EdgeSe3LotsOfXyz : OneToManyEdge<EdgeSe3LotsOfXyz, 3, SE3, Point3> {
  static constexpr auto tag = "EDGE_SE3_LOTSOF_XYZ";
  static constexpr auto doc = "n measured points, in the frame of the pose that sees them";
  static constexpr auto fields = "n x1 y1 z1 ...";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE | GRAFT_EDGE_FIRST_PLACES;

  template <class T>
  Vec<T, 3> error(const SE3<T>& pose, const Point3<T>& point, const double* measured) const {
    const Vec<T, 3> seen = pose.inverse() * point.coordinates;
    return Vec<T, 3>(seen[0] - measured[0], seen[1] - measured[1], seen[2] - measured[2]);
  }

  void jacobians(const Pose& pose, const Point3<double>& point, JacobianBlock<3, 6> by_pose,
                 JacobianBlock<3, 3> by_point) const {
    by_pose = slam3d::seenByPose(pose.inverse() * point.coordinates);
    by_point = pose.rotation.conjugate().toRotationMatrix();
  }

  bool place(const Pose& pose, const double* measured, Point3<double>& point) const {
    point.coordinates = pose * Vec<double, 3>(measured[0], measured[1], measured[2]);
    return true;
  }
};

}  // namespace graft
