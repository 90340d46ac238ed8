// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "core/geometry/dual.hpp"

// Conventions of this room, stated once:
//  - Transforms a_T_b give the pose of frame b in frame a; products chain:
//    a_T_b * b_T_c = a_T_c.
//  - Quaternions are Hamilton, unit, and written qx qy qz qw.
//  - Tangent vectors are [translation; rotation], rotation in radians.
//  - Perturbations act on the right: x.plus(delta) = x * increment(delta).

namespace graft {

template <class T, int N>
using Vec = Eigen::Matrix<T, N, 1>;
template <class T, int R, int C = R>
using Mat = Eigen::Matrix<T, R, C>;

/// Rotation vector (3, rad) to unit quaternion: the exponential map of SO(3).
template <class T>
Eigen::Quaternion<T> expSO3(const Vec<T, 3>& phi) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T angle2 = phi[0] * phi[0] + phi[1] * phi[1] + phi[2] * phi[2];
  T scale;
  T w;
  if (valueOf(angle2) < 1e-10) {
    // Series of sin(a/2)/a and cos(a/2); the next terms are below 1e-22.
    scale = 0.5 - angle2 * (1.0 / 48.0);
    w = 1.0 - angle2 * (1.0 / 8.0);
  } else {
    const T angle = sqrt(angle2);
    const T half = angle * 0.5;
    scale = sin(half) / angle;
    w = cos(half);
  }
  return Eigen::Quaternion<T>(w, scale * phi[0], scale * phi[1], scale * phi[2]);
}

/// 1 or -1, so that q and -q times it are the same: w >= 0, and at half turns, where w is
/// zero, the first other number that is not is positive.
template <class T>
double quaternionSign(const Eigen::Quaternion<T>& q) {
  for (const double number : {valueOf(q.w()), valueOf(q.x()), valueOf(q.y()), valueOf(q.z())}) {
    if (number != 0) return number < 0 ? -1.0 : 1.0;
  }
  return 1.0;
}

/// Unit quaternion to rotation vector (3, rad) of angle at most pi; q and -q
/// give the same result.
template <class T>
Vec<T, 3> logSO3(const Eigen::Quaternion<T>& q) {
  using std::atan2;
  using std::sqrt;
  const double sign = quaternionSign(q);
  const T w = sign * q.w();
  const T x = sign * q.x();
  const T y = sign * q.y();
  const T z = sign * q.z();
  const T sine2 = x * x + y * y + z * z;
  T scale;
  if (valueOf(sine2) < 1e-10) {
    // Series of 2 atan(s/w)/s.
    scale = (2.0 - sine2 * (2.0 / 3.0) / (w * w)) / w;
  } else {
    const T sine = sqrt(sine2);
    scale = 2.0 * atan2(sine, w) / sine;
  }
  return Vec<T, 3>(scale * x, scale * y, scale * z);
}

/// [v]x with [v]x w = v x w.
template <class T>
Mat<T, 3> skew(const Vec<T, 3>& v) {
  Mat<T, 3> m;
  m << T(0), -v[2], v[1], v[2], T(0), -v[0], -v[1], v[0], T(0);
  return m;
}

/// Inverse right Jacobian of SO(3): log(exp(phi) exp(d)) = phi + J d + O(d^2).
/// Source: Chirikjian, "Stochastic Models, Information Theory, and Lie Groups",
/// vol. 2, eq. 10.86. The left one is its transpose.
inline Mat<double, 3> inverseRightJacobianSO3(const Vec<double, 3>& phi) {
  const double angle2 = phi.squaredNorm();
  const Mat<double, 3> k = skew(phi);
  double c = 1.0 / 12.0 + angle2 / 720.0;
  if (angle2 > 1e-6) {
    const double angle = std::sqrt(angle2);
    c = 1.0 / angle2 - 0.5 * std::cos(0.5 * angle) / (angle * std::sin(0.5 * angle));
  }
  return Mat<double, 3>::Identity() + 0.5 * k + c * k * k;
}

/// Angle of a rotation, rad, in [0, pi].
inline double rotationAngle(const Eigen::Quaterniond& q) {
  return 2.0 * std::atan2(q.vec().norm(), std::abs(q.w()));
}

/// Scales a quaternion read from text to unit length. Leaves one that is unit
/// to rounding as it is, so that reading back what was written changes no bit.
/// Returns false for a quaternion too short to define a rotation.
inline bool normalizeQuaternion(double* xyzw) {
  const double norm2 =
      xyzw[0] * xyzw[0] + xyzw[1] * xyzw[1] + xyzw[2] * xyzw[2] + xyzw[3] * xyzw[3];
  if (!(norm2 > 1e-12)) return false;
  if (std::abs(norm2 - 1.0) <= 4e-15) return true;
  const double inverse = 1.0 / std::sqrt(norm2);
  for (int i = 0; i < 4; ++i) xyzw[i] *= inverse;
  return true;
}

}  // namespace graft
