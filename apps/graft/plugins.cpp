// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <map>
#include <set>

#include "apps/common/interrupt.hpp"
#include "apps/graft/commands.hpp"
#include "apps/graft/engine_options.hpp"
#include "core/plugin/plugin_library.hpp"
#include "core/plugin/probe.hpp"

namespace graft {

namespace {

struct PluginsOptions {
  EngineOptions engine;
  bool doctor = false;
  double time_limit = ContainedLimits().step_seconds;
};

ExitCode list(const EngineOptions& options) {
  const auto engine = makeEngine(options);
  for (const PluginManager::Known& known : engine->plugins().known()) {
    const PluginFile& file = known.file;
    std::printf("%s %s  license %s\n", file.name.c_str(), file.version.c_str(),
                file.license.c_str());
    std::printf("  file %s\n", file.path.c_str());
    if (!file.refusal.empty()) std::printf("  not usable: %s\n", file.refusal.c_str());
    for (const std::string& required : file.requires_plugins) {
      std::printf("  requires %s\n", required.c_str());
    }
    for (const Provided& one : file.provides) {
      std::printf("  %s %s\n", metadataWord(one.kind), one.name.c_str());
    }
  }
  for (const std::string& folder : engine->plugins().folders()) {
    std::printf("folder %s\n", folder.c_str());
  }
  return ExitCode::kSuccess;
}

/// Tries plugin files in child processes and counts the bad ones.
class Doctor {
 public:
  Doctor(const PluginOptions& plugins, double time_limit) : plugins_(plugins) {
    limits_.step_seconds = time_limit;
    limits_.interrupt = &interruptFlag();
  }

  void examine(const std::string& path) {
    if (!seen_.insert(path).second) return;
    ++examined_;
    PluginFile file;
    std::string failure;
    std::vector<std::string> notes;
    try {
      file = readPluginFile(path);
      failure = file.refusal;
    } catch (const Error& e) {
      failure = e.what();
    }
    if (failure.empty()) failure = tryIt(file, notes);
    std::printf("%-4s %-16s %s\n", failure.empty() ? "good" : "BAD",
                file.name.empty() ? "-" : file.name.c_str(), path.c_str());
    for (const std::string& note : notes) say(path, "note", note);
    if (!failure.empty()) {
      ++bad_;
      say(path, "error", failure);
    }
  }
  /// What is named on the command line may be required by what follows.
  void examineGiven(const std::string& path) {
    const std::size_t bad = bad_;
    examine(path);
    if (bad_ == bad) good_files_.push_back(path);
  }
  void folder(const std::string& folder) {
    try {
      for (const std::string& path : pluginCandidates(folder)) examine(path);
    } catch (const Error& e) {
      ++bad_;
      say(e.where().path, "error", e.what());
    }
  }
  ExitCode finish() const {
    std::printf("%zu plugins examined, %zu bad\n", examined_, bad_);
    return bad_ == 0 ? ExitCode::kSuccess : ExitCode::kPlugin;
  }
  void say(const std::string& path, const char* severity, const std::string& text) const {
    std::fprintf(stderr, "%s\n", formatMessage({path, 0, 0}, severity, text).c_str());
  }

 private:
  /// Loads a file that can be read in a child; empty, or what is wrong.
  std::string tryIt(const PluginFile& file, std::vector<std::string>& notes) {
    ProbeResult probe = probePlugin(file.path, plugins_, limits_, good_files_);
    notes = std::move(probe.notes);
    if (!probe.failure.empty()) return probe.failure;
    if (!file.has_metadata) {
      notes.emplace_back("it does not say what it provides: only --plugin loads it");
    } else if (probe.provides != sorted(file.provides)) {
      return "what it registers is not what its metadata section lists";
    }
    const auto [first, alone] = by_name_.insert({file.name, file.path});
    if (!alone) {
      notes.push_back("the plugin " + file.name + " is taken from " + first->second +
                      ", which comes first");
      return "";
    }
    for (const Provided& one : probe.provides) {
      const auto [owner, added] = owners_.insert({one, file.path});
      if (!added) {
        return std::string(kindName(one.kind)) + " " + one.name + " is provided already by " +
               owner->second;
      }
    }
    return "";
  }
  static std::vector<Provided> sorted(std::vector<Provided> list) {
    std::sort(list.begin(), list.end());
    return list;
  }

  const PluginOptions& plugins_;
  ContainedLimits limits_;
  std::set<std::string> seen_;
  std::map<std::string, std::string> by_name_;  ///< file of a plugin
  std::map<Provided, std::string> owners_;      ///< file that provides something
  std::vector<std::string> good_files_;
  std::size_t examined_ = 0;
  std::size_t bad_ = 0;
};

ExitCode examine(const PluginsOptions& options) {
  const PluginOptions plugins = detail::callersPluginOptions();
  // Only finds folders: nothing is loaded into this process.
  Engine engine(plugins);
  Doctor doctor(plugins, options.time_limit);
  for (const std::string& folder : environmentPluginFolders()) {
    const std::string refusal = folderRefusal(folder);
    if (!refusal.empty()) doctor.say(folder, "warning", refusal);
  }
  for (const std::string& folder : engine.plugins().folders()) doctor.folder(folder);
  for (const std::string& plugin : options.engine.plugins) {
    const bool is_file = plugin.find('/') != std::string::npos ||
                         (plugin.size() > 3 && plugin.substr(plugin.size() - 3) == ".so");
    doctor.examineGiven(is_file ? plugin : findPluginFile(plugin, plugins).path);
  }
  return doctor.finish();
}

ExitCode run(const PluginsOptions& options) {
  return options.doctor ? examine(options) : list(options.engine);
}

}  // namespace

void addPlugins(Program& program) {
  auto options = std::make_shared<PluginsOptions>();
  CLI::App* command =
      program.add("plugins", "List known plugins, their licences and what they provide",
                  [options] { return run(*options); });
  options->engine.addPluginOption(*command);
  CLI::Option* doctor = command->add_flag(
      "--doctor", options->doctor,
      "Try each in a process of its own and say what is wrong with it (exit code 7 if one is bad)");
  command->add_option("--time-limit", options->time_limit, "Seconds that loading one may take")
      ->needs(doctor)
      ->check(CLI::Range(0.1, 1e6))
      ->capture_default_str();
}

}  // namespace graft
