// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types/plugin.hpp"
#include "plugins/slam3d/se3_offset.hpp"

namespace graft::slam3d {

/// Derivatives of quaternionVectorError(E) where the frame on the right of E
/// turns and moves: rows [translation; quaternion's vector part], columns
/// [d_t; d_r]. Here the rotation part: turns on the right of E.
inline Mat<double, 3> vectorPartRight(const Eigen::Quaterniond& q) {
  const double sign = quaternionSign(q);
  return 0.5 * sign * (q.w() * Mat<double, 3>::Identity() + skew<double>(Vec<double, 3>(q.vec())));
}
/// The same for a turn on the left of E's rotation.
inline Mat<double, 3> vectorPartLeft(const Eigen::Quaterniond& q) {
  const double sign = quaternionSign(q);
  return 0.5 * sign * (q.w() * Mat<double, 3>::Identity() - skew<double>(Vec<double, 3>(q.vec())));
}

/// Derivative of R' (p - t) by a step of the pose (t, R) on the right, for a point
/// that it sees at `seen`: columns [d_t d_r].
inline Mat<double, 3, 6> seenByPose(const Vec<double, 3>& seen) {
  Mat<double, 3, 6> j;
  j.leftCols<3>() = -Mat<double, 3>::Identity();
  j.rightCols<3>() = skew(seen);
  return j;
}

/// One weight for a rotation: root of the mean of its information's diagonal.
inline double turnWeight(const InformationBlock& information) {
  return std::sqrt(std::max(information.bottomRightCorner(3, 3).trace() / 3, 0.0));
}

/// Equations of a relaxation: b = a * between, where slots a and b are poses;
/// weights from the information of g2o's chart of between^-1 * (a^-1 * b).
inline void relaxRelative(int stage, const InformationBlock& information, const Pose& between,
                          const Pose& a, RelaxedEquations& equations) {
  const Mat<double, 3> turn = between.rotation.toRotationMatrix();
  if (stage == 0) {
    const double weight = turnWeight(information);
    equations.matrix(0) = -weight * turn.transpose();
    equations.matrix(1) = weight * Mat<double, 3>::Identity();
    return;
  }
  const Mat<double, 3> a_R = a.rotation.toRotationMatrix();
  const Mat<double, 3> weight =
      rootOf<3>(information.topLeftCorner(3, 3)) * (a_R * turn).transpose();
  equations.matrix(0) = -weight;
  equations.matrix(1) = weight;
  equations.right() = weight * (a_R * between.translation);
}

/// The same for one pose in the world.
inline void relaxAbsolute(int stage, const InformationBlock& information, const Pose& measured,
                          RelaxedEquations& equations) {
  const Mat<double, 3> turn = measured.rotation.toRotationMatrix();
  if (stage == 0) {
    const double weight = turnWeight(information);
    equations.matrix(0) = weight * Mat<double, 3>::Identity();
    equations.right() = weight * turn.transpose();
    return;
  }
  const Mat<double, 3> weight = rootOf<3>(information.topLeftCorner(3, 3)) * turn.transpose();
  equations.matrix(0) = weight;
  equations.right() = weight * measured.translation;
}

}  // namespace graft::slam3d
