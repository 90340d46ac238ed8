// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include "apps/graft_lfd/commands.hpp"
#include "apps/graft_lfd/session.hpp"
#include "core/base/staged_directory.hpp"
#include "core/base/text.hpp"
#include "core/io/trajectory.hpp"
#include "types_lfd/learn/reproduce_result.hpp"

namespace graft::lfd {

namespace {

struct Options {
  std::vector<std::string> directories;
  std::string out;
  std::vector<std::string> objects;
  std::string start_gripper;
  std::string start_base;
  double rate = 50;
};

Pose2 parseBase(const std::string& text) {
  double v[3];
  LineTokens tokens(text);
  for (double& value : v) {
    if (parseDouble(tokens.next(), value) != NumberStatus::kOk) {
      throw Error(ExitCode::kUsage, "--start-base: expected \"x y yaw\"");
    }
  }
  if (!tokens.atEnd()) throw Error(ExitCode::kUsage, "--start-base: expected \"x y yaw\"");
  return Pose2(v[0], v[1], v[2]);
}

ExitCode run(const Options& options) {
  ReproduceOptions reproduce;
  reproduce.rate = options.rate;
  if (!options.start_gripper.empty()) {
    reproduce.start_gripper = parsePose(options.start_gripper, "--start-gripper");
  }
  if (!options.start_base.empty()) reproduce.start_base = parseBase(options.start_base);
  std::vector<Pose> objects;
  for (const std::string& text : options.objects) objects.push_back(parsePose(text, "--object"));
  const ReproducedMotion motion = reproduceResults(options.directories, objects, reproduce);
  Trajectory gripper;
  Trajectory base;
  for (const MotionPoint& point : motion.points) {
    gripper.times.push_back(point.time);
    base.times.push_back(point.time);
    gripper.poses.push_back(point.gripper);
    base.poses.push_back(floorPose(point.base));
  }
  StagedDirectory out(options.out);
  out.replaces({"motion"});
  out.write("motion/gripper.tum", formatTum(gripper));
  out.write("motion/base.tum", formatTum(base));
  out.write("motion/joints.csv", formatMotionJoints(motion));
  out.commit();
  std::printf("motion of %.2f s, %zu points; arm configuration for %zu", gripper.times.back(),
              motion.points.size(), motion.joints.solved);
  if (motion.has_map) std::printf("; %zu in collision with the map", motion.in_collision);
  std::printf("; written to %s/motion\n", options.out.c_str());
  return ExitCode::kSuccess;
}

}  // namespace

void addReproduce(Program& program) {
  auto options = std::make_shared<Options>();
  CLI::App* app =
      program.add("reproduce", "Generate a robot motion from learned models, chained if several",
                  [options] { return run(*options); });
  app->add_option("DIR", options->directories, "Folders that learn wrote, in order")->required();
  app->add_option("-o,--output", options->out, "Folder for motion/")->required();
  app->add_option("--object", options->objects,
                  "world_T_object \"x y z qx qy qz qw\", once per folder (default: as in the first "
                  "demonstration)")
      ->allow_extra_args(false);
  app->add_option("--start-gripper", options->start_gripper, "Start \"x y z qx qy qz qw\"");
  app->add_option("--start-base", options->start_base, "Start \"x y yaw\"");
  app->add_option("--rate", options->rate, "Samples per second")->capture_default_str();
}

}  // namespace graft::lfd
