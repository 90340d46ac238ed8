// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/plugin/contained.hpp"
#include "core/plugin/plugin_manager.hpp"

namespace graft {

/// What became of a plugin that was tried in a child process.
struct ProbeResult {
  std::string failure;             ///< empty where it loads and leaves the process alone
  std::vector<std::string> notes;  ///< noteworthy, but no defect
  std::vector<Provided> provides;  ///< what it registered
};

/// Loads a plugin, and what it requires, in a child process and compares the
/// state of the process before and after. Nothing of it runs in this process.
/// `required` are files loaded before it. Throws as runContained() does.
ProbeResult probePlugin(const std::string& file_or_name, const PluginOptions& options,
                        const ContainedLimits& limits,
                        const std::vector<std::string>& required = {});

}  // namespace graft
