// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/performance.hpp"

#include <algorithm>
#include <cmath>

#include "types_lfd/teach/random.hpp"
#include "types_lfd/teach/smooth_path.hpp"

namespace graft::lfd {

namespace {

constexpr double kTwoPi = 6.28318530717958647692;
constexpr double kFirstStamp = 1.6e9;            // s; an ordinary Unix time
constexpr double kBetweenDemonstrations = 1000;  // s

double roundedTo(double value, double per_unit) { return std::round(value * per_unit) / per_unit; }

/// When what happens, in seconds from the start of the demonstration.
struct Schedule {
  double reach = 0;  ///< the hand leaves its start pose
  double grasp = 0;
  double part_start = 0;  ///< the moving part begins to move
  double part_time = 0;
  double press_start = 0;  ///< the lever goes down (doors)
  double press_time = 0;
  double lift_start = 0;  ///< the lever comes up again
  double release = 0;
  double end = 0;

  double opening(double t) const { return minimumJerkFraction((t - part_start) / part_time); }
  double press(double t) const {
    if (press_time == 0) return 0;
    return minimumJerkFraction((t - press_start) / press_time) -
           minimumJerkFraction((t - lift_start) / press_time);
  }
};

Schedule drawSchedule(const Scenario& s, Random& random) {
  Schedule t;
  t.reach = random.uniform(0.2, 0.5);
  t.grasp = t.reach + random.uniform(1.8, 2.6);
  const double manipulation = random.uniform(s.manipulation_low, s.manipulation_high);
  t.release = t.grasp + manipulation;
  const double settle = random.uniform(0.10, 0.20);
  if (s.furniture.kind == Furniture::Kind::kDoor) {
    t.press_time = random.uniform(0.9, 1.1);
    t.press_start = t.grasp + settle;
    t.part_start = t.press_start + 0.85 * t.press_time;
    t.lift_start = t.release - settle - t.press_time;
    // The lever comes up while the leaf runs out.
    t.part_time = t.lift_start + 0.3 * t.press_time - t.part_start;
  } else {
    t.part_start = t.grasp + settle;
    t.part_time = manipulation - 2 * settle;
  }
  t.end = t.release + random.uniform(0.9, 1.4);
  return t;
}

/// A slow, bounded, smooth deviation that is zero at the grasp.
class Slip {
 public:
  Slip(double bound_t, double bound_r, Random& random) {
    for (int k = 0; k < 6; ++k) {
      amplitude_[k] = 0.5 * (k < 3 ? bound_t : bound_r) * random.uniform(0.4, 1);
      frequency_[k] = random.uniform(0.06, 0.16);
      phase_[k] = random.uniform(0, kTwoPi);
    }
  }
  /// `since` s after the grasp; each entry within its bound.
  Pose at(double since) const {
    Vec<double, 6> d;
    for (int k = 0; k < 6; ++k) {
      d[k] = amplitude_[k] *
             (std::sin(kTwoPi * frequency_[k] * since + phase_[k]) - std::sin(phase_[k]));
    }
    return Pose().plus(d);
  }

 private:
  double amplitude_[6];
  double frequency_[6];
  double phase_[6];
};

Eigen::Vector3d flat(double x, double y, double heading) { return {x, y, heading}; }

/// Where the torso walks, in the furniture's frame.
PlanarPath torsoPath(const Scenario& s, const Schedule& t, const Eigen::Vector3d& hand_start,
                     Random& random) {
  const auto heading = [&random] { return 0.04 * random.normal(); };
  const double side = random.uniform(0.12, 0.24);  // right-handed: the hand is to the right
  const double behind = random.uniform(0.48, 0.56);
  PlanarPath path;
  const Furniture& f = s.furniture;
  if (s.walks_through) {
    const double middle = 0.5 * (s.opening_low + s.opening_high) + 0.02 * random.normal();
    path.add(0, flat(hand_start.x() - behind, 0.5 * (hand_start.y() - side + middle), heading()));
    path.add(t.grasp, flat(-behind - f.standoff, middle, heading()));
    path.add(t.part_start + 0.2 * t.part_time, flat(-0.40, middle, heading()));
    path.add(t.part_start + 0.6 * t.part_time, flat(-0.02, middle + 0.03, heading()));
    path.add(t.part_start + t.part_time, flat(0.42, middle + 0.10, heading() - 0.06));
    path.add(t.end, flat(random.uniform(0.82, 0.92), middle + 0.24, heading() - 0.12));
    return path;
  }
  path.add(0, flat(hand_start.x() - behind, hand_start.y() + side, heading()));
  const Eigen::Vector3d closed = f.handle(0, 0).translation;
  const double yaw = heading();
  for (const double fraction : {0.0, 0.35, 0.65, 1.0}) {
    const double time = t.part_start + fraction * t.part_time;
    const Eigen::Vector3d moved = f.handle(t.opening(time), 0).translation - closed;
    path.add(fraction == 0 ? t.grasp : time,
             flat(closed.x() - behind + 0.75 * moved.x(), closed.y() + side + 0.6 * moved.y(),
                  yaw + 0.1 * fraction * moved.y()));
  }
  const Eigen::Vector3d moved = f.handle(1, 0).translation - closed;
  path.add(t.end, flat(closed.x() - behind + 0.75 * moved.x() - random.uniform(0.08, 0.18),
                       closed.y() + side + 0.8 * moved.y(), yaw));
  return path;
}

/// One demonstration in the furniture's frame.
class Actor {
 public:
  Actor(const Scenario& s, Random& random)
      : s_(s),
        times(drawSchedule(s, random)),
        slip_(s.slip_t, s.slip_r, random),
        object_T_hand_(drawHold(random)) {
    const Pose closed = s.furniture.handle(0, 0);
    const double distance = random.uniform(0.75, 1.15);
    const double bearing = random.uniform(-0.35, 0.35);
    const double drop = random.uniform(0.08, 0.22);
    const double level = std::sqrt(distance * distance - drop * drop);
    start_ = closed * object_T_hand_;
    start_.translation = closed.translation + Eigen::Vector3d(-level * std::cos(bearing),
                                                              level * std::sin(bearing), -drop);
    start_.rotation = (start_.rotation * expSO3<double>(random.normal3(0.15))).normalized();
    torso_ = torsoPath(s, times, start_.translation, random);
    torso_height_ = random.uniform(0.98, 1.04);
    torso_pitch_ = random.uniform(0.04, 0.09);
    retreat_turn_ = random.normal3(0.12);
    retreat_shift_ = random.normal3(0.03);
  }

