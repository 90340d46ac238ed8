// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/plugin/plugin_manager.hpp"
#include "core/types/registry.hpp"

namespace graft {

namespace detail {
/// Where the plugins of the installed package lie, as the build of the calling
/// program knows it (set by find_package(graft)); internal linkage, because it
/// differs between callers.
static inline PluginOptions callersPluginOptions() {
  PluginOptions options;
#ifdef GRAFT_PACKAGE_PLUGINS
  options.more_folders.emplace_back(GRAFT_PACKAGE_PLUGINS);
#endif
  return options;
}
}  // namespace detail

/// A registry with its plugins: what a program needs to use types by name.
///
///   graft::Engine engine;
///   graft::FactorGraph graph(engine.registry());
class Engine {
 public:
  explicit Engine(const PluginOptions& options = detail::callersPluginOptions())
      : plugins_(registry_, options) {}

  Registry& registry() { return registry_; }
  PluginManager& plugins() { return plugins_; }

 private:
  Registry registry_;
  PluginManager plugins_;
};

}  // namespace graft
