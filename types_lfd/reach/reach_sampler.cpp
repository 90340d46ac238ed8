// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_sampler.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace graft::lfd {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kFullTurn = 2 * kPi - 1e-9;

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

}  // namespace

double manipulability(const Chain::Jacobian& jacobian) {
  if (jacobian.cols() >= 6) {
    const Eigen::Matrix<double, 6, 6> gram = jacobian.lazyProduct(jacobian.transpose());
    return std::sqrt(std::max(0.0, gram.determinant()));
  }
  const Eigen::MatrixXd gram = jacobian.transpose() * jacobian;
  return std::sqrt(std::max(0.0, gram.determinant()));
}

/// A gripper pose with all swept joints at 0, split as ReachGrid does.
struct ReachSampler::Sample {
  Eigen::VectorXd q;
  Eigen::Matrix3d rotation;
  Eigen::Vector3d position;
  int ring = 0;
  double azimuth = 0;
  double roll = 0;
};

ReachSampler::ReachSampler(const Chain& chain, const ReachGrid& grid, double core,
                           double best_manipulability)
    : chain_(chain),
      grid_(grid),
      half_core_(0.5 * core),
      half_core_angle_(0.5 * core * grid.step()),
      best_(best_manipulability),
      torso_(chain.heightJoint()),
      // With all of a cell as its core, psi is what was sampled, not a centre.
      pan_(core < 1 ? chain.panJoint() : -1),
      rolls_(chain.lastJointRolls()) {
  const auto range = [&](int joint, double sign) {
    const double a = sign * chain.lower()[joint];
    const double b = sign * chain.upper()[joint];
    return Range{std::min(a, b), std::max(a, b)};
  };
  if (torso_ >= 0) heights_ = range(torso_, chain.heightSign());
  if (pan_ >= 0) {
    pans_ = range(pan_, chain.panSign());
    pan_origin_ = chain.panOrigin();
  }
  if (rolls_) roll_range_ = range(chain.dof() - 1, chain.rollSign());
  for (int p = 0; p < grid.turn; ++p) {
    // Heading -psi in the base's frame.
    turned_pan_origin_.push_back(Eigen::Rotation2Dd(p * grid.step()) * pan_origin_);
  }
}

void ReachSampler::run(std::mt19937_64& random, std::uint64_t count, ReachMarks& marks) const {
  Sample s;
  s.q = Eigen::VectorXd::Zero(chain_.dof());
  for (std::uint64_t i = 0; i < count; ++i) {
    for (int j = 0; j < chain_.dof(); ++j) {
      if (j == torso_ || j == pan_ || (rolls_ && j == chain_.dof() - 1)) continue;
      s.q[j] = chain_.lower()[j] + uniform(random) * (chain_.upper()[j] - chain_.lower()[j]);
    }
    chain_.forward(s.q.data(), s.rotation, s.position);
    const double elevation = std::asin(std::clamp(s.rotation(2, 0), -1.0, 1.0));
    s.ring = static_cast<int>(std::lround(elevation / grid_.step()));
    if (std::abs(elevation - s.ring * grid_.step()) > half_core_angle_) continue;
    ReachGrid::split(s.rotation, s.azimuth, s.roll);
    if (std::abs(s.ring) < grid_.turn / 4) {
      markRing(s, marks);
    } else {
      markCap(s, random, marks);
    }
  }
}

bool ReachSampler::turnsTo(double angle, double target, Range range) const {
  if (range.high - range.low >= kFullTurn) return true;
  // The turn that is needed, as the first at or above the range's low end.
  const double low = range.low - half_core_angle_;
  const double turn = target - angle;
  const double first = turn - 2 * kPi * std::floor((turn - low) / (2 * kPi));
  return first <= range.high + half_core_angle_;
}

void ReachSampler::markRing(const Sample& s, ReachMarks& marks) const {
  const Eigen::Vector2d from_pan =
      Eigen::Rotation2Dd(-s.azimuth) * (s.position.head<2>() - pan_origin_);
  const Range rolls{s.roll + roll_range_.low, s.roll + roll_range_.high};
  for (int p = 0; p < grid_.turn; ++p) {
    if (!turnsTo(s.azimuth, -p * grid_.step(), pans_)) continue;
    const Eigen::Vector2d u = -(turned_pan_origin_[static_cast<std::size_t>(p)] + from_pan);
    mark(s, u[0], u[1], p, rolls, marks);
  }
}

