// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "core/geometry/se2.hpp"
#include "core/geometry/se3.hpp"

namespace graft::lfd {

/// What of a gripper pose matters to an upright base on the floor: its height
/// and its tilt. The heading is a pure turn of the whole scene.
/// The orientation is R = Rz(heading) Ry(-elevation) Rx(roll), x being the
/// approach axis. Straight up or down any heading will do, with the roll to it.
struct GripperView {
  double heading = 0;    ///< rad
  double elevation = 0;  ///< rad, -pi/2 .. pi/2
  double roll = 0;       ///< rad
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

/// The nodes of a reachability map: gripper height, elevation, roll, and the
/// base's pose as seen from the gripper's heading: u = Rz(-heading) (base -
/// gripper) in the plane, psi = base yaw - heading. Since a turn of gripper and
/// base together changes nothing, no node is spent on headings.
///
/// Cells are `resolution` wide and have `turn` per full turn. Nodes stand at
/// multiples of the resolution, in roll at multiples of a cell, and in the other
/// angles as well or (`fine`) at multiples of half a cell.
struct ReachGrid {
  static constexpr int kMostNodes = 1024;  ///< in x and y
  static constexpr int kMostTurn = 72;

  double resolution = 0.05;  ///< m
  int turn = 8;              ///< angular cells per full turn; a multiple of 4
  int fine = 2;              ///< nodes per angular cell in psi and elevation, 1 or 2
  int rolls = 8;             ///< nodes in roll: `turn`, or 1 where every roll is alike
  int x0 = 0;                ///< first node in u_x, in units of the resolution
  int y0 = 0;
  int z0 = 0;
  int nx = 0;  ///< number of nodes
  int ny = 0;
  int nz = 0;

  /// Nodes per full turn in psi.
  int psiCount() const { return fine * turn; }
  /// Nodes in elevation, -pi/2 and pi/2 included.
  int ringCount() const { return 2 * level() + 1; }
  /// The node of elevation 0.
  int level() const { return fine * turn / 4; }
  /// Width of a cell in angle, rad.
  double step() const { return 2 * 3.14159265358979323846 / turn; }
  /// Distance of nodes in psi and elevation, rad.
  double nodeStep() const { return 2 * 3.14159265358979323846 / psiCount(); }
  /// Distance of nodes in roll, rad.
  double rollStep() const { return 2 * 3.14159265358979323846 / rolls; }
  double elevationOf(int ring) const { return (ring - level()) * nodeStep(); }

  /// 64-bit words that hold one bit per node of a row.
  int rowWords() const { return (nx + 63) / 64; }
  std::size_t layerSize() const { return size(nx) * size(ny); }
  /// Nodes of one (height, elevation, roll) slice: psi, then y, then x fastest.
  std::size_t sliceSize() const { return layerSize() * size(psiCount()); }
  std::size_t sliceCount() const { return size(nz) * size(ringCount()) * size(rolls); }
  std::size_t nodeCount() const { return sliceCount() * sliceSize(); }
  std::size_t slice(int z, int ring, int roll) const {
    return (size(z) * size(ringCount()) + size(ring)) * size(rolls) + size(roll);
  }

  /// Quality is kept per cell, without roll: height, elevation, psi, y, x.
  int cellRings() const { return turn / 2 + 1; }
  std::size_t cellCount() const { return size(nz) * size(cellRings()) * size(turn) * layerSize(); }
  std::size_t cell(int z, int ring, int psi, int y, int x) const {
    const std::size_t level = (size(z) * size(cellRings()) + size(ring)) * size(turn) + size(psi);
    return (level * size(ny) + size(y)) * size(nx) + size(x);
  }

  static GripperView view(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& position);
  static GripperView view(const Pose& world_T_gripper) {
    return view(world_T_gripper.rotation.toRotationMatrix(), world_T_gripper.translation);
  }

 private:
  static std::size_t size(int n) { return static_cast<std::size_t>(n); }
};

/// The base's pose in a gripper view: u (m) and psi (rad, in (-pi, pi]).
Pose2 baseInView(const GripperView& view, const Pose2& world_T_base);
/// Its inverse.
Pose2 baseInWorld(const GripperView& view, const Pose2& view_T_base);

}  // namespace graft::lfd
