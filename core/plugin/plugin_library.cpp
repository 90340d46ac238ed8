// SPDX-License-Identifier: BSD-3-Clause
#include "core/plugin/plugin_library.hpp"

#include <dlfcn.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "core/base/error.hpp"

#ifndef GRAFT_PLUGINS_FROM_BIN
#define GRAFT_PLUGINS_FROM_BIN "../lib/graft/plugins"
#endif
#ifndef GRAFT_PLUGINS_INSTALLED
#define GRAFT_PLUGINS_INSTALLED ""
#endif

namespace graft {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const PluginFile& file, const std::string& text) {
  throw Error(ExitCode::kPlugin, {file.path, 0, 0}, text);
}

void* openLibrary(const PluginFile& file) {
  // A path without a slash would be searched for in the system's folders.
  const std::string path = fs::absolute(file.path).string();
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || status.st_dev != file.device ||
      status.st_ino != file.inode) {
    fail(file, "the file was replaced while it was being loaded");
  }
  ::dlerror();
  void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (library == nullptr) {
    const char* why = ::dlerror();
    fail(file,
         std::string("cannot load the plugin: ") + (why != nullptr ? why : "no reason given"));
  }
  return library;
}

void addFolder(std::vector<std::string>& folders, const fs::path& folder) {
  std::error_code error;
  if (folder.empty() || !fs::is_directory(folder, error)) return;
  const std::string canonical = fs::canonical(folder, error).string();
  if (error) return;
  for (const std::string& known : folders) {
    if (known == canonical) return;
  }
  folders.push_back(canonical);
}

}  // namespace

const PluginRecord& loadPluginLibrary(const PluginFile& file, Registry& registry) {
  if (!file.refusal.empty()) fail(file, file.refusal);
  void* library = openLibrary(file);
  // A function pointer out of dlsym, in the way POSIX prescribes.
  void* symbol = ::dlsym(library, GRAFT_REGISTER_SYMBOL);
  graft_register_function entry = nullptr;
  static_assert(sizeof entry == sizeof symbol, "POSIX");
  *reinterpret_cast<void**>(&entry) = symbol;
  if (entry == nullptr) fail(file, std::string("it has no function ") + GRAFT_REGISTER_SYMBOL);
  try {
    return registry.registerPlugin(file.name, file.path, file.version, file.license, entry);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    fail(file, std::string("its registration threw an exception: ") + e.what());
  } catch (...) {
    fail(file, "its registration threw an exception");
  }
}

std::vector<std::string> ownPluginFolders() {
  std::vector<std::string> folders;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    addFolder(folders, program.parent_path() / "../lib/graft/plugins");
    addFolder(folders, program.parent_path() / GRAFT_PLUGINS_FROM_BIN);
  }
  Dl_info info = {};
  if (::dladdr(reinterpret_cast<void*>(&ownPluginFolders), &info) != 0 &&
      info.dli_fname != nullptr) {
    const fs::path library = fs::canonical(info.dli_fname, error);
    if (!error && library != program) addFolder(folders, library.parent_path() / "graft/plugins");
  }
  addFolder(folders, GRAFT_PLUGINS_INSTALLED);
  return folders;
}

std::vector<std::string> environmentPluginFolders() {
  std::vector<std::string> folders;
  const char* list = ::secure_getenv("GRAFT_PLUGIN_PATH");
  if (list == nullptr) return folders;
  std::istringstream parts(list);
  for (std::string part; std::getline(parts, part, ':');) {
    if (!part.empty() && part.front() == '/') folders.push_back(part);
  }
  return folders;
}

}  // namespace graft
