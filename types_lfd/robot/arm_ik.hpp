// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "types_lfd/robot/chain.hpp"

namespace graft::lfd {

struct IkOptions {
  double tolerance_t = 1e-4;  ///< accepted distance of the gripper, m
  double tolerance_r = 1e-4;  ///< accepted angle of the gripper, rad
  int iterations = 60;        ///< of each attempt
  int restarts = 30;          ///< from random joint vectors, after the start itself
  /// An attempt is given up where a step lowers the squared error by less than
  /// this share.
  double stall = 1e-4;
  std::uint64_t seed = 1;  ///< of the restarts; the same seed gives the same answer
};

/// A joint vector within the limits, in which the robot does not hit itself (as
/// far as the chain knows, Chain::setSelfCollision), whose forward kinematics is
/// base_T_gripper within the tolerances, or nothing if none was found. First tried from
/// `start` (dof numbers; clamped to the limits), then from random joint vectors;
/// of what is found within the first few successes the nearest to `start` is
/// returned. Continuous joints come out within half a turn of `start`.
///
/// Method: Levenberg-Marquardt on [translation; rotation vector], joints at a
/// limit held there while the gradient pushes outwards. Source: Sugihara,
/// "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt
/// method", T-RO 2011 (damping proportional to the squared error).
std::optional<Eigen::VectorXd> solveIk(const Chain& chain, const Pose& base_T_gripper,
                                       const Eigen::VectorXd& start,
                                       const IkOptions& options = IkOptions());

/// Where a single attempt may look, and which joints it prefers to move.
struct IkBox {
  Eigen::VectorXd lower;  ///< dof numbers, -infinity where unbounded
  Eigen::VectorXd upper;
  /// Of the solutions around, the one with the least motion in units of `scale`
  /// is approached: joints of a small scale move little.
  Eigen::VectorXd scale;

  /// The chain's limits, all joints alike.
  explicit IkBox(const Chain& chain);
};

/// A single attempt from `q`, which is overwritten by the best joint vector
/// found. True if within the tolerances and the robot does not hit itself.
bool refineIk(const Chain& chain, const Pose& base_T_gripper, const IkOptions& options,
              const IkBox& box, Eigen::VectorXd& q);
bool refineIk(const Chain& chain, const Pose& base_T_gripper, const IkOptions& options,
              Eigen::VectorXd& q);

/// Joint vectors for a sequence of gripper poses; an empty vector (size 0)
/// where no solution was found.
struct IkTrack {
  std::vector<Eigen::VectorXd> joints;
  std::size_t solved = 0;
  /// Steps between neighbours (both solved) that need more than the robot's
  /// speed: a change of the arm's posture, or a demonstration too fast for it.
  std::size_t too_fast = 0;
};

struct IkTrackOptions {
  IkOptions ik;
  int postures = 4;           ///< different starting postures that are followed
  double velocity_scale = 1;  ///< share of the robot's speed limits to keep to
};

/// Joint vectors along a motion: gripper poses in the base frame at each
/// instant (both the gripper and the base may have moved) at rising times (s).
/// Several postures are followed forwards and backwards with each pose solved
/// from its neighbour's solution, first within what the joints' speeds allow
/// and with slow joints (a torso) moved least; the sequence through all that was found with
/// the fewest steps above the speed limits, then the least motion, is chosen.
IkTrack solveIkAlong(const Chain& chain, const std::vector<Pose>& base_T_gripper,
                     const std::vector<double>& times,
                     const IkTrackOptions& options = IkTrackOptions());

}  // namespace graft::lfd
