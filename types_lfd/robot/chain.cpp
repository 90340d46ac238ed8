// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/robot/chain.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "types_lfd/robot/self_collision.hpp"

namespace graft::lfd {

namespace {

constexpr double kPi = 3.14159265358979323846;
// Directions in a URDF are written to 5 or more decimals.
constexpr double kParallel = 1e-4;

[[noreturn]] void fail(const UrdfModel& model, int line, const std::string& text) {
  throw Error(ExitCode::kInput, {model.path, line, 0}, text);
}

/// Joints from base down to tip, by walking up from the tip.
std::vector<const UrdfJoint*> findPath(const UrdfModel& model, const std::string& base,
                                       const std::string& tip) {
  for (const std::string& link : {base, tip}) {
    if (model.findLink(link) < 0) {
      fail(model, 0, "the robot " + quoted(model.name) + " has no link " + quoted(link));
    }
  }
  std::vector<const UrdfJoint*> path;
  std::string at = tip;
  while (at != base) {
    const int up = model.jointAbove(at);
    if (up < 0 || path.size() > model.joints.size()) {
      fail(model, 0,
           "no chain of joints leads from link " + quoted(base) + " down to " + quoted(tip));
    }
    path.push_back(&model.joints[static_cast<std::size_t>(up)]);
    at = path.back()->parent;
  }
  std::reverse(path.begin(), path.end());
  return path;
}

class Fnv {
 public:
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ bytes[i]) * 0x100000001b3ULL;
  }
  void add(double x) {
    const double plain = x == 0 ? 0 : x;  // -0 is 0
    add(&plain, sizeof plain);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

/// R <- R Rz(angle), which only mixes the first two columns.
inline void turnAboutZ(Eigen::Matrix3d& r, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  for (int i = 0; i < 3; ++i) {
    const double a = r(i, 0);
    const double b = r(i, 1);
    r(i, 0) = c * a + s * b;
    r(i, 1) = c * b - s * a;
  }
}

inline void append(Eigen::Matrix3d& r, Eigen::Vector3d& t, const Eigen::Matrix3d& next_r,
                   const Eigen::Vector3d& next_t) {
  t += r * next_t;
  const Eigen::Matrix3d product = r * next_r;
  r = product;
}

}  // namespace

Chain::Chain(const UrdfModel& model, const std::string& base_link, const std::string& tip_link,
             const Pose& tip_T_gripper)
    : robot_name_(model.name), base_link_(base_link), tip_link_(tip_link) {
  const std::vector<const UrdfJoint*> path = findPath(model, base_link, tip_link);
  const auto moving =
      std::count_if(path.begin(), path.end(), [](const UrdfJoint* j) { return j->moves(); });
  const std::string chain = "the chain from " + quoted(base_link) + " to " + quoted(tip_link);
  if (moving == 0) fail(model, 0, chain + " has no moving joint");
  if (moving > kMaximumDof) {
    fail(model, 0,
         chain + " has " + std::to_string(moving) + " moving joints, more than " +
             std::to_string(kMaximumDof));
  }
  lower_.resize(moving);
  upper_.resize(moving);
  velocity_.resize(moving);
  Pose pending;
  for (const UrdfJoint* joint : path) {
    if (joint->type == UrdfJoint::Type::kOther) {
      fail(model, joint->line,
           "joint " + quoted(joint->name) + " is planar or floating, which " +
               "is not supported on " + chain);
    }
    if (joint->mimic) {
      fail(model, joint->line,
           "joint " + quoted(joint->name) + " mimics " + quoted(joint->mimic->joint) +
               ", which is not supported on " + chain);
    }
    pending = pending * joint->parent_T_joint;
    if (joint->moves()) addJoint(*joint, pending);
  }
  pending = pending * tip_T_gripper;
  end_rotation_ = pending.rotation.normalized().toRotationMatrix();
  end_translation_ = pending.translation;
  findSpecialJoints();
  computeReachAndHash();
}

void Chain::addJoint(const UrdfJoint& joint, Pose& pending) {
  const Eigen::Quaterniond to_axis =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), joint.axis);
  const Eigen::Index i = dof();
  Joint added;
  added.rotation = (pending.rotation * to_axis).normalized().toRotationMatrix();
  added.translation = pending.translation;
  added.prismatic = joint.type == UrdfJoint::Type::kPrismatic;
  added.continuous = joint.type == UrdfJoint::Type::kContinuous;
  lower_[i] = added.continuous ? -kPi : joint.lower;
  upper_[i] = added.continuous ? kPi : joint.upper;
  velocity_[i] = joint.velocity > 0 ? joint.velocity : std::numeric_limits<double>::infinity();
  names_.push_back(joint.name);
  joints_.push_back(added);
  pending = Pose(Eigen::Vector3d::Zero(), to_axis.conjugate());
}

