// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/so3.hpp"

namespace graft {

/// Unit quaternion of roll, pitch, yaw (rad): R = Rz(yaw) Ry(pitch) Rx(roll), the
/// order of TORO's and g2o's VERTEX3 and EDGE3.
template <class T>
Eigen::Quaternion<T> quaternionOfEuler(const T& roll, const T& pitch, const T& yaw) {
  using std::cos;
  using std::sin;
  const T cr = cos(0.5 * roll), sr = sin(0.5 * roll);
  const T cp = cos(0.5 * pitch), sp = sin(0.5 * pitch);
  const T cy = cos(0.5 * yaw), sy = sin(0.5 * yaw);
  return Eigen::Quaternion<T>(cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy,
                              cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy);
}

/// Roll, pitch, yaw (rad) of a unit quaternion; pitch in [-pi/2, pi/2]. Where the
/// pitch is that far that roll and yaw turn about the same axis, roll is 0.
inline Vec<double, 3> eulerOfQuaternion(const Eigen::Quaterniond& q) {
  const Mat<double, 3> r = q.toRotationMatrix();
  const double level = std::hypot(r(2, 1), r(2, 2));
  const double pitch = std::atan2(-r(2, 0), level);
  if (level < 1e-7) return {0, pitch, std::atan2(-r(0, 1), r(1, 1))};
  return {std::atan2(r(2, 1), r(2, 2)), pitch, std::atan2(r(1, 0), r(0, 0))};
}

/// Derivative of roll, pitch, yaw by the quaternion's x, y, z with w kept as it is:
/// the matrix J with which g2o turns the information of Euler angles in a file
/// into that of its error, Omega = J' Omega_euler J (rotation part). As there, the
/// quaternion off the unit sphere passes through the rotation matrix and back, and
/// q or -q is the one that comes from the matrix.
inline Mat<double, 3> eulerByQuaternionVector(const Eigen::Quaterniond& rotation) {
  using D = Dual<3>;
  using std::sqrt;
  const Eigen::Quaterniond q = Eigen::Quaterniond(rotation.toRotationMatrix()).normalized();
  const Eigen::Quaternion<D> moved(D(q.w()), D::variable(q.x(), 0), D::variable(q.y(), 1),
                                   D::variable(q.z(), 2));
  const Mat<D, 3> r = moved.toRotationMatrix();
  Vec<D, 4> back;  // x y z w
  const D trace = r(0, 0) + r(1, 1) + r(2, 2);
  if (trace > 0) {
    const D root = sqrt(trace + 1.0);
    const D scale = 0.5 / root;
    back << (r(2, 1) - r(1, 2)) * scale, (r(0, 2) - r(2, 0)) * scale, (r(1, 0) - r(0, 1)) * scale,
        0.5 * root;
  } else {
    int i = r(1, 1) > r(0, 0) ? 1 : 0;
    if (r(2, 2) > r(i, i)) i = 2;
    const int j = (i + 1) % 3;
    const int k = (j + 1) % 3;
    const D root = sqrt(r(i, i) - r(j, j) - r(k, k) + 1.0);
    const D scale = 0.5 / root;
    back[i] = 0.5 * root;
    back[3] = (r(k, j) - r(j, k)) * scale;
    back[j] = (r(j, i) + r(i, j)) * scale;
    back[k] = (r(k, i) + r(i, k)) * scale;
  }
  const D &x = back[0], &y = back[1], &z = back[2], &w = back[3];
  const D euler[3] = {atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
                      asin(2.0 * (w * y - z * x)),
                      atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))};
  Mat<double, 3> j;
  for (int row = 0; row < 3; ++row) {
    for (int c = 0; c < 3; ++c) j(row, c) = euler[row].d[c];
  }
  return j;
}

}  // namespace graft
