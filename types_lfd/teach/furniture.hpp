// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "core/geometry/se3.hpp"

namespace graft::lfd {

/// A piece of furniture with one moving part, in its own frame: the closed
/// front is the plane x = 0, people stand on the side x < 0, z is up, the floor
/// is z = 0. The handle's frame (the "object" of a task) has x into the front,
/// y along it to the left as seen by the person, z up.
struct Furniture {
  enum class Kind {
    kDoor,    ///< hinge about z at (0, 0) with a lever handle; opens away, angle < 0
    kSwivel,  ///< hinge about z at (0, 0) with a fixed handle; opens towards, angle > 0
    kSlider   ///< straight along `direction`
  };
  Kind kind = Kind::kSwivel;
  double standoff = 0.03;  ///< handle in front of the plane x = 0, m
  double radius = 0;       ///< handle from the hinge along y, m (hinges)
  double height = 0;       ///< handle above the floor, m
  double travel = 0;       ///< full opening: rad for hinges (signed), m for sliders
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit, sliders
  double lever_arm = 0;    ///< handle frame from the lever's axis, m (doors)
  double lever_press = 0;  ///< rad the lever is pressed down by (doors)

  /// furniture_T_handle at `opening` and `press`, both fractions from 0 to 1.
  Pose handle(double opening, double press) const;
};

}  // namespace graft::lfd
