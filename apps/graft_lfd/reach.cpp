// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_map.hpp"

#include <functional>
#include <memory>

#include "apps/common/progress.hpp"
#include "apps/graft_lfd/commands.hpp"
#include "apps/graft_lfd/session.hpp"
#include "core/base/text.hpp"
#include "types_lfd/build/scene.hpp"

namespace graft::lfd {

namespace {

struct Options {
  RobotSpec robot;
  std::string tool;
  std::string map;
  std::string out;
  std::string gripper;
  std::string base;
  ReachOptions reach;
  std::function<ExitCode()> action;  ///< of the subcommand that was chosen
};

void describeMap(const ReachMap& map) {
  std::printf(
      "robot: %s, %s to %s\nreachable cells: %llu of %zu\nsamples: %llu, seed %llu\n"
      "coverage: %.4f of the cells were found by half of the samples\n",
      map.robotName().c_str(), map.baseLink().c_str(), map.tipLink().c_str(),
      static_cast<unsigned long long>(map.reachableCells()), map.cells().size(),
      static_cast<unsigned long long>(map.samples()), static_cast<unsigned long long>(map.seed()),
      map.coverage());
}

ExitCode runBuild(const Options& options) {
  Diagnostics diagnostics;
  RobotSpec robot = options.robot;
  if (!options.tool.empty()) robot.tip_T_gripper = parsePose(options.tool, "--tool");
  const Chain chain = loadChain(robot, diagnostics);
  printMessages(diagnostics);
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
  describeMap(ReachMap::load(options.map));
  return ExitCode::kSuccess;
}

}  // namespace

void addReach(Program& program) {
  auto options = std::make_shared<Options>();
  CLI::App* reach = program.add("reach", "Reachability maps: build, query, info",
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
}

}  // namespace graft::lfd
