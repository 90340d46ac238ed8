// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft_lfd/commands.hpp"

namespace {

graft::ExitCode run(int argc, char** argv) {
  namespace lfd = graft::lfd;
  graft::Program program("graft-lfd",
                         "Learns mobile manipulation from human demonstrations: from recorded "
                         "tracks of hand, torso and object to motions of a robot.");
  program.setFooter(
      "Start with: graft-lfd teach drawer -o drawer && graft-lfd learn drawer/task.xml -o out\n"
      "Exit codes: 0 result written, 2 usage, 3 input rejected, 4 no usable result, 5 output,\n"
      "6 memory or a limit, 7 plugin, 130/143 interrupted after saving.");
  lfd::addLearn(program);
  lfd::addCheck(program);
  lfd::addStages(program);
  lfd::addTeach(program);
  lfd::addReach(program);
  lfd::addReproduce(program);
  lfd::addEvaluate(program);
  lfd::addReport(program);
  return program.run(argc, argv);
}

}  // namespace

int main(int argc, char** argv) { return graft::runProgram(&run, argc, argv); }
