// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/geometry/se3.hpp"

namespace graft::lfd {

/// A gripper pose at which the robot can hold the object.
struct Grasp {
  Pose object_T_gripper;  ///< x is the approach axis, y the closing axis
  double quality = 0;     ///< 0..1
  int row = 0;            ///< 0 = first line after the header of grasps.csv
};

/// The grasps the robot may choose from. Each counts twice: as given and turned
/// by 180 degrees about its approach (x) axis, as a parallel gripper is the
/// same hand both ways round.
class GraspSet {
 public:
  /// A choice of nearest(): an index into valid(), which way round, and what it
  /// costs. Index -1 means none.
  struct Choice {
    int index = -1;
    bool flipped = false;
    double cost = 0;
  };

  /// A valid grasp, one way round.
  struct Candidate {
    Pose object_T_gripper;
    int row = 0;
    bool flipped = false;
  };

  /// How much farther from a person's grasp than the nearest one another may be.
  static constexpr double kFartherDistance = 0.005;     // m
  static constexpr double kFartherAngle = 0.034906585;  // rad, 2 degrees

  GraspSet() = default;
  explicit GraspSet(std::vector<Grasp> valid);

  /// Reads `x,y,z,qx,qy,qz,qw,quality` lines below exactly that header. Keeps
  /// grasps with quality >= min_quality. Quaternions are normalised (length off
  /// by over 1 % is a warning, by over a factor of 2 an error). No line at all,
  /// or none good enough, is an error that states the best quality. Throws
  /// what readFile throws; all else goes to `diagnostics`.
  static GraspSet read(const std::string& csv_path, double min_quality, Diagnostics& diagnostics);

  const std::vector<Grasp>& valid() const { return valid_; }

  /// What the graph may choose from: every valid grasp, straight and flipped, by row, unless
  /// keepLike() has taken some out.
  const std::vector<Candidate>& candidates() const { return candidates_; }

  /// Takes out candidates that are farther from a person's grasp than its nearest() is by
  /// kFartherDistance or kFartherAngle: they may cost the robot less, but are not what was
  /// shown. sigma_t in m, sigma_r in rad.
  void keepLike(const Pose& object_T_hand, double sigma_t, double sigma_r);

  /// The choice with the least |t|^2 / sigma_t^2 + |angle|^2 / sigma_r^2, where
  /// [t; angle] = poseError(object_T_gripper^-1 * grasp), in m and rad. Ties go
  /// to the lower row, then to the unflipped. `runner_up`, if given, receives
  /// the best among the other rows (index -1 if there is none).
  Choice nearest(const Pose& object_T_gripper, double sigma_t, double sigma_r,
                 Choice* runner_up = nullptr) const;

  /// object_T_gripper of a choice.
  Pose pose(const Choice& choice) const { return pose(choice.index, choice.flipped); }
  Pose pose(int index, bool flipped) const;

 private:
  std::vector<Grasp> valid_;
  std::vector<Candidate> candidates_;
};

/// A grasp turned by 180 degrees about its x axis.
Pose flippedGrasp(const Pose& object_T_gripper);

}  // namespace graft::lfd
