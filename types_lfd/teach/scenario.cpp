// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/scenario.hpp"

#include <cmath>

#include "types_lfd/teach/random.hpp"

namespace graft::lfd {

namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

/// Sigmas as they are written to task.xml: what is stated is what is used.
double stated(double sigma) { return std::round(sigma * 1e4) / 1e4; }

TrackerModel trackerModel(double sigma_t, double sigma_r, int skip_every, Random& random) {
  TrackerModel model;
  model.sigma_t = stated(sigma_t * random.uniform(0.9, 1.1));
  model.sigma_r = stated(sigma_r * random.uniform(0.9, 1.1));
  model.skip_every = skip_every;
  model.miss = 0.05;
  model.bursts = 2;
  return model;
}

/// Sigmas of the hand's marker; the object's is taken to be seen twice as well,
/// the torso's is large and far away.
void drawTrackers(Scenario& s, double hand_t, double hand_r, double object_r, Random& random) {
  s.hand_tracker = trackerModel(hand_t, hand_r, 0, random);
  s.object_tracker = trackerModel(0.5 * hand_t, object_r, 7, random);
  s.torso_tracker = trackerModel(0.012, 2.5 * kDegree, 3, random);
}

/// A hand on a bar: fingers along x of the object, closing axis across the bar,
/// palm a little in front of it, held slightly askew.
void drawHold(Scenario& s, bool bar_is_vertical, Random& random) {
  const double roll = bar_is_vertical ? 0 : 90 * kDegree;
  s.bar = bar_is_vertical ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
  // One after the other: compilers evaluate arguments in different orders.
  const double yaw = random.uniform(-7, 7) * kDegree;
  const double pitch = random.uniform(2, 9) * kDegree;
  const Eigen::Vector3d askew(random.uniform(-4, 4) * kDegree, pitch, yaw);
  const double along = random.uniform(-0.012, 0.012);
  const double above = random.uniform(-0.004, 0.008);
  const Eigen::Vector3d palm(random.uniform(-0.045, -0.028), 0, above);
  s.object_T_hand = Pose(palm + along * s.bar,
                         expSO3<double>(Eigen::Vector3d(roll, 0, 0)) * expSO3<double>(askew));
}

void drawRoomDoor(Scenario& s, Random& random) {
  s.demonstrations = 10;
  s.frames = 160;
  s.has_torso = true;
  s.walks_through = true;
  s.furniture.kind = Furniture::Kind::kDoor;
  s.furniture.standoff = random.uniform(0.05, 0.065);
  s.furniture.radius = random.uniform(0.68, 0.76);
  s.furniture.height = random.uniform(0.98, 1.06);
  s.furniture.travel = -random.uniform(70, 80) * kDegree;
  s.furniture.lever_arm = random.uniform(0.065, 0.08);
  s.furniture.lever_press = random.uniform(32, 40) * kDegree;
  s.manipulation_low = 6.2;
  s.manipulation_high = 7.4;
  drawHold(s, false, random);
  s.grasp_spread_t = 0.0015;
  s.grasp_spread_r = 2.0 * kDegree;
  s.slip_t = 0.003;
  s.slip_r = 3.5 * kDegree;
  drawTrackers(s, 0.0088, 0.18, 0.035, random);
  s.opening_low = -0.05;
  s.opening_high = s.furniture.radius + random.uniform(0.20, 0.26);
}

void drawSwivelDoor(Scenario& s, Random& random) {
  s.demonstrations = 4;
  s.frames = 111;
  s.has_torso = true;
  s.furniture.kind = Furniture::Kind::kSwivel;
  s.furniture.standoff = random.uniform(0.025, 0.035);
  s.furniture.radius = random.uniform(0.30, 0.38);
  s.furniture.height = random.uniform(0.82, 0.95);
  s.furniture.travel = random.uniform(76, 88) * kDegree;
  s.manipulation_low = 4.4;
  s.manipulation_high = 5.7;
  drawHold(s, true, random);
  s.grasp_spread_t = 0.0015;
  s.grasp_spread_r = 1.5 * kDegree;
  s.slip_t = 0.003;
  s.slip_r = 2.5 * kDegree;
  drawTrackers(s, 0.0120, 0.17, 0.035, random);
}

void drawDrawer(Scenario& s, Random& random) {
  s.demonstrations = 6;
  s.frames = 119;
  s.furniture.kind = Furniture::Kind::kSlider;
  s.furniture.direction = -Eigen::Vector3d::UnitX();
  s.furniture.standoff = random.uniform(0.025, 0.035);
  s.furniture.height = random.uniform(0.64, 0.76);
  s.furniture.travel = random.uniform(0.26, 0.34);
  s.manipulation_low = 4.7;
  s.manipulation_high = 6.2;
  drawHold(s, false, random);
  s.object_T_hand.translation.x() -= 0.025;  // held by the finger tips
  s.grasp_spread_t = 0.002;
  s.grasp_spread_r = 0.15 * kDegree;
  s.slip_t = 0.004;
  s.slip_r = 0.2 * kDegree;
  drawTrackers(s, 0.0135, 0.0078, 0.0039, random);
}

void drawSlidingDoor(Scenario& s, Random& random) {
  s.demonstrations = 10;
  s.frames = 154;
  s.furniture.kind = Furniture::Kind::kSlider;
  s.furniture.direction = random.chance(0.5) ? Eigen::Vector3d(Eigen::Vector3d::UnitY())
                                             : Eigen::Vector3d(-Eigen::Vector3d::UnitY());
  s.furniture.standoff = random.uniform(0.025, 0.035);
  s.furniture.height = random.uniform(0.78, 0.92);
  s.furniture.travel = random.uniform(0.36, 0.46);
  s.manipulation_low = 6.6;
  s.manipulation_high = 8.2;
  drawHold(s, true, random);
  s.grasp_spread_t = 0.0004;
  s.grasp_spread_r = 0.3 * kDegree;
  s.slip_t = 0.0008;
  s.slip_r = 0.5 * kDegree;
  drawTrackers(s, 0.0026, 0.030, 0.015, random);
}

/// Walls, the furniture itself, and two things that stand about.
void drawRooms(Scenario& s, const TeachOptions& options, Random& random) {
  constexpr double kWall = 0.10;
  const double left = random.uniform(2.6, 3.4);  // walls across y
  const double right = -random.uniform(2.6, 3.4);
  const double back = -random.uniform(3.2, 3.8);  // walls across x
  const double front = s.walks_through ? random.uniform(3.0, 3.8) : random.uniform(1.6, 2.4);
  s.free.push_back({back, right, front, left});
  s.occupied.push_back({back - kWall, right - kWall, front + kWall, right});
  s.occupied.push_back({back - kWall, left, front + kWall, left + kWall});
  s.occupied.push_back({back - kWall, right, back, left});
  s.occupied.push_back({front, right, front + kWall, left});
  // Clutter beside the person's way.
  const double x = random.uniform(-2.4, -1.6);
  s.occupied.push_back({x, left - random.uniform(0.3, 0.6), x + random.uniform(0.4, 0.9), left});
  s.occupied.push_back(
      {x - 0.3, right, x + random.uniform(0.2, 0.8), right + random.uniform(0.3, 0.6)});
  const Furniture& f = s.furniture;
  if (s.walks_through) {
    s.occupied.push_back({0, right, kWall, s.opening_low});
    s.occupied.push_back({0, s.opening_high, kWall, left});
    // A cupboard behind the door, which the opened leaf does not reach.
    const double cupboard = random.uniform(0.7, 1.0);
    s.occupied.push_back({cupboard, -random.uniform(0.55, 0.65), cupboard + 1.2, -0.25});
    return;
  }
  if (options.move_object) return;
  const double depth = random.uniform(0.42, 0.55);
  if (f.kind == Furniture::Kind::kSwivel) {
    s.occupied.push_back({0, -0.05, depth, f.radius + 0.07});
  } else {
    const double reach = f.direction.y() * f.travel;
    s.occupied.push_back({0, std::min(0.0, reach) - 0.28, depth, std::max(0.0, reach) + 0.28});
  }
}

void checkOptions(const TeachOptions& options, const Scenario& s) {
  if (options.demonstrations < 0 || options.demonstrations > 99) {
    throw Error(ExitCode::kUsage, "the number of demonstrations must be from 1 to 99");
  }
  if (!(options.noise_scale >= 0 && options.noise_scale <= 100)) {
    throw Error(ExitCode::kUsage, "the noise scale must be from 0 to 100");
  }
  if (options.move_object && s.walks_through) {
    throw Error(ExitCode::kUsage, s.name + " is part of the building and cannot be moved");
  }
}

void applyNoise(const TeachOptions& options, TrackerModel& tracker) {
  tracker.sigma_t *= options.noise_scale;
  tracker.sigma_r *= options.noise_scale;
  if (!options.occlusions) {
    tracker.bursts = 0;
    tracker.skip_every = 0;
  }
}

}  // namespace

