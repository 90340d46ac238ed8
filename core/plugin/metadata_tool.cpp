// SPDX-License-Identifier: BSD-3-Clause
// Build tool: prints what a plugin registers, one "kind name" a line. The build
// stores the text in the plugin, so that it can be read without loading it.
#include <cstdio>

#include "core/base/error.hpp"
#include "core/plugin/plugin_library.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: graft-plugin-metadata LIBRARY\n");
    return static_cast<int>(graft::ExitCode::kUsage);
  }
  try {
    graft::Registry registry;
    const graft::PluginFile file = graft::readPluginFile(argv[1]);
    const graft::PluginRecord& record = graft::loadPluginLibrary(file, registry);
    std::fputs(graft::formatMetadata(record.provides).c_str(), stdout);
    return std::fflush(stdout) == 0 ? 0 : static_cast<int>(graft::ExitCode::kOutput);
  } catch (const graft::Error& e) {
    std::fprintf(stderr, "%s\n", e.formatted().c_str());
    return static_cast<int>(e.code());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
    return static_cast<int>(graft::ExitCode::kInternal);
  }
}
