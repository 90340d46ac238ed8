// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/learn/scene_file.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/file.hpp"

namespace graft::lfd {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSceneFile = "/resources/scene.json";

}  // namespace

ResourceFiles writeSceneFiles(const Task& task, const TaskScene& scene,
                              const std::string& directory) {
  const std::string folder = directory + "/resources";
  std::filesystem::create_directories(folder);
  ResourceFiles files;
  files.grasps = "resources/grasps.csv";
  writeFileAtomically(folder + "/grasps.csv", readFile(task.grasps));
  files.reach_map = "resources/reach.map";
  scene.reach->save(folder + "/reach.map");
  if (scene.map != nullptr) {
    files.map = "resources/map.yaml";
    writeFileAtomically(folder + "/map.pgm", scene.map->formatPgm());
    writeFileAtomically(folder + "/map.yaml", scene.map->formatYaml("map.pgm"));
  }
  writeFileAtomically(folder + "/robot.urdf", readFile(task.robot.urdf));
  const bool has_srdf = !task.robot.srdf.empty();
  if (has_srdf) writeFileAtomically(folder + "/robot.srdf", readFile(task.robot.srdf));
  std::vector<double> tool(7);
  task.robot.tip_T_gripper.toArray(tool.data());
  Json footprint = Json::array();
  for (const Eigen::Vector2d& corner : task.robot.footprint) {
    footprint.push_back({corner.x(), corner.y()});
  }
  const Json json = {{"task", task.name},
                     {"robot",
                      {{"urdf", "robot.urdf"},
                       {"srdf", has_srdf ? Json("robot.srdf") : Json(nullptr)},
                       {"base_link", task.robot.base_link},
                       {"tip_link", task.robot.tip_link},
                       {"tool", tool},
                       {"footprint", footprint}}},
                     {"grasps", {{"file", "grasps.csv"}, {"min_quality", task.min_quality}}},
                     {"reach_map", "reach.map"},
                     {"map", scene.map != nullptr ? Json("map.yaml") : Json(nullptr)}};
  writeFileAtomically(directory + kSceneFile, json.dump(2) + "\n");
  return files;
}

Task readSceneFiles(const std::string& directory) {
  const std::string path = directory + kSceneFile;
  const std::string folder = directory + "/resources/";
  try {
    const Json json = Json::parse(readFile(path));
    Task task;
    task.path = path;
    task.directory = directory;
    task.name = json.at("task").get<std::string>();
    const Json& robot = json.at("robot");
    task.robot.urdf = folder + robot.at("urdf").get<std::string>();
    if (robot.contains("srdf") && !robot.at("srdf").is_null()) {
      task.robot.srdf = folder + robot.at("srdf").get<std::string>();
    }
    task.robot.base_link = robot.at("base_link").get<std::string>();
    task.robot.tip_link = robot.at("tip_link").get<std::string>();
    const auto tool = robot.at("tool").get<std::vector<double>>();
    if (tool.size() != 7) throw Error(ExitCode::kInput, {path, 0, 0}, "tool needs 7 numbers");
    task.robot.tip_T_gripper = Pose::fromArray(tool.data());
    for (const Json& corner : robot.at("footprint")) {
      task.robot.footprint.emplace_back(corner.at(0).get<double>(), corner.at(1).get<double>());
    }
    task.grasps = folder + json.at("grasps").at("file").get<std::string>();
    task.min_quality = json.at("grasps").at("min_quality").get<double>();
    if (!json.at("map").is_null()) task.map = folder + json.at("map").get<std::string>();
    return task;
  } catch (const nlohmann::json::exception& e) {
    throw Error(ExitCode::kInput, {path, 0, 0}, e.what());
  }
}

TaskScene loadResultScene(const Task& task, Diagnostics& diagnostics) {
  TaskScene scene;
  scene.grasps =
      std::make_unique<GraspSet>(GraspSet::read(task.grasps, task.min_quality, diagnostics));
  if (!task.map.empty()) {
    scene.map = std::make_unique<OccupancyMap>(OccupancyMap::read(task.map, diagnostics));
    diagnostics.throwIfErrors();
    scene.footprint = std::make_unique<FootprintChecker>(*scene.map, task.robot.footprint);
  }
  diagnostics.throwIfErrors();
  scene.chain = std::make_unique<Chain>(loadChain(task.robot, diagnostics));
  scene.reach_file = task.directory + "/resources/reach.map";
  scene.reach = std::make_unique<ReachMap>(ReachMap::load(scene.reach_file));
  return scene;
}

}  // namespace graft::lfd
