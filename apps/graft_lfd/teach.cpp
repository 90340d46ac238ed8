// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/teacher.hpp"

#include <memory>

#include "apps/graft_lfd/commands.hpp"

namespace graft::lfd {

namespace {

struct Options {
  std::string task;
  std::string out;
  std::uint64_t seed = 1;
};

}  // namespace

void addTeach(Program& program) {
  auto options = std::make_shared<Options>();
  CLI::App* app =
      program.add("teach", "Write a task folder demonstrated by a simulated teacher", [options] {
        teach(options->task, options->out, options->seed);
        std::printf("%s: task folder with demonstrations, map, grasps, robot and truth\n",
                    (options->out + "/task.xml").c_str());
        return ExitCode::kSuccess;
      });
  app->add_option("TASKNAME", options->task, "room_door, swivel_door, drawer or sliding_door")
      ->required();
  app->add_option("-o,--output", options->out, "Folder to write")->required();
  app->add_option("--seed", options->seed, "Other seeds give other scenes, motions and noise")
      ->capture_default_str();
}

}  // namespace graft::lfd