void ReachSampler::markCap(const Sample& s, std::mt19937_64& random, ReachMarks& marks) const {
  const double sign = s.ring > 0 ? 1 : -1;
  const double heading = s.azimuth + sign * s.roll;
  const Eigen::Vector2d from_pan = s.position.head<2>() - pan_origin_;
  const auto markAt = [&](int p, const Eigen::Vector2d& position) {
    const Eigen::Vector2d u = -(Eigen::Rotation2Dd(p * grid_.step()) * position);
    mark(s, u[0], u[1], p, {0, 0}, marks);
  };
  if (!rolls_) {
    for (int p = 0; p < grid_.turn; ++p) {
      const double target = -p * grid_.step();
      if (!turnsTo(heading, target, pans_)) continue;
      const double turn = pan_ >= 0 ? target - heading : 0;
      markAt(p, pan_origin_ + Eigen::Rotation2Dd(turn) * from_pan);
    }
    return;
  }
  const Range headings = sign > 0 ? roll_range_ : Range{-roll_range_.high, -roll_range_.low};
  const int strata = pan_ >= 0 ? grid_.turn : 1;
  for (int k = 0; k < strata; ++k) {
    const double turn = pans_.low + (pans_.high - pans_.low) * (k + uniform(random)) / strata;
    const Eigen::Vector2d position = pan_origin_ + Eigen::Rotation2Dd(turn) * from_pan;
    for (int p = 0; p < grid_.turn; ++p) {
      if (turnsTo(heading + turn, -p * grid_.step(), headings)) markAt(p, position);
    }
  }
}

void ReachSampler::mark(const Sample& s, double ux, double uy, int psi, Range rolls,
                        ReachMarks& marks) const {
  const double cx = ux / grid_.resolution - 0.5;
  const double cy = uy / grid_.resolution - 0.5;
  const double x_near = std::round(cx);
  const double y_near = std::round(cy);
  if (std::abs(cx - x_near) > half_core_ || std::abs(cy - y_near) > half_core_) return;
  const int x = static_cast<int>(x_near) - grid_.x0;
  const int y = static_cast<int>(y_near) - grid_.y0;
  if (x < 0 || y < 0 || x >= grid_.nx || y >= grid_.ny) return;
  const auto bins = [&](double low, double high, double size, double offset) {
    return std::pair<int, int>(static_cast<int>(std::ceil(low / size - offset - half_core_)),
                               static_cast<int>(std::floor(high / size - offset + half_core_)));
  };
  const auto [z_low, z_high] =
      bins(s.position[2] + heights_.low, s.position[2] + heights_.high, grid_.resolution, 0.5);
  const int z_first = std::max(0, z_low - grid_.z0);
  const int z_last = std::min(grid_.nz - 1, z_high - grid_.z0);
  if (z_first > z_last) return;
  const std::size_t column = marks.column(s.ring, psi, y, x);
  if (std::abs(s.ring) == grid_.turn / 4) {
    marks.raise(column, 0, z_first, z_last, quality(s));
    return;
  }
  const auto [roll_first, roll_high] = bins(rolls.low, rolls.high, grid_.step(), 0);
  const int roll_last = std::min(roll_high, roll_first + grid_.turn - 1);
  if (roll_first > roll_last) return;
  const std::uint8_t q = quality(s);
  for (int bin = roll_first; bin <= roll_last; ++bin) {
    marks.raise(column, ((bin % grid_.turn) + grid_.turn) % grid_.turn, z_first, z_last, q);
  }
}

/// Neither torso, pan nor the last roll change the manipulability.
std::uint8_t ReachSampler::quality(const Sample& s) const {
  if (!(best_ > 0)) return 1;
  Chain::Jacobian jacobian(6, chain_.dof());
  Pose pose;
  chain_.jacobian(s.q.data(), pose, jacobian);
  const double share = manipulability(jacobian) / best_;
  return static_cast<std::uint8_t>(1 + std::clamp(std::floor(255 * share), 0.0, 254.0));
}

}  // namespace graft::lfd
