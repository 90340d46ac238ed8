// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include "core/types/plugin.hpp"

namespace graft {

/// A line in space by its Pluecker coordinates: moment w = p x d of any of its
/// points p, and unit direction d. Tangent of 4: a turn of the frame [w d w x d],
/// rad, and of the angle whose tangent is 1 / |w|.
/// Source of the chart: Bartoli, Sturm, "Structure-from-motion using lines", 2005.
template <class T = double>
struct Line3 {
  static constexpr int kAmbientDim = 6;
  static constexpr int kTangentDim = 4;
  static constexpr const char* kFields = "wx wy wz dx dy dz";

  Vec<T, 3> moment = Vec<T, 3>(T(0), T(0), T(0));
  Vec<T, 3> direction = Vec<T, 3>(T(1), T(0), T(0));

  static Line3 fromArray(const double* p) {
    Line3 line;
    for (int i = 0; i < 3; ++i) {
      line.moment[i] = T(p[i]);
      line.direction[i] = T(p[3 + i]);
    }
    return line;
  }
  void toArray(double* p) const {
    for (int i = 0; i < 3; ++i) {
      p[i] = valueOf(moment[i]);
      p[3 + i] = valueOf(direction[i]);
    }
  }
  /// Scales to a unit direction and removes what the moment has along it.
  static const char* normalize(double* p) {
    Eigen::Map<Vec<double, 3>> w(p);
    Eigen::Map<Vec<double, 3>> d(p + 3);
    const double norm2 = d.squaredNorm();
    if (!(norm2 > 1e-24)) return "the direction of the line is zero";
    if (std::abs(norm2 - 1.0) > 4e-15) {
      const double inverse = 1.0 / std::sqrt(norm2);
      w *= inverse;
      d *= inverse;
    }
    const double along = w.dot(d);
    if (std::abs(along) > 4e-15 * w.norm()) w -= along * d;
    return nullptr;
  }

  Line3 plus(const Vec<T, 4>& delta) const {
    using std::cos;
    using std::sin;
    using std::sqrt;
    const Vec<T, 3> turn = delta.template head<3>();
    const Mat<T, 3> u = frame() * expSO3<T>(turn).toRotationMatrix();
    const T length = sqrt(moment.squaredNorm() + tiny());
    const T norm = sqrt(1.0 + length * length);
    const T cosine = (length * cos(delta[3]) - sin(delta[3])) / norm;
    const T sine = (cos(delta[3]) + length * sin(delta[3])) / norm;
    Line3 line;
    line.direction = u.col(1);
    line.moment = u.col(0) * (cosine / sine);
    return line;
  }
  /// The shortest delta with o.plus(delta) == *this. A line that went through the
  /// origin on its way has turned its moment around.
  Vec<T, 4> minus(const Line3& o) const {
    using std::atan2;
    using std::sqrt;
    constexpr double kPi = 3.14159265358979323846;
    const Mat<T, 3> mine = frame();
    const T angle = atan2(T(1), sqrt(moment.squaredNorm()));
    const T from = atan2(T(1), sqrt(o.moment.squaredNorm()));
    Mat<T, 3> around = mine;
    around.col(0) *= T(-1);
    around.col(2) *= T(-1);
    const std::pair<const Mat<T, 3>*, T> ways[] = {
        {&mine, angle - from}, {&around, T(kPi) - angle - from}, {&around, -angle - from}};
    Vec<T, 4> shortest;
    double length = -1;
    for (const auto& [axes, turned] : ways) {
      Vec<T, 4> delta;
      delta.template head<3>() =
          logSO3(Eigen::Quaternion<T>(Mat<T, 3>(o.frame().transpose() * *axes)));
      delta[3] = turned;
      const double now = valueOf(T(delta.squaredNorm()));
      if (length >= 0 && !(now < length)) continue;
      length = now;
      shortest = delta;
    }
    return shortest;
  }
  void renormalize() {
    using std::sqrt;
    const T inverse = 1.0 / sqrt(direction.squaredNorm());
    direction *= inverse;
    moment *= inverse;
    moment -= direction * T(moment.dot(direction));
  }
  friend Line3 operator*(const SE3<T>& a_T_b, const Line3& line) {
    Line3 result;
    result.direction = a_T_b.rotation * line.direction;
    result.moment = a_T_b.rotation * line.moment + a_T_b.translation.cross(result.direction);
    return result;
  }

