// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry/so3.hpp"

namespace graft {

/// Rigid transform in space, a_T_b. Stored and written as x y z qx qy qz qw.
/// Tangent: [translation; rotation vector], both in frame b (right
/// perturbation): x.plus(d) = (t + R d_t, q exp(d_r)).
template <class T = double>
struct SE3 {
  static constexpr int kAmbientDim = 7;
  static constexpr int kTangentDim = 6;
  static constexpr const char* kFields = "x y z qx qy qz qw";

  Vec<T, 3> translation = Vec<T, 3>(T(0), T(0), T(0));
  Eigen::Quaternion<T> rotation = Eigen::Quaternion<T>(T(1), T(0), T(0), T(0));

  SE3() = default;
  SE3(const Vec<T, 3>& t, const Eigen::Quaternion<T>& q) : translation(t), rotation(q) {}

  static SE3 fromArray(const double* p) {
    return SE3(Vec<T, 3>(T(p[0]), T(p[1]), T(p[2])),
               Eigen::Quaternion<T>(T(p[6]), T(p[3]), T(p[4]), T(p[5])));
  }
  /// The same constant in another scalar, e.g. Dual.
  template <class U>
  SE3<U> cast() const {
    return SE3<U>(translation.template cast<U>(), rotation.template cast<U>());
  }
  void toArray(double* p) const {
    for (int i = 0; i < 3; ++i) p[i] = valueOf(translation[i]);
    p[3] = valueOf(rotation.x());
    p[4] = valueOf(rotation.y());
    p[5] = valueOf(rotation.z());
    p[6] = valueOf(rotation.w());
  }
  /// Makes seven numbers from a file an element of the group; returns null or
  /// why they are none.
  static const char* normalize(double* p) {
    return normalizeQuaternion(p + 3) ? nullptr : "the quaternion is zero";
  }

  SE3 inverse() const {
    const Eigen::Quaternion<T> q = rotation.conjugate();
    return SE3(-(q * translation), q);
  }
  SE3 operator*(const SE3& o) const {
    return SE3(translation + rotation * o.translation, rotation * o.rotation);
  }
  Vec<T, 3> operator*(const Vec<T, 3>& point) const { return translation + rotation * point; }

  SE3 plus(const Vec<T, 6>& delta) const {
    const Vec<T, 3> dt = delta.template head<3>();
    const Vec<T, 3> dr = delta.template tail<3>();
    return SE3(translation + rotation * dt, rotation * expSO3(dr));
  }
  /// The delta with o.plus(delta) == *this.
  Vec<T, 6> minus(const SE3& o) const {
    Vec<T, 6> delta;
    delta.template head<3>() = o.rotation.conjugate() * Vec<T, 3>(translation - o.translation);
    delta.template tail<3>() = logSO3(Eigen::Quaternion<T>(o.rotation.conjugate() * rotation));
    return delta;
  }
  /// Removes what rounding added to the quaternion's length.
  void renormalize() {
    using std::sqrt;
    const T norm2 = rotation.coeffs().squaredNorm();
    rotation.coeffs() *= T(1) / sqrt(norm2);
  }
};

using Pose = SE3<double>;

/// Difference of a transform from identity as a 6-vector [translation;
/// rotation vector]: translation in metres along the axes of frame a, rotation
/// in radians. Unlike the group logarithm the translation part is the distance
/// itself, so a sigma in metres means metres whatever the rotation.
template <class T>
Vec<T, 6> poseError(const SE3<T>& a_T_b) {
  Vec<T, 6> e;
  e.template head<3>() = a_T_b.translation;
  e.template tail<3>() = logSO3(a_T_b.rotation);
  return e;
}

/// g2o's error chart: [translation; vector part of the quaternion with w >= 0],
/// that is, half-angle units. Kept for files whose weights assume it.
template <class T>
Vec<T, 6> quaternionVectorError(const SE3<T>& a_T_b) {
  const double sign = quaternionSign(a_T_b.rotation);
  Vec<T, 6> e;
  e.template head<3>() = a_T_b.translation;
  e[3] = sign * a_T_b.rotation.x();
  e[4] = sign * a_T_b.rotation.y();
  e[5] = sign * a_T_b.rotation.z();
  return e;
}

/// The pose on the way from a to b at fraction s in [0, 1]: linear in
/// translation, slerp on the shorter arc in rotation (paper, section IV).
inline Pose interpolate(const Pose& a, const Pose& b, double s) {
  const Vec<double, 3> turn = logSO3(Eigen::Quaterniond(a.rotation.conjugate() * b.rotation));
  return Pose(a.translation + s * (b.translation - a.translation),
              (a.rotation * expSO3<double>(s * turn)).normalized());
}

}  // namespace graft
