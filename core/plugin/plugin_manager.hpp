// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/plugin/plugin_file.hpp"
#include "core/types/registry.hpp"

namespace graft {

struct PluginOptions {
  /// Folders whose plugins are loaded when something they provide is needed.
  /// Empty: those of the program's own build tree or install.
  std::vector<std::string> folders;
  /// Further folders, e.g. known to the build of the calling program.
  std::vector<std::string> more_folders;
  /// Also those named by GRAFT_PLUGIN_PATH (absolute parts only).
  bool use_environment = true;
  /// Tries plugins from outside `folders` and `more_folders` (given by file, or
  /// found through the environment) in a child process before they are loaded
  /// into this one; see probePlugin().
  bool probe = false;
};

/// Files in a folder that are named as plugins are (libgraft_*.so), sorted.
/// Throws Error(kPlugin) where it cannot be listed.
std::vector<std::string> pluginCandidates(const std::string& folder);

/// Stamp and metadata of a plugin named as for addFile(), without loading
/// anything. Throws Error(kPlugin) where there is none.
PluginFile findPluginFile(const std::string& file_or_name, const PluginOptions& options);

/// Finds plugins, knows what they provide without loading them, and loads them
/// when needed: it makes itself the registry's resolver and advisor. Files
/// outside the trusted folders are loaded only through addFile(). Must live
/// as long as the registry is asked for names; not copyable.
class PluginManager {
 public:
  explicit PluginManager(Registry& registry, const PluginOptions& options = {});
  ~PluginManager();
  PluginManager(const PluginManager&) = delete;
  PluginManager& operator=(const PluginManager&) = delete;

  /// A plugin of a trusted folder, or one given by file.
  struct Known {
    PluginFile file;
    std::string folder;
    bool trusted = false;  ///< lies in the program's own folders
    bool loaded = false;
    bool loading = false;
  };

  /// Loads a plugin now: a file (if `file_or_name` has a slash or ends with
  /// .so), else the trusted plugin of that name. Throws Error(kPlugin).
  void addFile(const std::string& file_or_name);
  /// Loads every trusted plugin (for listings); defects become warnings.
  void loadAll();
  /// Throws Error(kPlugin) where there is no trusted plugin of that name.
  void loadByName(const std::string& name);
  /// Throws the Error(kPlugin) for such a name.
  [[noreturn]] void unknownName(const std::string& name) const;

  const std::vector<Known>& known() const { return known_; }
  const std::vector<std::string>& folders() const { return folders_; }
  /// Notes and warnings of scanning and loading; the caller prints them.
  Diagnostics& diagnostics() { return diagnostics_; }

 private:
  void scan(const std::string& folder, bool trusted);
  void probe(const PluginFile& file) const;
  void load(std::size_t index);
  bool resolve(const Provided& wanted);
  std::string advise(const Provided& wanted) const;
  std::size_t findByName(const std::string& name) const;

  Registry& registry_;
  PluginOptions options_;
  std::vector<std::string> folders_;
  std::vector<Known> known_;
  Diagnostics diagnostics_;
};

}  // namespace graft
