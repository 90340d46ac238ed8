// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types/vertex.hpp"

namespace graft::lfd {

/// Pose of the robot's base link on the floor: x, y (m) and yaw (rad) in the
/// world frame. Upright by construction, which replaces the paper's constraint
/// on roll and pitch.
template <class T = double>
struct BasePose : SE2<T> {
  static constexpr const char* kFields = "x y yaw";

  BasePose() = default;
  explicit BasePose(const SE2<T>& p) : SE2<T>(p) {}
  static BasePose fromArray(const double* p) { return BasePose(SE2<T>::fromArray(p)); }
  BasePose plus(const Vec<T, 3>& d) const { return BasePose(SE2<T>::plus(d)); }
  Vec<T, 3> minus(const BasePose& o) const { return SE2<T>::minus(o); }
};

}  // namespace graft::lfd

template <>
struct graft::VertexTag<graft::lfd::BasePose> {
  static constexpr const char* kTag = "LFD_BASE";
  static constexpr const char* kDoc = "robot base on the floor: x y in metres, yaw in radians";
};
