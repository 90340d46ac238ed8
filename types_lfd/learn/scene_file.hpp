// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "types_lfd/build/graph_builder.hpp"
#include "types_lfd/build/scene.hpp"

namespace graft::lfd {

/// Copies what a result refers to (robot, grasps, reachability map, occupancy
/// map) into `directory`/resources, with resources/scene.json that names it, so
/// that the folder stands alone. Returns the names relative to `directory`.
ResourceFiles writeSceneFiles(const Task& task, const TaskScene& scene,
                              const std::string& directory);

/// The robot, grasps and map of a result folder as a task without
/// demonstrations; paths lead into the folder. Throws Error(kInput) where the
/// folder is no result.
Task readSceneFiles(const std::string& directory);

/// Loads the scene of such a task; the reachability map is the folder's own.
TaskScene loadResultScene(const Task& task, Diagnostics& diagnostics);

}  // namespace graft::lfd
