// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "core/io/graph_loader.hpp"
#include "core/plugin/engine.hpp"

namespace graft {

/// Options that every command with plugins and a graph has.
struct EngineOptions {
  std::vector<std::string> plugins;
  bool lenient = false;
  std::string information = "error";
  double patience = 600;  ///< s, see Watchdog

  void addPluginOption(CLI::App& command);
  void addLoadOptions(CLI::App& command);
};

/// Finds plugins, loads those asked for, and prints what was noteworthy.
std::unique_ptr<Engine> makeEngine(const EngineOptions& options);

/// Loads a graph and prints its warnings and notes.
LoadedGraph loadAndReport(const std::string& path, Engine& engine, const EngineOptions& options);

/// " (known: a, b, c)": all names of a kind, of plugins not yet loaded, too.
std::string knownNames(Engine& engine, Kind kind);

}  // namespace graft
