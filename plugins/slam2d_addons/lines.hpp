// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types/plugin.hpp"

namespace graft {

/// A line in the plane in Hesse form: the points p with [cos theta, sin theta] p =
/// rho. `p1` and `p2` are ids of points at its ends (-1 = none), which nothing but
/// viewers uses; they are kept.
template <class T = double>
struct Line2 {
  static constexpr int kAmbientDim = 4;
  static constexpr int kTangentDim = 2;
  static constexpr const char* kFields = "theta rho p1 p2";

  T theta = T(0);
  T rho = T(0);
  double p1 = -1;
  double p2 = -1;

  static Line2 fromArray(const double* p) {
    Line2 line;
    line.theta = T(p[0]);
    line.rho = T(p[1]);
    line.p1 = p[2];
    line.p2 = p[3];
    return line;
  }
  void toArray(double* p) const {
    p[0] = valueOf(theta);
    p[1] = valueOf(rho);
    p[2] = p1;
    p[3] = p2;
  }
  static const char* normalize(double* p) {
    const bool ids = p[2] == std::floor(p[2]) && p[3] == std::floor(p[3]) && p[2] >= -1 &&
                     p[3] >= -1 && p[2] < 9e15 && p[3] < 9e15;
    return ids ? nullptr : "p1 and p2 must be ids of points, or -1";
  }
  Line2 plus(const Vec<T, 2>& d) const {
    Line2 line = *this;
    line.theta = wrapAngle(T(theta + d[0]));
    line.rho = rho + d[1];
    return line;
  }
  Vec<T, 2> minus(const Line2& o) const {
    return Vec<T, 2>(wrapAngle(T(theta - o.theta)), rho - o.rho);
  }
  void renormalize() { theta = wrapAngle(theta); }
};

template <>
struct VertexTag<Line2> {
  static constexpr const char* kTag = "VERTEX_LINE2D";
  static constexpr const char* kDoc =
      "line in the plane: direction of its normal, rad, distance, m";
};

/// A line seen from a pose: error = [theta rho] of the line in the pose's frame,
/// minus measured.
struct EdgeSe2Line2d : Edge<EdgeSe2Line2d, 2, SE2, Line2>, Measured<Numbers<2>> {
  static constexpr auto tag = "EDGE_SE2_LINE2D";
  static constexpr auto doc = "measured line, in the frame of the pose that sees it";
  static constexpr auto fields = "theta rho";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 2> error(const SE2<T>& pose, const Line2<T>& line) const {
    using std::cos;
    using std::sin;
    const T rho = line.rho - cos(line.theta) * pose.x - sin(line.theta) * pose.y;
    return Vec<T, 2>(wrapAngle(T(line.theta - pose.theta - measurement.values[0])),
                     rho - measurement.values[1]);
  }

  bool propagate(int to, Pose2& pose, Line2<double>& line) const {
    if (to != 1) return false;
    line.theta = wrapAngle(measurement.values[0] + pose.theta);
    line.rho =
        measurement.values[1] + std::cos(line.theta) * pose.x + std::sin(line.theta) * pose.y;
    return true;
  }
};

/// Difference of two lines' numbers: error = b - a - measured, angles unwrapped as
/// in g2o.
struct EdgeLine2d : Edge<EdgeLine2d, 2, Line2, Line2>, Measured<Numbers<2>> {
  static constexpr auto tag = "EDGE_LINE2D";
  static constexpr auto doc = "measured difference of two lines' numbers, second minus first";
  static constexpr auto fields = "theta rho";

  template <class T>
  Vec<T, 2> error(const Line2<T>& a, const Line2<T>& b) const {
    return Vec<T, 2>(b.theta - a.theta - measurement.values[0],
                     b.rho - a.rho - measurement.values[1]);
  }

  bool propagate(int to, Line2<double>& a, Line2<double>& b) const {
    const Vec<double, 2>& z = measurement.values;
    if (to == 1) {
      b.theta = a.theta + z[0];
      b.rho = a.rho + z[1];
    } else {
      a.theta = b.theta - z[0];
      a.rho = b.rho - z[1];
    }
    return true;
  }
};

/// Signed distance of a point from a line: error = n p - rho - measured, m.
struct EdgeLine2dPointXy : Edge<EdgeLine2dPointXy, 1, Line2, Point2>, Measured<Numbers<1>> {
  static constexpr auto tag = "EDGE_LINE2D_POINTXY";
  static constexpr auto doc = "measured distance of the point from the line, m";
  static constexpr auto fields = "distance";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 1> error(const Line2<T>& line, const Point2<T>& point) const {
    using std::cos;
    using std::sin;
    return Vec<T, 1>(cos(line.theta) * point.coordinates[0] +
                     sin(line.theta) * point.coordinates[1] - line.rho - measurement.values[0]);
  }
};

}  // namespace graft
