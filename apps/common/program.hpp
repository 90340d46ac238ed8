// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.hpp"

namespace graft {

/// The subcommands of a program: each adds its options to `app` and gives the
/// function that runs it.
class Program {
 public:
  Program(const std::string& name, const std::string& description);

  using Run = std::function<ExitCode()>;
  /// Declares a subcommand; `run` is called after its options were read.
  CLI::App* add(const std::string& name, const std::string& description, Run run);
  void setFooter(const std::string& text) { app_.footer(text); }

  /// Reads the command line and runs the chosen subcommand.
  ExitCode run(int argc, char** argv);

 private:
  CLI::App app_;
  std::vector<std::pair<CLI::App*, Run>> commands_;
};

/// What a main() does: installs the handlers of signals, runs `body` and turns every way
/// out of it into an exit code: Error by its code with `path:line:column: error: text`
/// on standard error, memory exhaustion 6, anything else 1. A standard output that could
/// not be written is 5.
int runProgram(ExitCode (*body)(int, char**), int argc, char** argv);

/// Prints collected messages on standard error.
void printMessages(const Diagnostics& diagnostics);
void printMessage(const std::string& severity, const std::string& text);

}  // namespace graft
