// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "core/geometry/so3.hpp"

namespace graft {

/// The angle in (-pi, pi] that equals `angle` modulo a turn. Exact for angles
/// that are in the interval already.
template <class T>
T wrapAngle(const T& angle) {
  constexpr double kPi = 3.14159265358979323846;
  const double value = valueOf(angle);
  if (value > -kPi && value <= kPi) return angle;
  const double turns = std::ceil((value - kPi) / (2 * kPi));
  return angle - turns * 2 * kPi;
}

/// Rigid transform in the plane, a_T_b, written as x y theta. Tangent
/// [dx dy dtheta] in frame b: x.plus(d) = (t + R d_t, theta + d_theta).
template <class T = double>
struct SE2 {
  static constexpr int kAmbientDim = 3;
  static constexpr int kTangentDim = 3;
  static constexpr const char* kFields = "x y theta";

  T x = T(0);
  T y = T(0);
  T theta = T(0);

  SE2() = default;
  SE2(const T& x_, const T& y_, const T& theta_) : x(x_), y(y_), theta(theta_) {}

  static SE2 fromArray(const double* p) { return SE2(T(p[0]), T(p[1]), T(p[2])); }
  /// The same constant in another scalar, e.g. Dual.
  template <class U>
  SE2<U> cast() const {
    return SE2<U>(U(x), U(y), U(theta));
  }
  void toArray(double* p) const {
    p[0] = valueOf(x);
    p[1] = valueOf(y);
    p[2] = valueOf(theta);
  }
  /// Any three finite numbers are an element; the angle is kept as written.
  static const char* normalize(double*) { return nullptr; }

  SE2 inverse() const {
    using std::cos;
    using std::sin;
    const T c = cos(theta);
    const T s = sin(theta);
    return SE2(-(c * x + s * y), s * x - c * y, -theta);
  }
  SE2 operator*(const SE2& o) const {
    using std::cos;
    using std::sin;
    const T c = cos(theta);
    const T s = sin(theta);
    return SE2(x + c * o.x - s * o.y, y + s * o.x + c * o.y, theta + o.theta);
  }
  Vec<T, 2> operator*(const Vec<T, 2>& p) const {
    using std::cos;
    using std::sin;
    const T c = cos(theta);
    const T s = sin(theta);
    return Vec<T, 2>(x + c * p[0] - s * p[1], y + s * p[0] + c * p[1]);
  }
  SE2 plus(const Vec<T, 3>& d) const {
    SE2 r = *this * SE2(d[0], d[1], d[2]);
    r.theta = wrapAngle(r.theta);
    return r;
  }
  Vec<T, 3> minus(const SE2& o) const {
    const SE2 d = o.inverse() * *this;
    return Vec<T, 3>(d.x, d.y, wrapAngle(d.theta));
  }
  void renormalize() { theta = wrapAngle(theta); }
};

using Pose2 = SE2<double>;

/// [x y theta] of a transform with theta in (-pi, pi]: g2o's error of SE2.
template <class T>
Vec<T, 3> poseError(const SE2<T>& a_T_b) {
  return Vec<T, 3>(a_T_b.x, a_T_b.y, wrapAngle(a_T_b.theta));
}

}  // namespace graft
