// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "plugins/slam2d/parts.hpp"

namespace graft {

/// A point seen from a pose: error = pose^-1 * point - measured, metres.
struct EdgeSe2Xy : Edge<EdgeSe2Xy, 2, SE2, Point2>, Measured<Point2<double>> {
  static constexpr auto tag = "EDGE_SE2_XY";
  static constexpr auto doc = "measured point, in the frame of the pose that sees it";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;
  static constexpr int kRelaxedRows[2] = {0, 2};

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

  bool relax(int, const InformationBlock& information, const Pose2& pose, const Point2<double>&,
             RelaxedEquations& equations) const {
    slam2d::relaxSight(information, measurement.coordinates, pose, 1, 0, equations);
    return true;
  }
};

/// The same, with a sensor's offset as resource. As in g2o, whose costs are to be
/// met, the error does not use the offset.
struct EdgeSe2PointXyOffset : Edge<EdgeSe2PointXyOffset, 2, SE2, Point2>,
                              Measured<Point2<double>>,
                              Using<Se2Offset> {
  static constexpr auto tag = "EDGE_SE2_POINTXY_OFFSET";
  static constexpr auto doc =
      "measured point, in the frame of the pose that sees it; as in g2o the error leaves the "
      "offset out";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 2> error(const SE2<T>& pose, const Point2<T>& point) const {
    return pose.inverse() * point.coordinates - measurement.coordinates.template cast<T>();
  }

  bool propagate(int to, Pose2& pose, Point2<double>& point) const {
    if (to != 1) return false;
    point.coordinates = pose * measurement.coordinates;
    return true;
  }
};

/// A point seen by a sensor whose pose in the vehicle is a vertex, too:
/// error = (pose * calibration)^-1 * point - measured.
struct EdgeSe2XyCalib : Edge<EdgeSe2XyCalib, 2, SE2, Point2, SE2>, Measured<Point2<double>> {
  static constexpr auto tag = "EDGE_SE2_XY_CALIB";
  static constexpr auto doc = "measured point in the frame of a sensor that is calibrated, too";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 2> error(const SE2<T>& pose, const Point2<T>& point, const SE2<T>& calibration) const {
    return (pose * calibration).inverse() * point.coordinates -
           measurement.coordinates.template cast<T>();
  }

  bool propagate(int to, Pose2& pose, Point2<double>& point, Pose2& calibration) const {
    if (to != 1) return false;
    point.coordinates = (pose * calibration) * measurement.coordinates;
    return true;
  }
};

/// The direction in which a pose sees a point: error = measured - bearing, rad.
struct EdgeBearingSe2Xy : Edge<EdgeBearingSe2Xy, 1, SE2, Point2>, Measured<Numbers<1>> {
  static constexpr auto tag = "EDGE_BEARING_SE2_XY";
  static constexpr auto doc = "measured direction of a point, in the frame of the pose, rad";
  static constexpr auto fields = "bearing";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 1> error(const SE2<T>& pose, const Point2<T>& point) const {
    using std::atan2;
    const Vec<T, 2> seen = pose.inverse() * point.coordinates;
    // A point at the pose has no direction and no derivative; as atan2 has it, it is ahead.
    const bool none = valueOf(seen[0]) == 0 && valueOf(seen[1]) == 0;
    const T direction = none ? T(0) : T(atan2(seen[1], seen[0]));
    return Vec<T, 1>(wrapAngle(T(measurement.values[0] - direction)));
  }

  bool propagate(int to, Pose2& pose, Point2<double>& point) const {
    if (to != 1) return false;
    // A bearing has no range; g2o begins 2 m away, and a start must be somewhere.
    constexpr double kRange = 2;
    const double bearing = measurement.values[0];
    point.coordinates =
        pose * Vec<double, 2>(kRange * std::cos(bearing), kRange * std::sin(bearing));
    return true;
  }
};

/// Difference of two points: error = b - a - measured.
struct EdgePointXy : Edge<EdgePointXy, 2, Point2, Point2>, Measured<Point2<double>> {
  static constexpr auto tag = "EDGE_POINTXY";
  static constexpr auto doc = "measured difference, second point minus first";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;
  static constexpr int kRelaxedRows[2] = {0, 2};

  template <class T>
  Vec<T, 2> error(const Point2<T>& a, const Point2<T>& b) const {
    return b.coordinates - a.coordinates - measurement.coordinates.template cast<T>();
  }

