// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace graft {

/// A file that `graft new-plugin` writes. In its text @NAME@, @UPPER@ and @CAMEL@
/// stand for the plugin's name as given, in upper case and in upper camel case.
struct PluginTemplate {
  const char* file;
  const char* text;
};

/// The files in the folder new_plugin, built into the program.
const std::vector<PluginTemplate>& pluginTemplates();

}  // namespace graft
