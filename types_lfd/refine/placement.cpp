// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/refine/placement.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "types_lfd/build/graph_builder.hpp"

namespace graft::lfd {

namespace {

constexpr double kTurnRadius = 0.3;
constexpr double kBaseSpeed = 1.5;  // m/s
constexpr double kBaseTurn = 2.0;   // rad/s

/// To a hundredth of a millimetre (radian). Arms at their speed limits and choices of
/// postures multiply what poses carry of rounding until the same scene elsewhere ends
/// elsewhere; rounded, both begin with the same bits.
double rounded(double value) {
  constexpr double kGrid = 0x1p-17;
  return std::round(value / kGrid) * kGrid;
}

}  // namespace

double BaseOffset::length() const {
  return std::sqrt(x * x + y * y + std::pow(kTurnRadius * yaw, 2));
}

BaseOffset interpolate(const BaseOffset& a, const BaseOffset& b, double f) {
  return {a.x + f * (b.x - a.x), a.y + f * (b.y - a.y), a.yaw + f * (b.yaw - a.yaw)};
}

Placement::Placement(const DemonstrationEstimate& demo, const TaskScene& scene)
    : demo_(demo), scene_(scene), box_(*scene.chain) {
  // Attempts start near a solution, where steps converge quadratically: one that
  // does not is lost, and most of the time goes into those.
  ik_.iterations = 10;
  ik_.stall = 0.3;
  if (demo.size() > 0) {
    const double heading = demo.base[demo.segments.grasp].theta;
    cosine_ = std::cos(heading);
    sine_ = std::sin(heading);
    const Pose2 back = demo.base[demo.segments.grasp].inverse();
    for (std::size_t i = 0; i < demo.size(); ++i) {
      const Pose2 base = back * demo.base[i];
      base_.emplace_back(rounded(base.x), rounded(base.y), rounded(wrapAngle(base.theta)));
      const Pose gripper = floorPose(back) * demo.gripper[i];
      gripper_.emplace_back(
          Vec<double, 3>(gripper.translation.unaryExpr(&rounded)),
          Eigen::Quaterniond(Eigen::Vector4d(gripper.rotation.coeffs().unaryExpr(&rounded)))
              .normalized());
    }
  }
}

void Placement::holdHeight(double height) {
  const int joint = chain().heightJoint();
  if (joint < 0) return;
  const bool held = !std::isnan(height);
  box_.lower[joint] = held ? height : chain().lower()[joint];
  box_.upper[joint] = held ? height : chain().upper()[joint];
}

Pose2 Placement::base(std::size_t i, const BaseOffset& offset) const {
  const Pose2& b = demo_.base[i];
  if (offset.zero()) return b;
  return {b.x + cosine_ * offset.x - sine_ * offset.y, b.y + sine_ * offset.x + cosine_ * offset.y,
          wrapAngle(b.theta + offset.yaw)};
}

BaseOffset Placement::between(std::size_t i, std::size_t begin, const BaseOffset& at_begin,
                              std::size_t end, const BaseOffset& at_end) const {
  if (at_begin.zero() && at_end.zero()) return {};
  const double f = seconds(begin, i) / seconds(begin, end);
  const Pose2 a = seenBase(begin, at_begin);
  const Pose2 b = seenBase(end, at_end);
  const Pose2& here = base_[i];
  const double theta = a.theta + f * wrapAngle(b.theta - a.theta);
  return {a.x + f * (b.x - a.x) - here.x, a.y + f * (b.y - a.y) - here.y,
          wrapAngle(theta - here.theta)};
}

Pose2 Placement::seenBase(std::size_t i, const BaseOffset& offset) const {
  const Pose2& b = base_[i];
  return {b.x + offset.x, b.y + offset.y, wrapAngle(b.theta + offset.yaw)};
}

Pose Placement::baseToGripper(std::size_t i, const BaseOffset& offset) const {
  return floorPose(seenBase(i, offset)).inverse() * gripper_[i];
}

bool Placement::collides(std::size_t i, const BaseOffset& offset) const {
  return scene_.footprint != nullptr && scene_.footprint->inCollision(base(i, offset));
}

bool Placement::reaches(std::size_t i, const BaseOffset& offset) const {
  return scene_.reach->contains(demo_.gripper[i], base(i, offset));
}

bool Placement::stands(std::size_t i, const BaseOffset& offset) const {
  return !collides(i, offset) && reaches(i, offset);
}

bool Placement::wayFree(std::size_t i, const BaseOffset& a, const BaseOffset& b) const {
  return scene_.footprint == nullptr || scene_.footprint->pathFree(base(i, a), base(i + 1, b));
}

bool Placement::sees(std::size_t i, const Placed& placed) const {
  if (scene_.map == nullptr) return true;
  const Eigen::Matrix3Xd origins = chain().origins(placed.joints);
  const int shoulder = std::min(chain().heightJoint() + 1, chain().dof() - 1);
  const Pose2 stand = base(i, placed.offset);
  const auto onFloor = [&](const Eigen::Vector3d& p) -> Eigen::Vector2d {
    return stand * Vec<double, 2>(p.head<2>());
  };
  const Eigen::Vector2d from = onFloor(origins.col(shoulder));
  if (!scene_.map->segmentFree(from, onFloor(origins.col(chain().dof() - 1)))) return false;
  // A gripper that holds something in the map cannot be seen.
  const Eigen::Vector2d gripper = demo_.gripper[i].translation.head<2>();
  return scene_.map->occupied(gripper.x(), gripper.y()) || scene_.map->segmentFree(from, gripper);
}

std::optional<Eigen::VectorXd> Placement::solveArm(std::size_t i, const BaseOffset& offset,
                                                   const Eigen::VectorXd& start) const {
  Placed placed{offset, start};
  if (!refineIk(chain(), baseToGripper(i, offset), ik_, box_, placed.joints)) return std::nullopt;
  if (!sees(i, placed)) return std::nullopt;
  return placed.joints;
}

std::optional<Eigen::VectorXd> Placement::solveArmBetween(std::size_t i, const BaseOffset& offset,
                                                          const Eigen::VectorXd& start,
                                                          const Eigen::VectorXd* before,
                                                          const Eigen::VectorXd* after,
                                                          double factor) const {
  IkBox box = box_;
  const auto limit = [&](const Eigen::VectorXd& neighbour, double time) {
    // In the turn of the start, as solutions near it are.
    const Eigen::VectorXd q = start + jointStep(start, neighbour);
    for (int j = 0; j < chain().dof(); ++j) {
      // A hair less than allowed, so that rounding does not count.
      const double reach = factor * chain().velocity()[j] * time * (1 - 1e-9);
      if (!std::isfinite(reach)) continue;
      box.lower[j] = std::max(box.lower[j], q[j] - reach);
      box.upper[j] = std::min(box.upper[j], q[j] + reach);
    }
  };
  if (before != nullptr) limit(*before, seconds(i - 1, i));
  if (after != nullptr) limit(*after, seconds(i, i + 1));
  if ((box.lower.array() > box.upper.array()).any()) return std::nullopt;
  Placed placed{offset, start};
  if (!refineIk(chain(), baseToGripper(i, offset), ik_, box, placed.joints)) return std::nullopt;
  if (!sees(i, placed)) return std::nullopt;
  return placed.joints;
}

Eigen::VectorXd Placement::jointStep(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  Eigen::VectorXd step = b - a;
  for (int j = 0; j < chain().dof(); ++j) {
    if (chain().continuous(j)) step[j] = wrapAngle(step[j]);
  }
  return step;
}

double Placement::speedRatio(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                             double seconds) const {
  const Eigen::VectorXd step = jointStep(a, b);
  double ratio = 0;
  for (int j = 0; j < chain().dof(); ++j) {
    const double allowed = chain().velocity()[j] * seconds;
    if (std::isfinite(allowed)) ratio = std::max(ratio, std::abs(step[j]) / allowed);
  }
  return ratio;
}

double Placement::baseSpeedRatio(std::size_t a, const BaseOffset& at_a, std::size_t b,
                                 const BaseOffset& at_b) const {
  const Pose2 from = seenBase(a, at_a);
  const Pose2 to = seenBase(b, at_b);
  const double speed = std::hypot(to.x - from.x, to.y - from.y) / kBaseSpeed;
  const double turn = std::abs(wrapAngle(to.theta - from.theta)) / kBaseTurn;
  return std::max(speed, turn) / seconds(a, b);
}

std::vector<Eigen::VectorXd> Placement::findPostures(std::uint64_t seed) const {
  constexpr std::size_t kInstants = 6;
  constexpr int kAttempts = 12;
  constexpr std::size_t kPostures = 8;
  constexpr double kDifferent = 0.7;  // rad
  IkOptions far;
  far.iterations = 30;
  std::mt19937_64 random(seed);
  std::vector<Eigen::VectorXd> postures;
  for (std::size_t k = 0; k < kInstants; ++k) {
    const std::size_t i = (size() - 1) * k / (kInstants - 1);
    for (int attempt = 0; attempt < kAttempts && postures.size() < kPostures; ++attempt) {
      Placed placed{{}, sampleJoints(chain(), random)};
      Eigen::VectorXd& q = placed.joints;
      if (!refineIk(chain(), baseToGripper(i, {}), far, box_, q) || !sees(i, placed)) continue;
      const bool known = std::any_of(postures.begin(), postures.end(), [&](const auto& p) {
        return jointStep(p, q).cwiseAbs().maxCoeff() < kDifferent;
      });
      if (!known) postures.push_back(q);
    }
  }
  if (postures.empty()) postures.push_back(0.5 * (chain().lower() + chain().upper()));
  return postures;
}

}  // namespace graft::lfd
