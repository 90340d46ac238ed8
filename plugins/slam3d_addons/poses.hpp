// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/euler.hpp"
#include "core/types/plugin.hpp"

namespace graft {

/// A pose in space that files write as x y z roll pitch yaw; everything else is as
/// for SE3, the tangent included.
template <class T = double>
struct EulerPose {
  static constexpr int kAmbientDim = 6;
  static constexpr int kTangentDim = 6;
  static constexpr const char* kFields = "x y z roll pitch yaw";

  SE3<T> pose;

  static EulerPose fromArray(const double* p) {
    EulerPose r;
    r.pose.translation = Vec<T, 3>(T(p[0]), T(p[1]), T(p[2]));
    r.pose.rotation = quaternionOfEuler(T(p[3]), T(p[4]), T(p[5]));
    return r;
  }
  void toArray(double* p) const {
    const Eigen::Quaterniond q(valueOf(pose.rotation.w()), valueOf(pose.rotation.x()),
                               valueOf(pose.rotation.y()), valueOf(pose.rotation.z()));
    const Vec<double, 3> euler = eulerOfQuaternion(q);
    for (int i = 0; i < 3; ++i) {
      p[i] = valueOf(pose.translation[i]);
      p[3 + i] = euler[i];
    }
  }
  static const char* normalize(double*) { return nullptr; }
  EulerPose plus(const Vec<T, 6>& d) const {
    EulerPose r;
    r.pose = pose.plus(d);
    return r;
  }
  Vec<T, 6> minus(const EulerPose& o) const { return pose.minus(o.pose); }
  void renormalize() { pose.renormalize(); }
};

template <>
struct VertexTag<EulerPose> {
  static constexpr const char* kTag = "VERTEX3";
  static constexpr const char* kDoc =
      "pose in space: metres, Euler angles Rz(yaw) Ry(pitch) Rx(roll)";
};

template <>
struct Relaxation<EulerPose> {
  static constexpr int kRows[2] = {3, 3};
  static constexpr int kColumns[2] = {3, 1};
  static void relax(int stage, const double* x, double* y) {
    double pose[7];
    EulerPose<double>::fromArray(x).pose.toArray(pose);
    Relaxation<SE3>::relax(stage, pose, y);
  }
  static int restore(int stage, const double* y, double* x) {
    double pose[7];
    EulerPose<double> placed = EulerPose<double>::fromArray(x);
    placed.pose.toArray(pose);
    if (Relaxation<SE3>::restore(stage, y, pose) != GRAFT_OK) return GRAFT_FAILED;
    placed.pose = Pose::fromArray(pose);
    placed.toArray(x);
    return GRAFT_OK;
  }
};

/// Relative pose with the information of Euler angles. As in g2o the error is that
/// of EDGE_SE3:QUAT, E = measured^-1 * (a^-1 * b) in the quaternion's chart, and the
/// information is carried into it by J = d(Euler angles) / d(chart) at the
/// measurement; here J stands in the error, so that the file's matrix stays as it is.
struct Edge3 : Edge<Edge3, 6, EulerPose, EulerPose>, Measured<EulerPose<double>> {
  static constexpr auto tag = "EDGE3";
  static constexpr auto doc = "measured pose of the second vertex in the first, Euler angles";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;
  static constexpr int kRelaxedRows[2] = {3, 3};

  template <class T>
  Vec<T, 6> error(const EulerPose<T>& a, const EulerPose<T>& b) const {
    Vec<T, 6> e = quaternionVectorError(measurement.pose.inverse().template cast<T>() *
                                        (a.pose.inverse() * b.pose));
    const Mat<double, 3> j = eulerByQuaternionVector(measurement.pose.rotation);
    e.template tail<3>() = Vec<T, 3>(j.template cast<T>() * e.template tail<3>());
    return e;
  }

  bool propagate(int to, EulerPose<double>& a, EulerPose<double>& b) const {
    (to == 1 ? b : a).pose =
        to == 1 ? a.pose * measurement.pose : b.pose * measurement.pose.inverse();
    return true;
  }

  bool relax(int stage, const InformationBlock& information, const EulerPose<double>& a,
             const EulerPose<double>&, RelaxedEquations& equations) const {
    const Mat<double, 3> turn = measurement.pose.rotation.toRotationMatrix();
    if (stage == 0) {
      const Mat<double, 3> j = eulerByQuaternionVector(measurement.pose.rotation);
      const double weight = std::sqrt(
          std::max((j.transpose() * information.bottomRightCorner(3, 3) * j).trace() / 3, 0.0));
      equations.matrix(0) = -weight * turn.transpose();
      equations.matrix(1) = weight * Mat<double, 3>::Identity();
      return true;
    }
    const Mat<double, 3> a_R = a.pose.rotation.toRotationMatrix();
    const Mat<double, 3> weight =
        rootOf<3>(information.topLeftCorner(3, 3)) * (a_R * turn).transpose();
    equations.matrix(0) = -weight;
    equations.matrix(1) = weight;
    equations.right() = weight * (a_R * measurement.pose.translation);
    return true;
  }
};

/// Relative pose of a sensor whose pose in the vehicle is a vertex, too:
/// E = measured^-1 * (calibration^-1 * a^-1 * b * calibration), g2o's chart.
struct EdgeSe3Calib : Edge<EdgeSe3Calib, 6, SE3, SE3, SE3>, Measured<Pose> {
  static constexpr auto tag = "EDGE_SE3_CALIB";
  static constexpr auto doc = "measured motion of a sensor that is calibrated, too";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 6> error(const SE3<T>& a, const SE3<T>& b, const SE3<T>& calibration) const {
    return quaternionVectorError(measurement.inverse().template cast<T>() *
                                 (calibration.inverse() * ((a.inverse() * b) * calibration)));
  }

  bool propagate(int to, Pose& a, Pose& b, Pose& calibration) const {
    const Pose between = calibration * measurement * calibration.inverse();
    if (to == 2) return false;
    (to == 1 ? b : a) = to == 1 ? a * between : b * between.inverse();
    return true;
  }
};

}  // namespace graft
