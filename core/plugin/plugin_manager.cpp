// SPDX-License-Identifier: BSD-3-Clause
#include "core/plugin/plugin_manager.hpp"

#include <dirent.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>

#include "core/io/graph_loader.hpp"
#include "core/plugin/plugin_library.hpp"
#include "core/plugin/probe.hpp"

namespace graft {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

bool startsWith(const std::string& text, const std::string& head) {
  return text.compare(0, head.size(), head) == 0;
}

bool endsWith(const std::string& text, const std::string& tail) {
  return text.size() >= tail.size() &&
         text.compare(text.size() - tail.size(), tail.size(), tail) == 0;
}

bool equalButForCase(const std::string& a, const std::string& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](char x, char y) {
           return std::toupper(static_cast<unsigned char>(x)) ==
                  std::toupper(static_cast<unsigned char>(y));
         });
}

bool looksLikeFile(const std::string& text) {
  return text.find('/') != std::string::npos || endsWith(text, ".so");
}

}  // namespace

std::vector<std::string> pluginCandidates(const std::string& folder) {
  // Not a directory_iterator: without memory for a name that would end the program.
  const std::unique_ptr<DIR, int (*)(DIR*)> stream(::opendir(folder.c_str()), &::closedir);
  const auto fail = [&folder] {
    const bool full = errno == EMFILE || errno == ENFILE;
    throw Error(full ? ExitCode::kOutput : ExitCode::kPlugin, {folder, 0, 0},
                std::string("cannot list plugins: ") + std::strerror(errno));
  };
  if (!stream) fail();
  std::vector<std::string> files;
  for (;;) {
    errno = 0;
    const dirent* entry = ::readdir(stream.get());
    if (entry == nullptr) break;
    const std::string name = entry->d_name;
    if (startsWith(name, "libgraft_") && endsWith(name, ".so")) {
      files.push_back((fs::path(folder) / name).string());
    }
  }
  if (errno != 0) fail();
  std::sort(files.begin(), files.end());
  return files;
}

PluginManager::PluginManager(Registry& registry, const PluginOptions& options)
    : registry_(registry),
      options_(options),
      folders_(options.folders.empty() ? ownPluginFolders() : options.folders) {
  folders_.insert(folders_.end(), options.more_folders.begin(), options.more_folders.end());
  for (const std::string& folder : folders_) scan(folder, true);
  if (options.use_environment) {
    for (const std::string& folder : environmentPluginFolders()) {
      const std::string refusal = folderRefusal(folder);
      if (!refusal.empty()) {
        diagnostics_.warning({folder, 0, 0}, refusal);
        continue;
      }
      folders_.push_back(folder);
      scan(folder, false);
    }
  }
  registry_.setResolver([this](const Provided& wanted) { return resolve(wanted); });
  registry_.setAdvisor([this](const Provided& wanted) { return advise(wanted); });
}

PluginManager::~PluginManager() {
  registry_.setResolver(nullptr);
  registry_.setAdvisor(nullptr);
}

void PluginManager::scan(const std::string& folder, bool trusted) {
  std::vector<std::string> files;
  try {
    files = pluginCandidates(folder);
  } catch (const Error& e) {
    if (e.code() != ExitCode::kPlugin) throw;
    diagnostics_.warning(e.where(), e.what());
  }
  for (const std::string& path : files) {
    PluginFile file;
    try {
      file = readPluginFile(path);
    } catch (const Error& e) {
      if (e.code() != ExitCode::kPlugin) throw;
      diagnostics_.warning(e.where(), e.what());
      continue;
    }
    const auto same_file = [&file](const Known& known) {
      return known.file.device == file.device && known.file.inode == file.inode;
    };
    if (std::any_of(known_.begin(), known_.end(), same_file)) continue;
    const std::size_t first = findByName(file.name);
    if (first != kNone) {
      diagnostics_.note({path, 0, 0}, "plugin " + file.name + " is taken from " +
                                          known_[first].file.path + ", which comes first");
      continue;
    }
    if (!file.has_metadata) {
      diagnostics_.note({path, 0, 0}, "plugin " + file.name +
                                          " does not say what it provides; load it with --plugin");
    }
    known_.push_back({std::move(file), folder, trusted, false, false});
  }
}

std::size_t PluginManager::findByName(const std::string& name) const {
  for (std::size_t i = 0; i < known_.size(); ++i) {
    if (known_[i].file.name == name) return i;
  }
  return kNone;
}

void PluginManager::load(std::size_t index) {
  if (known_[index].loaded) return;
  const PluginFile file = known_[index].file;
  if (known_[index].loading) {
    throw Error(ExitCode::kPlugin, {file.path, 0, 0},
                "plugins require each other in a circle: " + file.name);
  }
  if (!file.refusal.empty()) throw Error(ExitCode::kPlugin, {file.path, 0, 0}, file.refusal);
  known_[index].loading = true;
  try {
    for (const std::string& required : file.requires_plugins) {
      const std::size_t other = findByName(required);
      if (other == kNone) {
        throw Error(ExitCode::kPlugin, {file.path, 0, 0},
                    "it requires the plugin " + required + ", which is not found");
      }
      load(other);
    }
    if (options_.probe && !known_[index].trusted) probe(file);
    loadPluginLibrary(file, registry_);
  } catch (...) {
    known_[index].loading = false;
    throw;
  }
  known_[index].loading = false;
  known_[index].loaded = true;
}

