// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_sampler.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace graft::lfd {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kFullTurn = 2 * kPi - 1e-3;
constexpr int kCorrections = 4;
constexpr double kAligned = 2e-3;    // rad
constexpr double kFreeMatch = 0.06;  // rad

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

/// The turn in the range that equals `turn` modulo full turns, if any.
template <class Range>
bool inRange(double& turn, const Range& range) {
  turn -= 2 * kPi * std::floor((turn - range.low) / (2 * kPi));
  return turn <= range.high || range.high - range.low >= kFullTurn;
}

}  // namespace

bool anyRoll(const Chain& chain) {
  const int last = chain.dof() - 1;
  return chain.lastJointRolls() && chain.upper()[last] - chain.lower()[last] >= kFullTurn;
}

double manipulability(const Chain::Jacobian& jacobian) {
  if (jacobian.cols() >= 6) {
    const Eigen::Matrix<double, 6, 6> gram = jacobian.lazyProduct(jacobian.transpose());
    return std::sqrt(std::max(0.0, gram.determinant()));
  }
  const Eigen::MatrixXd gram = jacobian.transpose() * jacobian;
  return std::sqrt(std::max(0.0, gram.determinant()));
}

/// A gripper pose with all swept joints at 0.
struct ReachSampler::Sample {
  Eigen::VectorXd q;
  Pose pose;
  Chain::Jacobian jacobian;
  GripperView view;
  int ring = 0;
  std::uint8_t quality = 0;
  /// Heights of the torso at which the robot does not hit itself.
  std::vector<Range> clear;
  /// For the test of self-collision: joints with the swept ones where they are
  /// tested, and pairs that sweeping may bring together.
  Eigen::VectorXd posture;
  SelfCollision::Subset pan_pairs;
  SelfCollision::Subset torso_pairs;
  SelfCollision::Subset near;
  BodyFrames bodies;
};

ReachSampler::ReachSampler(const Chain& chain, const ReachGrid& grid, bool thin,
                           double best_manipulability)
    : chain_(chain),
      grid_(grid),
      thin_(thin),
      best_(best_manipulability),
      torso_(chain.heightJoint()),
      pan_(thin ? -1 : chain.panJoint()),
      rolls_(!thin && chain.lastJointRolls()) {
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
  for (int j = 0; j < chain.dof(); ++j) {
    if (j != torso_ && j != pan_ && !(rolls_ && j == chain.dof() - 1)) sampled_.push_back(j);
  }
  if (const SelfCollision* self = chain.selfCollision()) {
    arm_pairs_ = self->pairsMovedBy({}, {torso_, pan_});
    pan_pairs_ = self->pairsMovedBy({pan_}, {torso_});
    torso_pairs_ = self->pairsMovedBy({torso_}, {});
  }
}

/// Whatever torso and pan do. Also finds the pairs that these may bring together.
bool ReachSampler::armHitsItself(Sample& s) const {
  s.clear.assign(1, heights_);
  const SelfCollision* self = chain_.selfCollision();
  if (self == nullptr) return false;
  s.posture = s.q;
  const auto stand = [&](int joint, double value) {
    if (joint >= 0) s.posture[joint] = value;
  };
  const int last = chain_.dof() - 1;
  if (rolls_) stand(last, std::clamp(0.0, chain_.lower()[last], chain_.upper()[last]));
  stand(pan_, 0);
  stand(torso_, chain_.heightSign() * heights_.low);
  chain_.bodies(s.posture.data(), s.bodies);
  if (self->collides(s.bodies, arm_pairs_)) return true;
  const Eigen::Vector2d* axis = pan_ >= 0 ? &pan_origin_ : nullptr;
  self->keepNear(s.bodies, pan_pairs_, 0, axis, s.pan_pairs);
  self->keepNear(s.bodies, torso_pairs_, heights_.high - heights_.low, axis, s.torso_pairs);
  return false;
}

void ReachSampler::findClear(Sample& s, double turn, double voxel) const {
  if (s.pan_pairs.empty() && s.torso_pairs.empty()) return;
  const SelfCollision& self = *chain_.selfCollision();
  if (pan_ >= 0) s.posture[pan_] = chain_.panSign() * turn;
  if (torso_ >= 0) s.posture[torso_] = chain_.heightSign() * heights_.low;
  chain_.bodies(s.posture.data(), s.bodies);
  s.clear.clear();
  if (self.collides(s.bodies, s.pan_pairs)) return;
  const double span = heights_.high - heights_.low;
  self.keepNear(s.bodies, s.torso_pairs, span, nullptr, s.near);
  if (s.near.empty()) {
    s.clear.push_back(heights_);
    return;
  }
  const int steps = static_cast<int>(std::ceil(span / voxel));
  const double step = steps > 0 ? span / steps : 0;
  bool open = false;
  for (int k = 0; k <= steps; ++k) {
    const double height = heights_.low + k * step;
    s.posture[torso_] = chain_.heightSign() * height;
    chain_.bodies(s.posture.data(), s.bodies);
    if (self.collides(s.bodies, s.near)) {
      open = false;
    } else if (open) {
      s.clear.back().high = height;
    } else {
      s.clear.push_back({height, height});
      open = true;
    }
  }
}

