// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/plugin/plugin_file.hpp"

namespace graft {

/// Loads the library of a compatible plugin file (RTLD_NOW | RTLD_LOCAL, never
/// unloaded) and registers what it provides, all or nothing. Throws
/// Error(kPlugin) with the file and the loader's own text.
const PluginRecord& loadPluginLibrary(const PluginFile& file, Registry& registry);

/// Folder of the plugins that belong to this program: those of its build tree
/// or of its install, found from where the program, or the shared library that
/// holds this code, lies. Only folders that exist.
std::vector<std::string> ownPluginFolders();

/// Folders named by GRAFT_PLUGIN_PATH (separated by ':'; relative ones are left
/// out; ignored in privileged processes).
std::vector<std::string> environmentPluginFolders();

}  // namespace graft
