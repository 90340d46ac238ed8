// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "core/geometry/se2.hpp"
#include "core/geometry/se3.hpp"

namespace graft::lfd {

/// What of a gripper pose matters to an upright base on the floor: its height,
/// its tilt, and its heading, which is a pure turn of the whole scene.
///
/// The orientation is split as R = Rz(heading) Ry(-elevation) Rx(roll), x being
/// the approach axis. Elevations fall into rings one angular step apart; within
/// half a step of straight up or down heading and roll turn about the same
/// axis, so there roll is 0 and the heading takes both (a cap, one class).
struct GripperView {
  int tilt = 0;        ///< class of elevation and roll, 0 .. tiltCount()-1
  double heading = 0;  ///< rad
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

/// The cells of a reachability map: gripper height, tilt class, and the base's
/// pose as seen from the gripper's heading: u = Rz(-heading) (base - gripper)
/// in the plane, psi = base yaw - heading. Since a turn of gripper and base
/// together changes nothing, no cell is spent on headings.
struct ReachGrid {
  double resolution = 0.05;  ///< edge of a cell in x, y, z; m
  int turn = 8;              ///< angular cells per full turn; a multiple of 4
  int x0 = 0;                ///< first cell in u_x, in cells
  int y0 = 0;
  int z0 = 0;
  int nx = 0;  ///< number of cells
  int ny = 0;
  int nz = 0;

  double step() const { return 2 * 3.14159265358979323846 / turn; }
  /// Rings of elevation between the caps.
  int ringCount() const { return turn / 2 - 1; }
  int tiltCount() const { return ringCount() * turn + 2; }
  std::size_t layerSize() const {
    return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny);
  }
  /// Cells of one (height, tilt) slice: psi, then y, then x fastest.
  std::size_t sliceSize() const { return layerSize() * static_cast<std::size_t>(turn); }
  std::size_t sliceCount() const {
    return static_cast<std::size_t>(nz) * static_cast<std::size_t>(tiltCount());
  }
  std::size_t cellCount() const { return sliceCount() * sliceSize(); }

  /// Class of a gripper orientation (rotation matrix) and position.
  GripperView view(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& position) const;
  GripperView view(const Pose& world_T_gripper) const {
    return view(world_T_gripper.rotation.toRotationMatrix(), world_T_gripper.translation);
  }
  /// Azimuth of the approach axis and roll about it (rad).
  static void split(const Eigen::Matrix3d& rotation, double& azimuth, double& roll);
  /// Ring of an approach axis with vertical component `up`: -turn/4 and turn/4
  /// are the caps.
  int ring(double up) const;
  int tiltOf(int ring, int roll_bin) const;

  /// Height bin, which may lie outside 0 .. nz-1.
  int heightBin(double z) const;
  /// Angular bin 0 .. turn-1; bins are centred on multiples of the step.
  int angleBin(double angle) const;
  std::size_t slice(int height_bin, int tilt) const {
    return static_cast<std::size_t>(height_bin) * static_cast<std::size_t>(tiltCount()) +
           static_cast<std::size_t>(tilt);
  }
};

/// The base's pose in a gripper view: u (m) and psi (rad, in (-pi, pi]).
Pose2 baseInView(const GripperView& view, const Pose2& world_T_base);
/// Its inverse.
Pose2 baseInWorld(const GripperView& view, const Pose2& view_T_base);

}  // namespace graft::lfd
