// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/se3.hpp"
#include "types_lfd/map/occupancy_map.hpp"
#include "types_lfd/teach/furniture.hpp"
#include "types_lfd/teach/tracker.hpp"

namespace graft::lfd {

/// What a user may ask of the simulated teacher.
struct TeachOptions {
  int demonstrations = 0;    ///< 0 = as many as the task has by default
  double noise_scale = 1;    ///< multiplies every tracker's sigmas; 0 = exact tracks
  bool occlusions = true;    ///< lost samples and bursts of them
  bool move_object = false;  ///< the furniture stands elsewhere in each demonstration
                             ///< (and is then not on the map; not for room_door)
};

/// An axis-parallel box on the floor, in the scene's frame, m.
struct FloorBox {
  double x_low, y_low, x_high, y_high;
};

/// Everything that is drawn once per task and seed. The scene's frame is that
/// of the furniture as it stands on the map; world_T_scene turns it (map and
/// all) to some place in the world.
struct Scenario {
  std::string name;
  int demonstrations = 0;
  int frames = 0;  ///< camera frames per demonstration
  bool has_torso = false;
  bool walks_through = false;
  Furniture furniture;
  Pose world_T_scene;
  double manipulation_low = 0;  ///< s, range of the time spent moving the part
  double manipulation_high = 0;
  Pose object_T_hand;                              ///< mean way of holding
  double grasp_spread_t = 0;                       ///< 1 sigma per axis between demonstrations, m
  double grasp_spread_r = 0;                       ///< rad
  double slip_t = 0;                               ///< bound of the slip in the hand per axis, m
  double slip_r = 0;                               ///< bound per axis of the rotation vector, rad
  Eigen::Vector3d bar = Eigen::Vector3d::UnitZ();  ///< direction of the handle bar, object frame
  TrackerModel hand_tracker;
  TrackerModel object_tracker;
  TrackerModel torso_tracker;
  double opening_low = 0;  ///< the doorway's y range in the scene (walks_through)
  double opening_high = 0;
  std::vector<FloorBox> free;      ///< rooms, drawn first
  std::vector<FloorBox> occupied;  ///< walls and furniture
};

/// Names of the tasks the teacher knows.
const std::vector<std::string>& teachableTasks();

/// Draws the scenario of a task. Ranges stand in scenario.cpp beside each
/// number. Throws Error(kUsage) for an unknown task or options out of range.
Scenario drawScenario(const std::string& task_name, std::uint64_t seed,
                      const TeachOptions& options);

/// The scene as a map, 12 m x 12 m at 5 cm, its grid parallel to the scene.
OccupancyMap drawMap(const Scenario& scenario);

}  // namespace graft::lfd