const std::vector<std::string>& teachableTasks() {
  static const std::vector<std::string> names = {"room_door", "swivel_door", "drawer",
                                                 "sliding_door"};
  return names;
}

Scenario drawScenario(const std::string& task_name, std::uint64_t seed,
                      const TeachOptions& options) {
  Scenario s;
  s.name = task_name;
  Random random(seed, 1, 0);
  if (task_name == "room_door") {
    drawRoomDoor(s, random);
  } else if (task_name == "swivel_door") {
    drawSwivelDoor(s, random);
  } else if (task_name == "drawer") {
    drawDrawer(s, random);
  } else if (task_name == "sliding_door") {
    drawSlidingDoor(s, random);
  } else {
    std::string known;
    for (const std::string& name : teachableTasks()) known += (known.empty() ? "" : ", ") + name;
    throw Error(ExitCode::kUsage, "unknown task " + quoted(task_name) + "; known are " + known);
  }
  checkOptions(options, s);
  if (options.demonstrations > 0) s.demonstrations = options.demonstrations;
  applyNoise(options, s.hand_tracker);
  applyNoise(options, s.object_tracker);
  applyNoise(options, s.torso_tracker);
  Random place(seed, 2, 0);
  const double turn = place.uniform(-180, 180) * kDegree;
  const double y = place.uniform(-1, 1);
  s.world_T_scene = Pose(Eigen::Vector3d(place.uniform(-1, 1), y, 0),
                         expSO3<double>(Eigen::Vector3d(0, 0, turn)));
  Random rooms(seed, 3, 0);
  drawRooms(s, options, rooms);
  return s;
}

}  // namespace graft::lfd
