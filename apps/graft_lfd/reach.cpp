// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_map.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "apps/common/progress.hpp"
#include "apps/graft_lfd/commands.hpp"
#include "apps/graft_lfd/session.hpp"
#include "core/base/text.hpp"
#include "types_lfd/build/scene.hpp"
#include "types_lfd/reach/capability_map.hpp"
#include "types_lfd/reach/reach_verify.hpp"

namespace graft::lfd {

namespace {

struct Options {
  RobotSpec robot;
  std::string tool;
  std::string map;
  std::string out;
  std::string gripper;
  std::string base;
  std::string file;
  int verify = 0;
  ReachOptions reach;
  std::function<ExitCode()> action;  ///< of the subcommand that was chosen
};

void describeMap(const ReachMap& map) {
  std::printf(
      "robot: %s, %s to %s\nresolution: %g m, %g degrees\nreachable nodes: %llu of %zu\n"
      "samples: %llu, seed %llu\n"
      "coverage: %.4f of the voxels were found by half of the samples\n",
      map.robotName().c_str(), map.baseLink().c_str(), map.tipLink().c_str(), map.grid().resolution,
      360.0 / map.grid().turn, static_cast<unsigned long long>(map.reachableCells()),
      map.distances().size(), static_cast<unsigned long long>(map.samples()),
      static_cast<unsigned long long>(map.seed()), map.coverage());
}

Chain chainOf(RobotSpec robot, const std::string& tool) {
  Diagnostics diagnostics;
  if (!tool.empty()) robot.tip_T_gripper = parsePose(tool, "--tool");
  Chain chain = loadChain(robot, diagnostics);
  printMessages(diagnostics);
  return chain;
}

ExitCode runBuild(const Options& options) {
  const Chain chain = chainOf(options.robot, options.tool);
  ProgressBar bar("sampling", 100);
  const ReachMap map = ReachMap::build(
      chain, options.reach, [&](double fraction) { bar.update(int(100 * fraction), ""); });
  map.save(options.out);
  describeMap(map);
  return ExitCode::kSuccess;
}

ExitCode runQuery(const Options& options) {
  const ReachMap map = ReachMap::load(options.map);
  const Pose gripper = parsePose(options.gripper, "--gripper");
  double v[3];
  LineTokens tokens(options.base);
  for (double& value : v) {
    if (parseDouble(tokens.next(), value) != NumberStatus::kOk) {
      throw Error(ExitCode::kUsage, "--base: expected \"x y yaw\"");
    }
  }
  const Pose2 base(v[0], v[1], v[2]);
  const NearestBase nearest = map.nearest(gripper, base, 0.01, 0.05, nullptr);
  std::printf("reachable: %s\nquality: %d\n", map.contains(gripper, base) ? "yes" : "no",
              map.quality(gripper, base));
  if (!nearest.found) {
    std::printf("no base reaches this gripper pose\n");
    return ExitCode::kNoResult;
  }
  std::printf("nearest base: %s %s %s\n", formatDouble(nearest.base.x).c_str(),
              formatDouble(nearest.base.y).c_str(), formatDouble(nearest.base.theta).c_str());
  return ExitCode::kSuccess;
}

ExitCode runInfo(const Options& options) {
  const ReachMap map = ReachMap::load(options.map);
  describeMap(map);
  if (options.verify == 0) return ExitCode::kSuccess;
  if (options.robot.urdf.empty()) {
    throw Error(ExitCode::kUsage, "--verify needs --robot, the URDF the map was built from");
  }
  RobotSpec robot = options.robot;
  robot.base_link = map.baseLink();
  robot.tip_link = map.tipLink();
  const Chain chain = chainOf(robot, options.tool);
  map.requireChain(chain, options.map);
  const ReachRates rates =
      measureRates(map, sampleReachTrial(chain, ikOracle(chain), options.verify, 1));
  std::printf(
      "verified with %d reachable poses and %d unreachable ones within 0.3 m of the border\n"
      "true positive rate: %.4f\ntrue negative rate: %.4f\n",
      options.verify, options.verify, rates.true_positive, rates.true_negative);
  return ExitCode::kSuccess;
}

/// A capability map of other people's tools: what it holds.
ExitCode runImport(const Options& options) {
  const CapabilityMap map = CapabilityMap::load(options.file);
  const double voxel = map.resolution() * map.resolution() * map.resolution();
  double voxels = 0;
  double share = 0;
  int shapes[5] = {};
  for (const Capability& c : map.capabilities()) {
    // Leaves of the octree may be larger than a voxel.
    const double count = std::round(c.edge * c.edge * c.edge / voxel);
    voxels += count;
    share += count * c.share();
    shapes[static_cast<int>(c.shape)] += 1;
  }
  std::printf(
      "capability map of %s: %s to %s\nresolution: %g m\n"
      "non-empty voxels: %zu (octree leaves; %.0f cubes of this size)\n"
      "spheres: %d\ncones: %d\ncylinders along the axis: %d\ncylinders across it: %d\n"
      "directions covered, mean: %.1f %%\n",
      map.groupName().c_str(), map.baseLink().c_str(), map.tipLink().c_str(), map.resolution(),
      map.capabilities().size(), voxels, shapes[1], shapes[2], shapes[3], shapes[4],
      100 * share / std::max(1.0, voxels));
  return ExitCode::kSuccess;
}

}  // namespace

void addReach(Program& program) {
  auto options = std::make_shared<Options>();
  CLI::App* reach = program.add("reach", "Reachability maps: build, query, info, import",
                                [options] { return options->action(); });
  reach->require_subcommand(1);
  const auto command = [&](const char* name, const char* text, ExitCode (*run)(const Options&)) {
    CLI::App* app = reach->add_subcommand(name, text);
    app->callback([options = options.get(), run] {
      options->action = [options, run] { return run(*options); };
    });
    return app;
  };
  CLI::App* build = command("build", "Build the map of a robot's arm", &runBuild);
  build->add_option("ROBOT.urdf", options->robot.urdf, "Robot description")->required();
  build->add_option("--base-link", options->robot.base_link, "Link on the floor")->required();
  build->add_option("--tip-link", options->robot.tip_link, "Link that carries the gripper")
      ->required();
  build->add_option("--tool", options->tool, "tip_link_T_gripper: \"x y z qx qy qz qw\"");
  build->add_option("--srdf", options->robot.srdf,
                    "Semantic description: configurations in self-collision do not count");
  build->add_option("-o,--output", options->out, "Map file to write")->required();
  build->add_option("--resolution", options->reach.resolution, "Cell size, m")
      ->capture_default_str();
  build->add_option("--seed", options->reach.seed, "Seed of the sampling")->capture_default_str();
  build->add_option("--threads", options->reach.threads, "Threads, 0 = all")->capture_default_str();
  CLI::App* query = command("query", "Nearest base that reaches a gripper pose", &runQuery);
  query->add_option("MAP", options->map, "Map file")->required();
  query->add_option("--gripper", options->gripper, "world_T_gripper: \"x y z qx qy qz qw\"")
      ->required();
  query->add_option("--base", options->base, "Base now: \"x y yaw\"")->required();
  CLI::App* info = command("info", "What a map file holds", &runInfo);
  info->add_option("MAP", options->map, "Map file")->required();
  info->add_option("--verify", options->verify,
                   "Also compare with inverse kinematics at this many poses of each kind")
      ->check(CLI::Range(1, 1000000));
  info->add_option("--robot", options->robot.urdf, "URDF of the map's robot, for --verify");
  info->add_option("--srdf", options->robot.srdf,
                   "SRDF of the map's robot, if it was built with one");
  info->add_option("--tool", options->tool, "tip_link_T_gripper: \"x y z qx qy qz qw\"");
  CLI::App* import =
      command("import", "What a capability map (.cpm) of other tools holds", &runImport);
  import->add_option("FILE", options->file, "Capability map")->required();
}

}  // namespace graft::lfd
