// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "apps/graft/commands.hpp"
#include "apps/graft/engine_options.hpp"

namespace graft {

namespace {

ExitCode run(const EngineOptions& options) {
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

}  // namespace

void addPlugins(Program& program) {
  auto options = std::make_shared<EngineOptions>();
  CLI::App* command =
      program.add("plugins", "List known plugins, their licences and what they provide",
                  [options] { return run(*options); });
  options->addPluginOption(*command);
}

}  // namespace graft
