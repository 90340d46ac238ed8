// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/report.hpp"

#include <memory>

#include "apps/graft_lfd/commands.hpp"
#include "types_lfd/learn/result_restore.hpp"

namespace graft::lfd {

namespace {

ExitCode run(const std::string& directory) {
  const RestoredResult restored = restoreResult(directory);
  StagedDirectory out(directory);
  out.replaces({"pictures", "report.html"});
  report::writeReport(restored.result, out, restored.messages);
  out.commit();
  std::printf("%s/report.html\n", directory.c_str());
  return ExitCode::kSuccess;
}

}  // namespace

void addReport(Program& program) {
  auto directory = std::make_shared<std::string>();
  CLI::App* app = program.add("report",
                              "Write report.html and pictures/ anew from the files of a result "
                              "folder",
                              [directory] { return run(*directory); });
  app->add_option("DIR", *directory, "Folder that learn wrote")->required();
}

}  // namespace graft::lfd