void Chain::findSpecialJoints() {
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  for (int i = 0; i < dof(); ++i) {
    const Joint& joint = joints_[static_cast<std::size_t>(i)];
    r = r * joint.rotation;
    const double up = r(2, 2);
    const bool vertical = std::abs(std::abs(up) - 1) < kParallel * kParallel;
    if (joint.prismatic && vertical) {
      height_joint_ = i;
      height_sign_ = up > 0 ? 1 : -1;
      break;
    }
    // A turn about the vertical keeps later directions vertical; any other
    // does not.
    if (!joint.prismatic && !vertical) break;
  }
  // The pan joint: nothing before it but a torso, which does not move it aside.
  const int before = height_joint_ == 0 ? 1 : 0;
  if (before < dof() - 1) {
    Eigen::Vector3d t = Eigen::Vector3d::Zero();
    r = Eigen::Matrix3d::Identity();
    for (int i = 0; i <= before; ++i) {
      const Joint& joint = joints_[static_cast<std::size_t>(i)];
      append(r, t, joint.rotation, joint.translation);
    }
    const bool vertical = std::abs(std::abs(r(2, 2)) - 1) < kParallel * kParallel;
    if (vertical && !joints_[static_cast<std::size_t>(before)].prismatic) {
      pan_joint_ = before;
      pan_sign_ = r(2, 2) > 0 ? 1 : -1;
      pan_origin_ = t.head<2>();
    }
  }
  const Joint& last = joints_.back();
  // Gripper's x axis and origin as the last joint sees them: along z, on z.
  const Eigen::Vector3d x = end_rotation_.col(0);
  const bool on_axis = end_translation_.head<2>().norm() < 1e-6;
  if (!last.prismatic && on_axis && x.head<2>().norm() < kParallel) roll_sign_ = x[2] > 0 ? 1 : -1;
}

void Chain::computeReachAndHash() {
  first_origin_ = joints_.front().translation;
  reach_bound_ = end_translation_.norm();
  Fnv hash;
  for (int i = 0; i < dof(); ++i) {
    const Joint& joint = joints_[static_cast<std::size_t>(i)];
    if (i > 0) reach_bound_ += joint.translation.norm();
    if (joint.prismatic && i != height_joint_)
      reach_bound_ += std::max(std::abs(lower_[i]), std::abs(upper_[i]));
    for (int k = 0; k < 9; ++k) hash.add(joint.rotation.data()[k]);
    for (int k = 0; k < 3; ++k) hash.add(joint.translation[k]);
    hash.add((joint.prismatic ? 2.0 : 0.0) + (joint.continuous ? 1.0 : 0.0));
    hash.add(lower_[i]);
    hash.add(upper_[i]);
  }
  for (int k = 0; k < 9; ++k) hash.add(end_rotation_.data()[k]);
  for (int k = 0; k < 3; ++k) hash.add(end_translation_[k]);
  hash_ = hash.value();
}

void Chain::forward(const double* q, Eigen::Matrix3d& rotation,
                    Eigen::Vector3d& translation) const {
  rotation = joints_.front().rotation;
  translation = joints_.front().translation;
  for (std::size_t i = 0;;) {
    if (joints_[i].prismatic) {
      translation += q[i] * rotation.col(2);
    } else {
      turnAboutZ(rotation, q[i]);
    }
    if (++i == joints_.size()) break;
    append(rotation, translation, joints_[i].rotation, joints_[i].translation);
  }
  append(rotation, translation, end_rotation_, end_translation_);
}

Pose Chain::forward(const double* q) const {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  forward(q, rotation, translation);
  return Pose(translation, Eigen::Quaterniond(rotation).normalized());
}

void Chain::jacobian(const double* q, Pose& base_T_gripper, Jacobian& jacobian) const {
  jacobian.resize(6, dof());
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  // First pass: the axis direction below, the point on the axis above.
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    append(r, t, joints_[i].rotation, joints_[i].translation);
    const auto column = static_cast<Eigen::Index>(i);
    jacobian.col(column).head<3>() = t;
    jacobian.col(column).tail<3>() = r.col(2);
    if (joints_[i].prismatic) {
      t += q[i] * r.col(2);
    } else {
      turnAboutZ(r, q[i]);
    }
  }
  append(r, t, end_rotation_, end_translation_);
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    auto column = jacobian.col(static_cast<Eigen::Index>(i));
    const Eigen::Vector3d axis = column.tail<3>();
    if (joints_[i].prismatic) {
      column.head<3>() = axis;
      column.tail<3>().setZero();
    } else {
      const Eigen::Vector3d arm = t - column.head<3>();
      column.head<3>() = axis.cross(arm);
    }
  }
  base_T_gripper = Pose(t, Eigen::Quaterniond(r).normalized());
}

Eigen::Matrix3Xd Chain::origins(const Eigen::VectorXd& q) const {
  Eigen::Matrix3Xd points(3, dof());
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    append(r, t, joints_[i].rotation, joints_[i].translation);
    points.col(column) = t;
    if (joints_[i].prismatic) {
      t += q[column] * r.col(2);
    } else {
      turnAboutZ(r, q[column]);
    }
  }
  return points;
}

void Chain::bodies(const double* q, BodyFrames& frames) const {
  frames.rotation.resize(joints_.size() + 1);
  frames.translation.resize(joints_.size() + 1);
  frames.rotation[0].setIdentity();
  frames.translation[0].setZero();
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    Eigen::Matrix3d& r = frames.rotation[i + 1] = frames.rotation[i];
    Eigen::Vector3d& t = frames.translation[i + 1] = frames.translation[i];
    append(r, t, joints_[i].rotation, joints_[i].translation);
    if (joints_[i].prismatic) {
      t += q[i] * r.col(2);
    } else {
      turnAboutZ(r, q[i]);
    }
  }
}

void Chain::setSelfCollision(std::shared_ptr<const SelfCollision> self_collision) {
  self_collision_.reset();
  computeReachAndHash();
  if (self_collision == nullptr || self_collision->empty()) return;
  self_collision_ = std::move(self_collision);
  hash_ ^= self_collision_->hash();
}

bool Chain::hitsItself(const Eigen::VectorXd& q) const {
  if (self_collision_ == nullptr) return false;
  thread_local BodyFrames frames;
  bodies(q.data(), frames);
  return self_collision_->collides(frames);
}

}  // namespace graft::lfd