  void jacobians(const Point2<double>&, const Point2<double>&, JacobianBlock<2, 2> by_a,
                 JacobianBlock<2, 2> by_b) const {
    by_a = -Mat<double, 2>::Identity();
    by_b.setIdentity();
  }

  bool propagate(int to, Point2<double>& a, Point2<double>& b) const {
    if (to == 1) {
      b.coordinates = a.coordinates + measurement.coordinates;
    } else {
      a.coordinates = b.coordinates - measurement.coordinates;
    }
    return true;
  }

  bool relax(int, const InformationBlock& information, const Point2<double>&, const Point2<double>&,
             RelaxedEquations& equations) const {
    const Mat<double, 2> weight = rootOf<2>(information);
    equations.matrix(0) = -weight;
    equations.matrix(1) = weight;
    equations.right() = weight * measurement.coordinates;
    return true;
  }
};

/// A measured point in the world: error = point - measured.
struct EdgePriorXy : Edge<EdgePriorXy, 2, Point2>, Measured<Point2<double>> {
  static constexpr auto tag = "EDGE_PRIOR_XY";
  static constexpr auto doc = "measured position of the point in the world";
  static constexpr int kRelaxedRows[2] = {0, 2};

  template <class T>
  Vec<T, 2> error(const Point2<T>& point) const {
    return point.coordinates - measurement.coordinates.template cast<T>();
  }

  void jacobians(const Point2<double>&, JacobianBlock<2, 2> by_point) const {
    by_point.setIdentity();
  }

  bool propagate(int, Point2<double>& point) const {
    point = measurement;
    return true;
  }

  bool relax(int, const InformationBlock& information, const Point2<double>&,
             RelaxedEquations& equations) const {
    const Mat<double, 2> weight = rootOf<2>(information);
    equations.matrix(0) = weight;
    equations.right() = weight * measurement.coordinates;
    return true;
  }
};

/// Two points seen at once, with one 4 x 4 information matrix.
struct EdgeSe2TwoPointsXy : Edge<EdgeSe2TwoPointsXy, 4, SE2, Point2, Point2>, Measured<Numbers<4>> {
  static constexpr auto tag = "EDGE_SE2_TWOPOINTSXY";
  static constexpr auto doc = "two measured points, in the frame of the pose that sees them";
  static constexpr auto fields = "x1 y1 x2 y2";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE | GRAFT_EDGE_FIRST_PLACES;

  template <class T>
  Vec<T, 4> error(const SE2<T>& pose, const Point2<T>& a, const Point2<T>& b) const {
    Vec<T, 4> e;
    e.template head<2>() = pose.inverse() * a.coordinates;
    e.template tail<2>() = pose.inverse() * b.coordinates;
    return e - measurement.values.template cast<T>();
  }

  bool propagate(int to, Pose2& pose, Point2<double>& a, Point2<double>& b) const {
    if (to == 0) return false;
    const Vec<double, 2> seen = measurement.values.segment<2>(to == 1 ? 0 : 2);
    (to == 1 ? a : b).coordinates = pose * seen;
    return true;
  }
};

/// Any number of points seen at once, with one information matrix for all.
struct EdgeSe2LotsOfXy : OneToManyEdge<EdgeSe2LotsOfXy, 2, SE2, Point2> {
  static constexpr auto tag = "EDGE_SE2_LOTSOFXY";
  static constexpr auto doc = "n measured points, in the frame of the pose that sees them";
  static constexpr auto fields = "n x1 y1 ...";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE | GRAFT_EDGE_FIRST_PLACES;

  template <class T>
  Vec<T, 2> error(const SE2<T>& pose, const Point2<T>& point, const double* measured) const {
    const Vec<T, 2> seen = pose.inverse() * point.coordinates;
    return Vec<T, 2>(seen[0] - measured[0], seen[1] - measured[1]);
  }

  void jacobians(const Pose2& pose, const Point2<double>& point, JacobianBlock<2, 3> by_pose,
                 JacobianBlock<2, 2> by_point) const {
    by_pose = slam2d::seenByPose(pose.inverse() * point.coordinates);
    by_point = slam2d::rotation(-pose.theta);
  }

  bool place(const Pose2& pose, const double* measured, Point2<double>& point) const {
    point.coordinates = pose * Vec<double, 2>(measured[0], measured[1]);
    return true;
  }
};

}  // namespace graft
