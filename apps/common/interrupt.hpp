// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>

#include "core/base/error.hpp"

namespace graft {

/// Makes SIGINT, SIGTERM and SIGHUP set a flag that long work polls; another one
/// half a second later ends the process at once. A broken pipe becomes a write error.
void installInterruptHandlers();

/// 0, or the signal that arrived.
const std::atomic<int>& interruptFlag();

/// Exit code of a run that was interrupted and saved what it had.
ExitCode interruptExitCode();

}  // namespace graft
