// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types/plugin.hpp"

namespace graft {

/// Pose of a sensor in its vehicle, body_T_sensor, shared by many edges.
struct Se2Offset {
  Pose2 body_T_sensor;
};

template <>
struct ResourceTag<Se2Offset> {
  static constexpr const char* kTag = "PARAMS_SE2OFFSET";
  static constexpr const char* kDoc = "pose of a sensor in its vehicle, body_T_sensor";
  static constexpr const char* kFields = "x y theta";
  /// Throws std::invalid_argument unless the tokens are three finite numbers.
  static std::unique_ptr<const Se2Offset> load(const std::string&,
                                               const std::vector<std::string>& tokens) {
    const std::vector<double> numbers = resourceNumbers(tokens, kFields);
    auto offset = std::make_unique<Se2Offset>();
    offset->body_T_sensor = Pose2(numbers[0], numbers[1], wrapAngle(numbers[2]));
    return offset;
  }
};

namespace slam2d {

/// R(theta).
inline Mat<double, 2> rotation(double theta) {
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  Mat<double, 2> r;
  r << c, -s, s, c;
  return r;
}

inline Vec<double, 2> translation(const Pose2& pose) { return {pose.x, pose.y}; }

/// Derivative of R(-phi) (p - t) by a step of the pose (t, phi) on the right, for
/// a point that it sees at `seen`: columns [d_t d_phi].
inline Mat<double, 2, 3> seenByPose(const Vec<double, 2>& seen) {
  Mat<double, 2, 3> j;
  j << -1, 0, seen[1], 0, -1, -seen[0];
  return j;
}

/// Equations of a relaxation: b = a * between, where slots a and b are poses;
/// weights from the information of [x y theta] of between^-1 * (a^-1 * b).
inline void relaxRelative(int stage, const InformationBlock& information, const Pose2& between,
                          const Pose2& a, RelaxedEquations& equations) {
  if (stage == 0) {
    const double weight = std::sqrt(std::max(information(2, 2), 0.0));
    equations.matrix(0) = -weight * rotation(between.theta);
    equations.matrix(1) = weight * Mat<double, 2>::Identity();
    return;
  }
  const Mat<double, 2> weight =
      rootOf<2>(information.topLeftCorner(2, 2)) * rotation(-a.theta - between.theta);
  equations.matrix(0) = -weight;
  equations.matrix(1) = weight;
  equations.right() = weight * rotation(a.theta) * translation(between);
}

/// The same for one pose in the world.
inline void relaxAbsolute(int stage, const InformationBlock& information, const Pose2& measured,
                          RelaxedEquations& equations) {
  if (stage == 0) {
    const double weight = std::sqrt(std::max(information(2, 2), 0.0));
    equations.matrix(0) = weight * Mat<double, 2>::Identity();
    equations.right() = weight * Vec<double, 2>(std::cos(measured.theta), std::sin(measured.theta));
    return;
  }
  const Mat<double, 2> weight =
      rootOf<2>(information.topLeftCorner(2, 2)) * rotation(-measured.theta);
  equations.matrix(0) = weight;
  equations.right() = weight * translation(measured);
}

/// A point at `seen` in the frame of a pose: slot 0 the pose, `slot` the point,
/// information of the two coordinates.
template <class Block>
void relaxSight(const Block& information, const Vec<double, 2>& seen, const Pose2& pose, int slot,
                int row, RelaxedEquations& equations) {
  const Mat<double, 2> weight = rootOf<2>(information) * rotation(-pose.theta);
  equations.matrix(0).middleRows(row, 2) = -weight;
  equations.matrix(slot).middleRows(row, 2) = weight;
  equations.right().middleRows(row, 2) = weight * rotation(pose.theta) * seen;
}

}  // namespace slam2d

}  // namespace graft
