// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/graft_lfd/commands.hpp"
#include "apps/graft_lfd/session.hpp"
#include "types_lfd/learn/result_json.hpp"
#include "types_lfd/learn/result_reader.hpp"

namespace graft::lfd {

namespace {

/// Table I of the trajectories of a result folder, from the files alone.
ExitCode runEvaluate(const std::string& directory, bool as_json) {
  const LearnedFolder folder = readLearnedFolder(directory);
  Diagnostics diagnostics;
  const TaskScene loaded = loadResultScene(folder.task, diagnostics);
  printMessages(diagnostics);
  const Scene scene{loaded.grasps.get(), loaded.reach.get(), loaded.footprint.get(),
                    Weights().grasp_quality};
  const Table1 table = computeTable1(folder.demonstrations, scene, false);
  if (as_json) {
    std::printf("%s\n", table1Json(table).dump(2).c_str());
  } else {
    printTable1(folder.task.name, nullptr, table);
  }
  return ExitCode::kSuccess;
}

}  // namespace

void addEvaluate(Program& program) {
  struct Options {
    std::string directory;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* app = program.add("evaluate", "Recompute Table I from the files of a result folder",
                              [options] { return runEvaluate(options->directory, options->json); });
  app->add_option("DIR", options->directory, "Folder that learn wrote")->required();
  app->add_flag("--json", options->json, "Print the rows as JSON");
}

}  // namespace graft::lfd
