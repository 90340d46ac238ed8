// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/scene.hpp"

#include "types_lfd/reach/reach_cache.hpp"
#include "types_lfd/robot/self_collision.hpp"
#include "types_lfd/robot/srdf.hpp"
#include "types_lfd/robot/urdf.hpp"

namespace graft::lfd {

Chain loadChain(const RobotSpec& robot, Diagnostics& diagnostics) {
  const UrdfModel model = readUrdf(robot.urdf, diagnostics);
  diagnostics.throwIfErrors();
  Chain chain(model, robot.base_link, robot.tip_link, robot.tip_T_gripper);
  if (!robot.srdf.empty()) {
    const Srdf srdf = readSrdf(robot.srdf, model, diagnostics);
    chain.setSelfCollision(std::make_shared<SelfCollision>(model, srdf, chain, diagnostics));
  }
  return chain;
}

TaskScene loadScene(const Task& task, Diagnostics& diagnostics, const ReachProgress& progress) {
  TaskScene scene;
  scene.grasps =
      std::make_unique<GraspSet>(GraspSet::read(task.grasps, task.min_quality, diagnostics));
  if (!task.map.empty()) {
    scene.map = std::make_unique<OccupancyMap>(OccupancyMap::read(task.map, diagnostics));
  }
  diagnostics.throwIfErrors();
  if (scene.map != nullptr) {
    scene.footprint = std::make_unique<FootprintChecker>(*scene.map, task.robot.footprint);
  }
  scene.chain = std::make_unique<Chain>(loadChain(task.robot, diagnostics));
  scene.reach = std::make_unique<ReachMap>(
      cachedReachMap(*scene.chain, ReachOptions(), progress, &scene.reach_file, diagnostics));
  return scene;
}

}  // namespace graft::lfd