  Pose object(double t) const { return s_.furniture.handle(times.opening(t), times.press(t)); }

  Pose torso(double t) const {
    const Eigen::Vector3d at = torso_.at(t);
    return Pose(Eigen::Vector3d(at.x(), at.y(), torso_height_),
                expSO3<double>(Eigen::Vector3d(0, 0, at.z())) *
                    expSO3<double>(Eigen::Vector3d(0, torso_pitch_, 0)));
  }

  Pose hand(double t) const {
    if (t < times.grasp) return approach(t);
    if (t <= times.release) return holding(t);
    return retreat(t);
  }

 private:
  Pose drawHold(Random& random) const {
    Vec<double, 6> d;
    d.head<3>() = random.normal3(s_.grasp_spread_t);
    d.tail<3>() = random.normal3(s_.grasp_spread_r);
    return s_.object_T_hand.plus(d);
  }

  Pose holding(double t) const { return object(t) * object_T_hand_ * slip_.at(t - times.grasp); }

  /// Comes in along the fingers.
  Pose approach(double t) const {
    const Pose goal = holding(times.grasp);
    const double s = minimumJerkFraction((t - times.reach) / (times.grasp - times.reach));
    const Eigen::Vector3d before = goal * Eigen::Vector3d(-0.22, 0, 0);
    const Eigen::Vector3d early =
        start_.translation + 0.3 * (goal.translation - start_.translation);
    return Pose(bezier(start_.translation, early, before, goal.translation, s),
                interpolate(start_, goal, s).rotation);
  }

  /// Leaves against the fingers; a walker takes the hand along.
  Pose retreat(double t) const {
    const Pose from = holding(times.release);
    const double s = minimumJerkFraction((t - times.release) / (times.end - times.release));
    const Eigen::Vector3d away = from * Eigen::Vector3d(-0.16, 0, 0);
    Eigen::Vector3d last = from * Eigen::Vector3d(-0.25, 0, 0);
    last.z() -= 0.05;
    if (s_.walks_through) last = torso(times.end) * Eigen::Vector3d(0.30, -0.28, -0.08);
    last += retreat_shift_;
    return Pose(bezier(from.translation, away, 0.5 * (away + last), last, s),
                (from.rotation * expSO3<double>(s * retreat_turn_)).normalized());
  }

  const Scenario& s_;

 public:
  const Schedule times;

 private:
  Slip slip_;
  Pose object_T_hand_;
  Pose start_;
  PlanarPath torso_;
  double torso_height_ = 0;
  double torso_pitch_ = 0;
  Eigen::Vector3d retreat_turn_;
  Eigen::Vector3d retreat_shift_;
};

/// Camera frames: even spacing with a jitter of a twentieth.
std::vector<double> drawFrames(int count, double end, Random& random) {
  std::vector<double> frames;
  const double step = end / (count - 1);
  for (int i = 0; i < count; ++i) {
    const bool inner = i > 0 && i + 1 < count;
    frames.push_back(step * (i + (inner ? random.uniform(-0.05, 0.05) : 0)));
  }
  return frames;
}

/// Where the furniture stands in this demonstration.
Pose placeFurniture(const Scenario& s, const TeachOptions& options, Random& random) {
  if (!options.move_object) return s.world_T_scene;
  const double x = random.uniform(-0.8, 0.4);
  const double y = random.uniform(-0.6, 0.6);
  const Pose scene_T_furniture(Eigen::Vector3d(x, y, 0),
                               expSO3<double>(Eigen::Vector3d(0, 0, random.uniform(-0.5, 0.5))));
  return s.world_T_scene * scene_T_furniture;
}

}  // namespace

Performance perform(const Scenario& scenario, int index, std::uint64_t seed,
                    const TeachOptions& options) {
  const auto number = static_cast<std::uint64_t>(index);
  Random random(seed, 10, number);
  const Actor actor(scenario, random);
  Random place(seed, 11, number);
  Performance result;
  result.world_T_furniture = placeFurniture(scenario, options, place);
  Random clock(seed, 12, number);
  const double first = kFirstStamp + kBetweenDemonstrations * index + clock.uniform(0, 1);
  for (const double t : drawFrames(scenario.frames, actor.times.end, clock)) {
    const double stamp = roundedTo(first + t, 1e6);
    for (Trajectory* track : {&result.hand, &result.object, &result.torso}) {
      track->times.push_back(stamp);
    }
    result.hand.poses.push_back(result.world_T_furniture * actor.hand(t));
    result.object.poses.push_back(result.world_T_furniture * actor.object(t));
    result.torso.poses.push_back(result.world_T_furniture * actor.torso(t));
    if (t < actor.times.grasp || t > actor.times.release) continue;
    if (result.grasp_time == 0) result.grasp_time = stamp;
    result.release_time = stamp;
  }
  return result;
}

}  // namespace graft::lfd
