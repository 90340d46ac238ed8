// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

#include "apps/common/program.hpp"

namespace graft {

using Clock = std::chrono::steady_clock;

// One function per subcommand, each in the file of its name: declares the
// options and what runs.
void addNewPlugin(Program& program);
void addOptimize(Program& program, Clock::time_point start);
void addCheck(Program& program);
void addCheckPlugin(Program& program);
void addConvert(Program& program);
void addEvaluate(Program& program);
void addPlugins(Program& program);
void addSimulate(Program& program);
void addTypes(Program& program);

}  // namespace graft