void ReachSampler::run(std::mt19937_64& random, std::uint64_t count, ReachMarks& marks) const {
  Sample s;
  s.q = Eigen::VectorXd::Zero(chain_.dof());
  s.jacobian.resize(6, chain_.dof());
  for (std::uint64_t i = 0; i < count; ++i) {
    for (const int j : sampled_) {
      s.q[j] = chain_.lower()[j] + uniform(random) * (chain_.upper()[j] - chain_.lower()[j]);
    }
    if (thin_) {
      if (armHitsItself(s)) continue;
      chain_.jacobian(s.q.data(), s.pose, s.jacobian);
      s.view = ReachGrid::view(s.pose);
      s.quality = quality(s);
      markAround(s, marks);
      continue;
    }
    if (!toNode(s) || armHitsItself(s)) continue;
    s.quality = quality(s);
    if (s.ring == 0 || s.ring == grid_.ringCount() - 1) {
      markPole(s, random, marks);
    } else {
      markRing(s, marks);
    }
  }
}

int ReachSampler::wrapPsi(int psi) const {
  const int count = grid_.psiCount();
  return ((psi % count) + count) % count;
}

/// Least motion of the sampled joints that turns the gripper to the nearest
/// node: the approach axis, and what of azimuth and roll is not swept.
bool ReachSampler::toNode(Sample& s) const {
  chain_.jacobian(s.q.data(), s.pose, s.jacobian);
  s.view = ReachGrid::view(s.pose);
  s.ring = static_cast<int>(std::lround(s.view.elevation / grid_.nodeStep())) + grid_.level();
  const double elevation = grid_.elevationOf(s.ring);
  const bool pole = s.ring == 0 || s.ring == grid_.ringCount() - 1;
  // On a pole the combined heading may be whatever it is.
  double azimuth = s.view.heading;
  double roll = s.view.roll;
  if (!pole) {
    if (pan_ < 0) azimuth = grid_.nodeStep() * std::round(azimuth / grid_.nodeStep());
    if (!rolls_) roll = grid_.rollStep() * std::round(roll / grid_.rollStep());
  }
  const bool fix_roll = !rolls_ && !pole;
  const Eigen::Vector3d approach(std::cos(elevation) * std::cos(azimuth),
                                 std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  const Eigen::Quaterniond target = Eigen::AngleAxisd(azimuth, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(-elevation, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
  for (int iteration = 0;; ++iteration) {
    const Eigen::Vector3d x = s.pose.rotation * Eigen::Vector3d::UnitX();
    Eigen::Vector3d turn = x.cross(approach);
    if (fix_roll) turn = logSO3(Eigen::Quaterniond(target * s.pose.rotation.conjugate()));
    if (turn.norm() < kAligned) break;
    if (iteration == kCorrections) return false;
    Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
    const auto row = [&](int j) {
      Eigen::Vector3d axis = s.jacobian.col(j).tail<3>();
      if (!fix_roll) axis -= x.dot(axis) * x;
      return axis;
    };
    for (const int j : sampled_) {
      const Eigen::Vector3d axis = row(j);
      gram += axis * axis.transpose();
    }
    gram.diagonal().array() += 1e-6;
    const Eigen::Vector3d weights = gram.llt().solve(turn);
    for (const int j : sampled_) {
      const double q = s.q[j] + row(j).dot(weights);
      s.q[j] = chain_.continuous(j) ? q : std::clamp(q, chain_.lower()[j], chain_.upper()[j]);
    }
    chain_.jacobian(s.q.data(), s.pose, s.jacobian);
  }
  s.view = ReachGrid::view(s.pose);
  return true;
}

void ReachSampler::markRing(Sample& s, ReachMarks& marks) const {
  const Eigen::Vector2d from_pan = s.pose.translation.head<2>() - pan_origin_;
  const double step = grid_.nodeStep();
  // Rolls that the last joint turns to, once for all psi.
  int rolls[ReachGrid::kMostTurn];
  int count = 0;
  if (grid_.rolls == 1) {
    rolls[count++] = 0;
  } else if (rolls_) {
    for (int r = 0; r < grid_.rolls; ++r) {
      double turn = r * grid_.rollStep() - s.view.roll;
      if (inRange(turn, roll_range_)) rolls[count++] = r;
    }
  } else {
    const int r = static_cast<int>(std::lround(s.view.roll / grid_.rollStep()));
    rolls[count++] = (r + grid_.rolls) % grid_.rolls;
  }
  if (pan_ < 0) {
    findClear(s, 0, marks.voxel());
    const int psi = wrapPsi(-static_cast<int>(std::lround(s.view.heading / step)));
    for (int k = 0; k < count; ++k) {
      mark(s, s.pose.translation.head<2>(), s.ring, rolls[k], psi, marks);
    }
    return;
  }
  for (int p = 0; p < grid_.psiCount(); ++p) {
    double turn = -p * step - s.view.heading;
    if (!inRange(turn, pans_)) continue;
    findClear(s, turn, marks.voxel());
    const Eigen::Vector2d position = pan_origin_ + Eigen::Rotation2Dd(turn) * from_pan;
    for (int k = 0; k < count; ++k) mark(s, position, s.ring, rolls[k], p, marks);
  }
}

/// Straight up or down heading and roll turn about the same axis: their sum
/// (or difference) has to be right, and the pan joint has a choice.
void ReachSampler::markPole(Sample& s, std::mt19937_64& random, ReachMarks& marks) const {
  const double sign = s.ring > 0 ? 1 : -1;
  const double combined = s.view.heading + sign * s.view.roll;
  const Eigen::Vector2d from_pan = s.pose.translation.head<2>() - pan_origin_;
  const int strata = pan_ >= 0 && rolls_ ? grid_.turn : 1;
  for (int k = 0; k < strata; ++k) {
    const double share = pan_ >= 0 && rolls_ ? (k + uniform(random)) / strata : 0;
    const double pan = pans_.low + (pans_.high - pans_.low) * share;
    for (int p = 0; p < grid_.psiCount(); ++p) {
      for (int r = 0; r < grid_.rolls; ++r) {
        const double needed = -p * grid_.nodeStep() + sign * r * grid_.rollStep() - combined;
        double turn = 0;
        if (rolls_) {
          double roll = sign * (needed - pan);
          if (!inRange(roll, roll_range_)) continue;
          turn = pan_ >= 0 ? pan : 0;
        } else if (pan_ >= 0) {
          turn = needed;
          if (!inRange(turn, pans_)) continue;
        } else if (std::abs(wrapAngle(needed)) > kFreeMatch) {
          continue;
        }
        findClear(s, turn, marks.voxel());
        mark(s, pan_origin_ + Eigen::Rotation2Dd(turn) * from_pan, s.ring, r, p, marks);
      }
    }
  }
}

void ReachSampler::markAround(Sample& s, ReachMarks& marks) const {
  findClear(s, 0, marks.voxel());
  const double ring = s.view.elevation / grid_.nodeStep() + grid_.level();
  const double psi = -s.view.heading / grid_.nodeStep();
  const double roll = s.view.roll / grid_.rollStep();
  for (const double k : {std::floor(ring), std::ceil(ring)}) {
    const int row = std::clamp(static_cast<int>(k), 0, grid_.ringCount() - 1);
    for (const double p : {std::floor(psi), std::ceil(psi)}) {
      // Seen from the gripper the base stands where it does, whatever the node.
      const Eigen::Vector2d position =
          Eigen::Rotation2Dd(-p * grid_.nodeStep() - s.view.heading) * s.pose.translation.head<2>();
      for (const double r : {std::floor(roll), std::ceil(roll)}) {
        const int turned = (static_cast<int>(r) % grid_.rolls + grid_.rolls) % grid_.rolls;
        mark(s, position, row, turned, wrapPsi(static_cast<int>(p)), marks);
      }
    }
  }
}

void ReachSampler::mark(const Sample& s, const Eigen::Vector2d& position, int ring, int roll,
                        int psi, ReachMarks& marks) const {
  const double voxel = marks.voxel();
  const Eigen::Vector2d u = -(Eigen::Rotation2Dd(psi * grid_.nodeStep()) * position);
  const int x = static_cast<int>(std::lround(u[0] / voxel)) - 2 * grid_.x0;
  const int y = static_cast<int>(std::lround(u[1] / voxel)) - 2 * grid_.y0;
  if (x < 0 || y < 0 || x >= marks.nx() || y >= marks.ny()) return;
  const bool cell = ring % grid_.fine == 0 && psi % grid_.fine == 0;
  for (const Range& heights : s.clear) {
    const double z = s.pose.translation[2];
    const int low = static_cast<int>(std::lround((z + heights.low) / voxel)) - 2 * grid_.z0;
    const int high = static_cast<int>(std::lround((z + heights.high) / voxel)) - 2 * grid_.z0;
    if (low < 0 || high >= marks.nz()) continue;
    marks.mark(ring, roll, psi, y, x, low, high);
    if (!cell) continue;
    for (int k = (low + 1) / 2; k <= high / 2; ++k) {
      marks.raise(grid_.cell(k, ring / grid_.fine, psi / grid_.fine, y / 2, x / 2), s.quality);
    }
  }
}

/// Neither torso, pan nor the last roll change the manipulability.
std::uint8_t ReachSampler::quality(const Sample& s) const {
  if (!(best_ > 0)) return 1;
  const double share = manipulability(s.jacobian) / best_;
  return static_cast<std::uint8_t>(1 + std::clamp(std::floor(255 * share), 0.0, 254.0));
}

}  // namespace graft::lfd
