// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "apps/common/program.hpp"

namespace graft::lfd {

// Each adds one subcommand, or a family of them, to the program.
void addLearn(Program& program);
void addCheck(Program& program);
void addStages(Program& program);  ///< match, segment, build, fit
void addTeach(Program& program);
void addReach(Program& program);
void addReproduce(Program& program);
void addEvaluate(Program& program);
void addReport(Program& program);

}  // namespace graft::lfd
