// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types/plugin.hpp"

namespace graft {

namespace slam3d {

/// The rotation whose x axis is the unit vector n: Rz(azimuth) Ry(-elevation).
/// Along z, where the azimuth is any, it is 0 and counts as constant.
template <class T>
Mat<T, 3> frameOf(const Vec<T, 3>& n) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  T ca = T(1), sa = T(0);
  T level = n[0];
  if (valueOf(n[0]) * valueOf(n[0]) + valueOf(n[1]) * valueOf(n[1]) > 1e-24) {
    level = sqrt(n[0] * n[0] + n[1] * n[1]);
    ca = n[0] / level;
    sa = n[1] / level;
  }
  const T length = sqrt(level * level + n[2] * n[2]);
  const T ce = level / length;
  const T se = n[2] / length;
  Mat<T, 3> r;
  r << ca * ce, -sa, -ca * se, sa * ce, ca, -sa * se, se, T(0), ce;
  return r;
}

/// Azimuth and elevation of a vector, rad.
template <class T>
Vec<T, 2> directionOf(const Vec<T, 3>& n) {
  using std::atan2;
  using std::sqrt;
  return Vec<T, 2>(atan2(n[1], n[0]), atan2(n[2], sqrt(n[0] * n[0] + n[1] * n[1])));
}

}  // namespace slam3d

/// A plane in space: the points p with n p + d = 0, n a unit vector. Files have
/// n d and a colour, which is kept. Tangent [azimuth; elevation; distance]: the
/// turn of the normal in its own frame (x along it), rad, and the step along it, m.
template <class T = double>
struct Plane3 {
  static constexpr int kAmbientDim = 7;
  static constexpr int kTangentDim = 3;
  static constexpr const char* kFields = "nx ny nz d red green blue";

  Vec<T, 3> normal = Vec<T, 3>(T(1), T(0), T(0));
  T d = T(-1);
  double color[3] = {0.2, 0.2, 0.2};

  static Plane3 fromArray(const double* p) {
    Plane3 plane;
    plane.normal = Vec<T, 3>(T(p[0]), T(p[1]), T(p[2]));
    plane.d = T(p[3]);
    for (int i = 0; i < 3; ++i) plane.color[i] = p[4 + i];
    return plane;
  }
  void toArray(double* p) const {
    for (int i = 0; i < 3; ++i) p[i] = valueOf(normal[i]);
    p[3] = valueOf(d);
    for (int i = 0; i < 3; ++i) p[4 + i] = color[i];
  }
  static const char* normalize(double* p) {
    const double norm2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    if (!(norm2 > 1e-24)) return "the normal of the plane is zero";
    if (std::abs(norm2 - 1.0) <= 4e-15) return nullptr;
    const double inverse = 1.0 / std::sqrt(norm2);
    for (int i = 0; i < 4; ++i) p[i] *= inverse;
    return nullptr;
  }

  /// Distance of the plane from the origin along the normal.
  T distance() const { return -d; }
  Plane3 plus(const Vec<T, 3>& delta) const {
    using std::cos;
    using std::sin;
    Plane3 plane = *this;
    const T ce = cos(delta[1]);
    plane.normal =
        slam3d::frameOf(normal) * Vec<T, 3>(ce * cos(delta[0]), ce * sin(delta[0]), sin(delta[1]));
    plane.d = d - delta[2];
    return plane;
  }
  /// The delta with o.plus(delta) == *this.
  Vec<T, 3> minus(const Plane3& o) const {
    const Vec<T, 2> direction =
        slam3d::directionOf(Vec<T, 3>(slam3d::frameOf(o.normal).transpose() * normal));
    return Vec<T, 3>(direction[0], direction[1], distance() - o.distance());
  }
  void renormalize() {
    using std::sqrt;
    const T inverse = 1.0 / sqrt(normal.squaredNorm());
    normal *= inverse;
    d *= inverse;
  }
  /// The plane in frame a, given in frame b.
  friend Plane3 operator*(const SE3<T>& a_T_b, const Plane3& plane) {
    Plane3 result = plane;
    result.normal = a_T_b.rotation * plane.normal;
    result.d = plane.d - a_T_b.translation.dot(result.normal);
    return result;
  }
  template <class U>
  Plane3<U> cast() const {
    Plane3<U> plane;
    plane.normal = normal.template cast<U>();
    plane.d = U(d);
    for (int i = 0; i < 3; ++i) plane.color[i] = color[i];
    return plane;
  }
};

template <>
struct VertexTag<Plane3> {
  static constexpr const char* kTag = "VERTEX_PLANE";
  static constexpr const char* kDoc = "plane in space: unit normal, offset in m, and a colour";
};

/// Difference of two planes' four numbers: error = b - a - measured.
struct EdgePlane : Edge<EdgePlane, 4, Plane3, Plane3>, Measured<Numbers<4>> {
  static constexpr auto tag = "EDGE_PLANE";
  static constexpr auto doc = "measured difference of two planes' numbers, second minus first";
  static constexpr auto fields = "nx ny nz d";

  template <class T>
  Vec<T, 4> error(const Plane3<T>& a, const Plane3<T>& b) const {
    Vec<T, 4> e;
    e.template head<3>() = b.normal - a.normal;
    e[3] = b.d - a.d;
    return e - measurement.values.template cast<T>();
  }
};

/// A plane seen by a sensor whose pose in the vehicle is a vertex, too: error =
/// [azimuth elevation] of the measured normal in the frame of the seen one, and
/// seen minus measured distance.
struct EdgeSe3PlaneCalib : Edge<EdgeSe3PlaneCalib, 3, SE3, Plane3, SE3>, Measured<Plane3<double>> {
  static constexpr auto tag = "EDGE_SE3_PLANE_CALIB";
  static constexpr auto doc = "measured plane in the frame of a sensor that is calibrated, too";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 3> error(const SE3<T>& pose, const Plane3<T>& plane, const SE3<T>& calibration) const {
    const Plane3<T> seen = (pose * calibration).inverse() * plane;
    const Vec<T, 2> direction = slam3d::directionOf(Vec<T, 3>(
        slam3d::frameOf(seen.normal).transpose() * measurement.normal.template cast<T>()));
    return Vec<T, 3>(direction[0], direction[1], seen.distance() - measurement.distance());
  }

  bool propagate(int to, Pose& pose, Plane3<double>& plane, Pose& calibration) const {
    if (to != 1) return false;
    const Plane3<double> placed = (pose * calibration) * measurement;
    plane.normal = placed.normal;
    plane.d = placed.d;
    plane.renormalize();
    return true;
  }
};

}  // namespace graft