 private:
  /// Orthonormal [w d w x d]; a line through the origin takes any w across d.
  Mat<T, 3> frame() const {
    using std::sqrt;
    Vec<T, 3> w = moment;
    if (valueOf(moment[0]) == 0 && valueOf(moment[1]) == 0 && valueOf(moment[2]) == 0) {
      int smallest = 0;
      for (int i = 1; i < 3; ++i) {
        using std::abs;
        if (abs(direction[i]) < abs(direction[smallest])) smallest = i;
      }
      Vec<T, 3> axis(T(0), T(0), T(0));
      axis[smallest] = T(1);
      w = direction.cross(axis);
    }
    Mat<T, 3> u;
    u.col(1) = direction / sqrt(direction.squaredNorm());
    w -= u.col(1) * T(w.dot(u.col(1)));
    u.col(0) = w / sqrt(w.squaredNorm());
    u.col(2) = u.col(0).cross(u.col(1));
    return u;
  }
  /// The root of 0 has no derivative; constants of a dual number do not need one.
  T tiny() const { return T(moment.squaredNorm() == T(0) ? 1e-300 : 0.0); }
};

template <>
struct VertexTag<Line3> {
  static constexpr const char* kTag = "VERTEX_LINE3D";
  static constexpr const char* kDoc = "line in space: moment in m and unit direction";
};

/// PARAMS_SE3OFFSET, which the edge names but does not look into.
struct UnusedOffset;
template <>
struct ResourceTag<UnusedOffset> {
  static constexpr const char* kTag = "PARAMS_SE3OFFSET";
};

/// A line seen from a pose. As in g2o, whose costs are to be met, the error does not
/// use the offset. With the orthonormal representations (U, W) of the seen and the
/// measured line, error = [vector part of the quaternion of U_seen' U_measured;
/// angle of W_seen' W_measured]. Not finite where the line goes through the pose.
struct EdgeSe3Line3d : Edge<EdgeSe3Line3d, 4, SE3, Line3>,
                       Measured<Line3<double>>,
                       Using<UnusedOffset> {
  static constexpr auto tag = "EDGE_SE3_LINE3D";
  static constexpr auto doc =
      "measured line, in the frame of the pose that sees it; as in g2o the error leaves the "
      "offset out";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 4> error(const SE3<T>& pose, const Line3<T>& line) const {
    using std::atan2;
    using std::sqrt;
    const Line3<T> seen = pose.inverse() * line;
    const Line3<T> measured = constant<T>(measurement);
    const Mat<T, 3> turn = axes(seen).transpose() * axes(measured);
    // cos : sin of the two angles as moment : direction.
    const T c1 = sqrt(seen.moment.squaredNorm()), s1 = sqrt(seen.direction.squaredNorm());
    const T c2 = sqrt(measured.moment.squaredNorm()), s2 = sqrt(measured.direction.squaredNorm());
    Vec<T, 4> e;
    e.template head<3>() = vectorPart(turn);
    e[3] = atan2(c1 * s2 - s1 * c2, c1 * c2 + s1 * s2);
    return e;
  }

  bool propagate(int to, Pose& pose, Line3<double>& line) const {
    if (to != 1) return false;
    line = pose * measurement;
    line.renormalize();
    return true;
  }

 private:
  template <class T>
  static Line3<T> constant(const Line3<double>& line) {
    Line3<T> result;
    result.moment = line.moment.template cast<T>();
    result.direction = line.direction.template cast<T>();
    return result;
  }
  template <class T>
  static Mat<T, 3> axes(const Line3<T>& line) {
    using std::sqrt;
    const Vec<T, 3> across = line.moment.cross(line.direction);
    Mat<T, 3> u;
    u.col(0) = line.moment / sqrt(line.moment.squaredNorm());
    u.col(1) = line.direction / sqrt(line.direction.squaredNorm());
    u.col(2) = across / sqrt(across.squaredNorm());
    return u;
  }
  /// x y z of the unit quaternion of a rotation matrix, by the branch of the
  /// largest component, which is taken positive (w if the trace is positive).
  template <class T>
  static Vec<T, 3> vectorPart(const Mat<T, 3>& r) {
    const Eigen::Quaternion<T> q = Eigen::Quaternion<T>(r).normalized();
    return Vec<T, 3>(q.x(), q.y(), q.z());
  }
};

}  // namespace graft
