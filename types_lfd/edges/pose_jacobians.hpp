// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types/edge.hpp"

namespace graft::lfd {

/// Derivatives of e = poseError(D), D = z^-1 a^-1 b, by right perturbations of
/// z, a and b (tangents [translation; rotation]). All pose edges of the learner
/// are this form or a part of it. With M = a^-1 b:
///   de/db = [R_D, 0; 0, Jr^-1]
///   de/da = [-R_z', R_z' [M_t]x; 0, -Jr^-1 R_M']
///   de/dz = [-I, [D_t]x; 0, -Jr^-1 R_D']
class PoseChainDerivatives {
 public:
  PoseChainDerivatives(const Pose& z, const Pose& a, const Pose& b)
      : motion_(a.inverse() * b), difference_(z.inverse() * motion_) {
    rotation_difference_ = difference_.rotation.toRotationMatrix();
    rotation_z_ = z.rotation.toRotationMatrix();
    inverse_right_ = inverseRightJacobianSO3(logSO3(difference_.rotation));
  }

  template <class Block>
  void byB(Block&& j) const {
    j.setZero();
    j.template topLeftCorner<3, 3>() = rotation_difference_;
    j.template bottomRightCorner<3, 3>() = inverse_right_;
  }
  template <class Block>
  void byA(Block&& j) const {
    j.setZero();
    j.template topLeftCorner<3, 3>() = -rotation_z_.transpose();
    j.template topRightCorner<3, 3>() = rotation_z_.transpose() * skew(motion_.translation);
    j.template bottomRightCorner<3, 3>() =
        -inverse_right_ * motion_.rotation.conjugate().toRotationMatrix();
  }
  template <class Block>
  void byZ(Block&& j) const {
    j.setZero();
    j.template topLeftCorner<3, 3>() = -Mat<double, 3>::Identity();
    j.template topRightCorner<3, 3>() = skew(difference_.translation);
    j.template bottomRightCorner<3, 3>() = -inverse_right_ * rotation_difference_.transpose();
  }

 private:
  Pose motion_;
  Pose difference_;
  Mat<double, 3> rotation_difference_;
  Mat<double, 3> rotation_z_;
  Mat<double, 3> inverse_right_;
};

}  // namespace graft::lfd
