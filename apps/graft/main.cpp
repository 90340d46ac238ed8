// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft/commands.hpp"

namespace {

graft::ExitCode run(int argc, char** argv) {
  const auto start = graft::Clock::now();
  graft::Program program("graft", "Optimizes factor graphs whose types come from plugins.");
  graft::addOptimize(program, start);
  graft::addCheck(program);
  graft::addEvaluate(program);
  graft::addConvert(program);
  graft::addSimulate(program);
  graft::addTypes(program);
  graft::addPlugins(program);
  graft::addCheckPlugin(program);
  graft::addNewPlugin(program);
  program.setFooter(
      "Exit codes: 0 usable result, all outputs written; 1 internal error; 2 usage; 3 input\n"
      "rejected; 4 no usable result; 5 output; 6 resources; 7 plugin; 130/143 interrupted\n"
      "after saving the best so far. Messages go to standard error, results to standard output.");
  return program.run(argc, argv);
}

}  // namespace

int main(int argc, char** argv) { return graft::runProgram(&run, argc, argv); }
