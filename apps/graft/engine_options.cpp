// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft/engine_options.hpp"

#include <set>

#include "apps/common/last_words.hpp"
#include "apps/common/program.hpp"

namespace graft {

void EngineOptions::addPluginOption(CLI::App& command) {
  command
      .add_option("--plugin", plugins,
                  "Load a plugin: a file, or the name of one that graft knows (repeatable)")
      ->type_name("FILE|NAME")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void EngineOptions::addLoadOptions(CLI::App& command) {
  command.add_flag("--lenient", lenient,
                   "Skip lines with unknown tags (counted and reported) instead of rejecting "
                   "the file");
  command
      .add_option("--information", information,
                  "Information matrices with negative eigenvalues: reject the file, or project")
      ->check(CLI::IsMember({"error", "project"}))
      ->capture_default_str();
  command
      .add_option("--plugin-patience", patience,
                  "End where a function of a plugin (a loader, a resource, an initial guess, ...) "
                  "shows no sign of life for so many seconds, 0 = never; linear solvers are left "
                  "alone")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

std::unique_ptr<Engine> makeEngine(const EngineOptions& options) {
  PluginOptions plugins = detail::callersPluginOptions();
  plugins.probe = true;
  auto engine = std::make_unique<Engine>(plugins);
  for (const std::string& plugin : options.plugins) engine->plugins().addFile(plugin);
  printMessages(engine->plugins().diagnostics());
  engine->plugins().diagnostics().clear();
  return engine;
}

LoadedGraph loadAndReport(const std::string& path, Engine& engine, const EngineOptions& options) {
  LoadOptions load;
  load.lenient = options.lenient;
  load.project_information = options.information == "project";
  Diagnostics diagnostics;
  const Watchdog watchdog(0, options.patience);
  LoadedGraph loaded = loadGraph(path, engine.registry(), load, diagnostics);
  printMessages(diagnostics);
  return loaded;
}

std::string knownNames(Engine& engine, Kind kind) {
  std::set<std::string> names;
  for (const Provided& one : engine.registry().provided()) {
    if (one.kind == kind) names.insert(one.name);
  }
  for (const PluginManager::Known& known : engine.plugins().known()) {
    for (const Provided& one : known.file.provides) {
      if (one.kind == kind) names.insert(one.name);
    }
  }
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? " (known: " : ", ") + name;
  return text.empty() ? text : text + ")";
}

}  // namespace graft
