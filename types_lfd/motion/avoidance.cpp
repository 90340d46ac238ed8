// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/motion/avoidance.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"

namespace graft::lfd {

namespace {

using Vec2 = Vec<double, 2>;

/// A gradient shorter than this gives no direction (far field, ridge of the
/// distance between two obstacles).
constexpr double kShortestGradient = 1e-6;
constexpr int kHalvings = 12;
/// Change of the slow-down factor per period (authors' robot: 0.1 at 50 Hz).
constexpr double kSlowDownStep = 0.1;
/// After the reference has ended the base gets this long to arrive, s.
constexpr double kLongestWait = 10;

void validate(const AvoidanceOptions& o) {
  const bool good = o.safety >= 0 && o.reference_distance > 0 && o.reactivity > 0 &&
                    o.base_speed > 0 && o.largest_lag > 0 && o.slowest >= 1 &&
                    std::isfinite(o.safety + o.reference_distance + o.reactivity + o.base_speed +
                                  o.largest_lag + o.slowest);
  if (!good) throw Error(ExitCode::kUsage, "options of obstacle avoidance are out of range");
}

/// Moves by `step`, or by the longest half, quarter, ... of it that keeps the
/// safety distance (or, from too near, does not come nearer).
Vec2 safeStep(const ClearanceField& field, const Vec2& position, Vec2 step, double safety) {
  const double needed = std::min(safety, field.clearance(position[0], position[1]));
  for (int i = 0; i < kHalvings; ++i) {
    Vec2 next = position + step;
    if (field.clearance(next[0], next[1]) >= needed) return next;
    step *= 0.5;
  }
  return position;
}

/// A motion that can be asked for anything between its samples. Counts in
/// samples, not seconds, so that whole steps meet whole samples.
class Reference {
 public:
  explicit Reference(const std::vector<MotionPoint>& motion) : motion_(motion) {}

  bool atEnd() const { return at_ >= static_cast<double>(motion_.size() - 1); }

  /// Moves on by a share of a sample in (0, 1], but not past the end of a
  /// segment: those are kept.
  void advance(double share) {
    const auto before = static_cast<std::size_t>(at_);
    at_ = std::min(at_ + share, static_cast<double>(motion_.size() - 1));
    const auto after = static_cast<std::size_t>(at_);
    if (after == before || at_ == static_cast<double>(after)) return;
    const MotionPoint& a = motion_[after];
    const MotionPoint& b = motion_[after + 1];
    if (a.segment != b.segment || a.action != b.action) at_ = static_cast<double>(after);
  }

  MotionPoint point() const {
    const auto left = static_cast<std::size_t>(at_);
    const double share = at_ - static_cast<double>(left);
    if (share == 0) return motion_[left];
    const MotionPoint& a = motion_[left];
    MotionPoint result = motion_[left + 1];
    const JointPose pose =
        interpolate(JointPose{a.gripper, a.base}, {result.gripper, result.base}, share);
    result.gripper = pose.gripper;
    result.base = pose.base;
    return result;
  }

 private:
  const std::vector<MotionPoint>& motion_;
  double at_ = 0;
};

}  // namespace

Vec2 ClearanceField::gradient(double x, double y) const {
  const double h = differenceStep();
  return Vec2(clearance(x + h, y) - clearance(x - h, y),
              clearance(x, y + h) - clearance(x, y - h)) /
         (2 * h);
}

Vec2 modulateVelocity(const ClearanceField& field, const Vec2& position, const Vec2& velocity,
                      const AvoidanceOptions& options) {
  const Vec2 slope = field.gradient(position[0], position[1]);
  const double steepness = slope.norm();
  if (!(steepness > kShortestGradient)) return velocity;
  const Vec2 normal = slope / steepness;
  const double outward = normal.dot(velocity);
  if (outward >= 0 && options.release_when_leaving) return velocity;
  const Vec2 along = velocity - outward * normal;
  const double free = field.clearance(position[0], position[1]) - options.safety;
  const double gamma = 1 + std::max(free, 0.0) / options.reference_distance;
  const double influence = std::pow(gamma, -1 / options.reactivity);
  if (free < 0 && outward < 0) return (1 + influence) * along - outward * normal;
  return (1 - influence) * outward * normal + (1 + influence) * along;
}

std::vector<MotionPoint> avoidObstacles(const std::vector<MotionPoint>& motion,
                                        const ClearanceField& field,
                                        const AvoidanceOptions& options, AvoidanceReport* report) {
  validate(options);
  AvoidanceReport local;
  AvoidanceReport& notes = report != nullptr ? *report : local;
  notes = AvoidanceReport();
  if (motion.empty()) return {};
  std::vector<MotionPoint> result = {motion.front()};
  const auto account = [&](const MotionPoint& point, const Pose2& wanted) {
    const double clearance = field.clearance(point.base.x, point.base.y);
    notes.least_clearance =
        result.size() == 1 ? clearance : std::min(notes.least_clearance, clearance);
    notes.inside += clearance < options.safety ? 1 : 0;
    notes.final_deviation = std::hypot(point.base.x - wanted.x, point.base.y - wanted.y);
    notes.largest_deviation = std::max(notes.largest_deviation, notes.final_deviation);
  };
  account(result.front(), motion.front().base);
  if (motion.size() < 2) return result;

  const double period = motion[1].time - motion[0].time;
  if (!(period > 0)) throw Error(ExitCode::kUsage, "the times of a motion must rise");
  Reference reference(motion);
  double slow_down = 1;
  double waited = 0;
  while (!reference.atEnd() ||
         (notes.final_deviation > options.largest_lag && waited < kLongestWait)) {
    waited += reference.atEnd() ? period : 0;
    reference.advance(1 / slow_down);
    MotionPoint point = reference.point();
    const Pose2 wanted = point.base;
    const Vec2 position(result.back().base.x, result.back().base.y);
    Vec2 velocity = (Vec2(wanted.x, wanted.y) - position) / period;
    const double speed = std::min(velocity.norm(), options.base_speed);
    if (velocity.norm() > speed) velocity *= speed / velocity.norm();
    Vec2 modulated = modulateVelocity(field, position, velocity, options);
    // Faster along an obstacle than asked for would overshoot the reference.
    if (modulated.norm() > speed) modulated *= speed / modulated.norm();
    const Vec2 next = safeStep(field, position, modulated * period, options.safety);
    const bool stuck =
        speed > 0.1 * options.base_speed && (next - position).norm() < 0.01 * speed * period;
    notes.stalled += stuck ? 1 : 0;
    point.base.x = next[0];
    point.base.y = next[1];
    point.time = motion.front().time + static_cast<double>(result.size()) * period;
    result.push_back(point);
    account(point, wanted);
    // Waiting helps a base that is behind, not one that is stuck.
    if (stuck && reference.atEnd()) break;
    slow_down = std::clamp(
        slow_down + (notes.final_deviation > options.largest_lag ? kSlowDownStep : -kSlowDownStep),
        1.0, options.slowest);
  }
  return result;
}

}  // namespace graft::lfd
