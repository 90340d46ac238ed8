// SPDX-License-Identifier: BSD-3-Clause
#include "apps/common/program.hpp"

#include <cstdio>
#include <iostream>
#include <new>

#include "apps/common/interrupt.hpp"
#include "apps/common/last_words.hpp"

#ifndef GRAFT_VERSION
#define GRAFT_VERSION "unknown"
#endif

namespace graft {

Program::Program(const std::string& name, const std::string& description)
    : app_(description, name) {
  app_.set_version_flag("--version", name + " " + GRAFT_VERSION);
  app_.require_subcommand(1);
  app_.failure_message([](const CLI::App* app, const CLI::Error& e) {
    // The message of the innermost command that was being read.
    while (!app->get_subcommands().empty()) app = app->get_subcommands().front();
    std::string command = app->get_name();
    for (const CLI::App* up = app->get_parent(); up != nullptr; up = up->get_parent()) {
      command.insert(0, up->get_name() + " ");
    }
    return "error: " + std::string(e.what()) + "\nRun '" + command + " --help' for usage.\n";
  });
}

CLI::App* Program::add(const std::string& name, const std::string& description, Run run) {
  CLI::App* command = app_.add_subcommand(name, description);
  commands_.emplace_back(command, std::move(run));
  return command;
}

ExitCode Program::run(int argc, char** argv) {
  try {
    app_.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app_.exit(e, std::cout, std::cerr) == 0 ? ExitCode::kSuccess : ExitCode::kUsage;
  }
  for (const auto& [command, run] : commands_) {
    if (command->parsed()) return run();
  }
  return ExitCode::kUsage;
}

namespace {

void printError(const Error& error) {
  try {
    std::fprintf(stderr, "%s\n", error.formatted().c_str());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "error: %s\n", error.what());
  }
}

/// Turns every way out of `body` into an exit code.
ExitCode guarded(ExitCode (*body)(int, char**), int argc, char** argv) {
  try {
    return body(argc, argv);
  } catch (const Error& e) {
    printError(e);
    return e.code();
  } catch (const std::bad_alloc&) {
    std::fputs("error: out of memory\n", stderr);
    return ExitCode::kResources;
  } catch (const std::length_error&) {
    std::fputs("error: out of memory\n", stderr);
    return ExitCode::kResources;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: internal error: %s\n", e.what());
  } catch (...) {
    std::fputs("error: internal error\n", stderr);
  }
  return ExitCode::kInternal;
}

}  // namespace

int runProgram(ExitCode (*body)(int, char**), int argc, char** argv) {
  installInterruptHandlers();
  installLastWords();
  ExitCode code = guarded(body, argc, argv);
  std::cout.flush();
  if ((std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout) &&
      code == ExitCode::kSuccess) {
    std::fputs("<stdout>: error: cannot write the results\n", stderr);
    code = ExitCode::kOutput;
  }
  return static_cast<int>(code);
}

void printMessages(const Diagnostics& diagnostics) {
  const std::string text = diagnostics.text();
  if (!text.empty()) std::fprintf(stderr, "%s\n", text.c_str());
}

void printMessage(const std::string& severity, const std::string& text) {
  std::fprintf(stderr, "%s\n", formatMessage({}, severity, text).c_str());
}

}  // namespace graft