void PluginManager::probe(const PluginFile& file) const {
  std::vector<std::string> loaded;
  for (const Known& known : known_) {
    if (known.loaded && !known.trusted) loaded.push_back(known.file.path);
  }
  // The path as a file, whatever it looks like.
  const std::string path = fs::absolute(file.path).string();
  const ProbeResult result = probePlugin(path, options_, ContainedLimits(), loaded);
  if (result.failure.empty()) return;
  throw Error(ExitCode::kPlugin, {file.path, 0, 0}, result.failure);
}

void PluginManager::loadByName(const std::string& name) {
  const std::size_t index = findByName(name);
  if (index == kNone) unknownName(name);
  load(index);
}

PluginFile findPluginFile(const std::string& file_or_name, const PluginOptions& options) {
  if (looksLikeFile(file_or_name)) return readPluginFile(file_or_name);
  Registry registry;
  const PluginManager plugins(registry, options);
  for (const PluginManager::Known& known : plugins.known()) {
    if (known.file.name == file_or_name) return known.file;
  }
  plugins.unknownName(file_or_name);
}

void PluginManager::unknownName(const std::string& name) const {
  std::string names;
  for (const Known& known : known_) names += (names.empty() ? "" : ", ") + known.file.name;
  throw Error(ExitCode::kPlugin, "there is no plugin named " + graft::quoted(name) +
                                     (names.empty() ? "" : " (known: " + names + ")"));
}

void PluginManager::addFile(const std::string& file_or_name) {
  if (!looksLikeFile(file_or_name)) return loadByName(file_or_name);
  PluginFile file = readPluginFile(file_or_name);
  for (std::size_t i = 0; i < known_.size(); ++i) {
    if (known_[i].file.device == file.device && known_[i].file.inode == file.inode) return load(i);
  }
  const std::size_t first = findByName(file.name);
  if (first != kNone && known_[first].loaded) {
    throw Error(ExitCode::kPlugin, {file.path, 0, 0},
                "a plugin named " + file.name + " is loaded already: " + known_[first].file.path);
  }
  Known added{std::move(file), fs::path(file_or_name).parent_path().string(), false, false, false};
  if (first != kNone) {
    // What is named on the command line goes before what lies in a folder.
    diagnostics_.note({added.file.path, 0, 0}, "used instead of " + known_[first].file.path);
    known_[first] = std::move(added);
    return load(first);
  }
  known_.push_back(std::move(added));
  load(known_.size() - 1);
}

void PluginManager::loadAll() {
  for (std::size_t i = 0; i < known_.size(); ++i) {
    try {
      load(i);
    } catch (const Error& e) {
      diagnostics_.warning(e.where(), e.what());
    }
  }
}

bool PluginManager::resolve(const Provided& wanted) {
  const bool any = wanted.kind == Kind::kLoader && wanted.name == kEveryLoader;
  bool loaded = false;
  for (std::size_t i = 0; i < known_.size(); ++i) {
    if (known_[i].loaded || known_[i].loading) continue;
    const std::vector<Provided>& provides = known_[i].file.provides;
    const bool has = std::any_of(provides.begin(), provides.end(), [&](const Provided& one) {
      return any ? one.kind == Kind::kLoader : one == wanted;
    });
    if (!has) continue;
    load(i);
    loaded = true;
    if (!any) break;
  }
  return loaded;
}

std::string PluginManager::advise(const Provided& wanted) const {
  std::string nearest;
  std::string owner;
  std::size_t distance = wanted.name.size() / 3 + 1;
  for (const Known& known : known_) {
    for (const Provided& one : known.file.provides) {
      if (one.name != wanted.name && equalButForCase(one.name, wanted.name)) {
        return " (upper and lower case differ: " + one.name + "?)";
      }
    }
  }
  for (const Known& known : known_) {
    if (known.loaded) continue;
    for (const Provided& one : known.file.provides) {
      if (one.name == wanted.name && one.kind != wanted.kind) {
        return " (" + one.name + " is a " + kindName(one.kind) + " of the plugin " +
               known.file.name + ")";
      }
      if (one.kind != wanted.kind || registry_.has(one)) continue;
      const std::size_t d = editDistance(one.name, wanted.name);
      if (d < distance) {
        distance = d;
        nearest = one.name;
        owner = known.file.name;
      }
    }
  }
  if (nearest.empty()) return "";
  return " (the plugin " + owner + " has " + nearest + ")";
}

}  // namespace graft
