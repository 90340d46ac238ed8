// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/types/resource.hpp"

namespace graft {

/// Pose of a sensor in its vehicle, body_T_sensor, shared by many edges.
struct Se3Offset {
  Pose body_T_sensor;
};

template <>
struct ResourceTag<Se3Offset> {
  static constexpr const char* kTag = "PARAMS_SE3OFFSET";
  static constexpr const char* kDoc = "pose of a sensor in its vehicle, body_T_sensor";
  static constexpr const char* kFields = "x y z qx qy qz qw";
  /// Throws std::invalid_argument unless the tokens are seven finite numbers
  /// with a quaternion of a length near one.
  static std::unique_ptr<const Se3Offset> load(const std::string& directory,
                                               const std::vector<std::string>& tokens);
};

}  // namespace graft
