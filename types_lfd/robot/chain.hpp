// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/geometry/se3.hpp"
#include "types_lfd/robot/urdf.hpp"

namespace graft::lfd {

class SelfCollision;
struct BodyFrames;

/// The moving joints between two links of a robot, and its kinematics. Joint
/// vectors hold one number per non-fixed joint, in order from base to tip (rad,
/// m). The gripper is the tip link times a constant transform.
class Chain {
 public:
  using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  static constexpr int kMaximumDof = 16;

  /// Throws Error(kInput), with path and line of the URDF, where a link is
  /// unknown, no way leads from base down to tip, no joint on it moves (or more
  /// than kMaximumDof do), or a joint on it is planar, floating or mimics
  /// another.
  Chain(const UrdfModel& model, const std::string& base_link, const std::string& tip_link,
        const Pose& tip_T_gripper = Pose());

  int dof() const { return static_cast<int>(joints_.size()); }
  const std::string& robotName() const { return robot_name_; }
  const std::string& baseLink() const { return base_link_; }
  const std::string& tipLink() const { return tip_link_; }
  const std::vector<std::string>& names() const { return names_; }
  /// Limits (rad, m). A continuous joint has -pi and pi here, which bound
  /// sampling only: it may be anywhere.
  const Eigen::VectorXd& lower() const { return lower_; }
  const Eigen::VectorXd& upper() const { return upper_; }
  /// Largest speeds (rad/s, m/s); infinity where the robot states none.
  const Eigen::VectorXd& velocity() const { return velocity_; }
  bool continuous(int joint) const { return joints_[static_cast<std::size_t>(joint)].continuous; }
  bool prismatic(int joint) const { return joints_[static_cast<std::size_t>(joint)].prismatic; }

  /// base_T_gripper for the joint vector q (dof numbers).
  Pose forward(const double* q) const;
  Pose forward(const Eigen::VectorXd& q) const { return forward(q.data()); }
  /// The same as rotation matrix and translation (fastest form).
  void forward(const double* q, Eigen::Matrix3d& rotation, Eigen::Vector3d& translation) const;

  /// Also the geometric Jacobian, 6 x dof: velocity of the gripper's origin
  /// (m) over its angular velocity (rad), both in the base frame, per unit of
  /// joint speed.
  void jacobian(const double* q, Pose& base_T_gripper, Jacobian& jacobian) const;

  /// Where the joints sit: 3 x dof, each joint's origin in the base frame (m).
  Eigen::Matrix3Xd origins(const Eigen::VectorXd& q) const;

  /// Where the bodies between the joints stand (dof + 1 of them).
  void bodies(const double* q, BodyFrames& frames) const;
  /// From now on configurations in which the robot hits itself do not count (see
  /// inverse kinematics and reachability maps). Changes hash() if there is
  /// anything to test.
  void setSelfCollision(std::shared_ptr<const SelfCollision> self_collision);
  /// Null if nothing is tested.
  const SelfCollision* selfCollision() const { return self_collision_.get(); }
  bool hitsItself(const Eigen::VectorXd& q) const;

  /// Index of a prismatic joint that moves all that follows straight up or
  /// down in the base frame whatever the other joints do (a torso); -1 if none.
  int heightJoint() const { return height_joint_; }
  /// +1 or -1: the direction in which the height joint counts.
  double heightSign() const { return height_sign_; }
  /// Index of the first turning joint if its axis is vertical and at most a
  /// height joint comes before it, so that it turns all that follows about a
  /// fixed upright line; -1 if none.
  int panJoint() const { return pan_joint_; }
  /// +1 or -1: direction in which the pan joint counts.
  double panSign() const { return pan_sign_; }
  /// Where that line stands in the base frame (x, y; m).
  const Eigen::Vector2d& panOrigin() const { return pan_origin_; }
  /// True if the last joint only turns the gripper about its own x axis
  /// (approach), so that roll comes free: it does on the PR2.
  bool lastJointRolls() const { return roll_sign_ != 0; }
  /// +1 or -1: direction of that turn about the gripper's x axis; 0 if none.
  double rollSign() const { return roll_sign_; }

  /// An upper bound of the distance (m) between the first moving joint's
  /// origin and the gripper while the height joint stands at 0, and that origin
  /// in the base frame.
  double reachBound() const { return reach_bound_; }
  const Eigen::Vector3d& firstJointOrigin() const { return first_origin_; }

  /// Changes with all that shapes what is reachable: transforms, axes, kinds
  /// and limits of joints, solids that may collide; not with names or speeds.
  std::uint64_t hash() const { return hash_; }

 private:
  /// Fixed part before a joint, with the joint's axis turned to z, so that the
  /// motion itself is a plane rotation or a slide along z.
  struct Joint {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;
    bool prismatic = false;
    bool continuous = false;
  };

  void addJoint(const UrdfJoint& joint, Pose& pending);
  void findSpecialJoints();
  void computeReachAndHash();

  std::string robot_name_;
  std::string base_link_;
  std::string tip_link_;
  std::vector<Joint> joints_;
  Eigen::Matrix3d end_rotation_;
  Eigen::Vector3d end_translation_;
  std::vector<std::string> names_;
  Eigen::VectorXd lower_;
  Eigen::VectorXd upper_;
  Eigen::VectorXd velocity_;
  int height_joint_ = -1;
  double height_sign_ = 1;
  int pan_joint_ = -1;
  double pan_sign_ = 1;
  Eigen::Vector2d pan_origin_ = Eigen::Vector2d::Zero();
  double roll_sign_ = 0;
  double reach_bound_ = 0;
  Eigen::Vector3d first_origin_ = Eigen::Vector3d::Zero();
  std::uint64_t hash_ = 0;
  std::shared_ptr<const SelfCollision> self_collision_;
};

/// A joint vector uniform within the limits, drawn from a 64-bit generator.
template <class Random>
Eigen::VectorXd sampleJoints(const Chain& chain, Random& random) {
  Eigen::VectorXd q(chain.dof());
  for (int i = 0; i < chain.dof(); ++i) {
    const double u = static_cast<double>(random() >> 11) * 0x1p-53;
    q[i] = chain.lower()[i] + u * (chain.upper()[i] - chain.lower()[i]);
  }
  return q;
}

}  // namespace graft::lfd
