// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "types_lfd/demo/task.hpp"
#include "types_lfd/grasp/grasp_set.hpp"
#include "types_lfd/map/footprint.hpp"
#include "types_lfd/reach/reach_map.hpp"
#include "types_lfd/robot/chain.hpp"

namespace graft::lfd {

/// The things around a task's demonstrations: robot, its reach, the grasps of
/// the object and the map.
struct TaskScene {
  std::unique_ptr<const Chain> chain;
  std::unique_ptr<const ReachMap> reach;
  std::string reach_file;  ///< where the map lies on disk; empty if it could not be cached
  std::unique_ptr<const GraspSet> grasps;
  std::unique_ptr<const OccupancyMap> map;            ///< null if the task has none
  std::unique_ptr<const FootprintChecker> footprint;  ///< null if the task has no map
};

/// The robot's arm as the task names it; with an SRDF, configurations in which the
/// robot hits itself do not count.
Chain loadChain(const RobotSpec& robot, Diagnostics& diagnostics);

/// Loads all of it; the reachability map comes from the cache or is built, with
/// `progress` told. Defects go to `diagnostics` and are thrown.
TaskScene loadScene(const Task& task, Diagnostics& diagnostics,
                    const ReachProgress& progress = ReachProgress());

}  // namespace graft::lfd
