// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_cache.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace graft::lfd {

namespace fs = std::filesystem;

namespace {

// Raised whenever the builder would give other cells for the same options.
constexpr std::uint64_t kBuilderGeneration = 2;

std::string absoluteFromEnvironment(const char* variable) {
  const char* value = ::secure_getenv(variable);
  return value != nullptr && value[0] == '/' ? value : "";
}

void mix(std::uint64_t& hash, std::uint64_t value) {
  hash = (hash ^ value) * 0x9e3779b97f4a7c15ULL;
  hash ^= hash >> 32;
}

void mix(std::uint64_t& hash, double value) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  mix(hash, bits);
}

}  // namespace

std::string reachCacheFolder() {
  if (auto own = absoluteFromEnvironment("GRAFT_CACHE_DIR"); !own.empty()) return own;
  if (auto xdg = absoluteFromEnvironment("XDG_CACHE_HOME"); !xdg.empty()) return xdg + "/graft";
  if (auto home = absoluteFromEnvironment("HOME"); !home.empty()) return home + "/.cache/graft";
  return "";
}

std::string reachCacheName(const Chain& chain, const ReachOptions& options) {
  std::uint64_t hash = kBuilderGeneration;
  mix(hash, chain.hash());
  mix(hash, options.resolution);
  mix(hash, options.angular_step);
  mix(hash, options.seed);
  mix(hash, options.new_cell_share);
  mix(hash, options.max_samples);
  char name[40];
  std::snprintf(name, sizeof name, "reach-%016llx.irm", static_cast<unsigned long long>(hash));
  return name;
}

ReachMap cachedReachMap(const Chain& chain, const ReachOptions& options,
                        const ReachProgress& progress, std::string* path_used,
                        Diagnostics& diagnostics) {
  if (path_used != nullptr) path_used->clear();
  const std::string folder = reachCacheFolder();
  if (folder.empty()) {
    diagnostics.warning({}, "no folder to cache reachability maps in (HOME is not set)");
    return ReachMap::build(chain, options, progress);
  }
  const std::string path = folder + "/" + reachCacheName(chain, options);
  std::error_code ignored;
  if (fs::exists(path, ignored)) {
    try {
      ReachMap map = ReachMap::load(path);
      map.requireChain(chain, path);
      if (path_used != nullptr) *path_used = path;
      return map;
    } catch (const Error& error) {
      diagnostics.warning({path, 0, 0},
                          std::string("the cached map is built anew: ") + error.what());
    }
  }
  ReachMap map = ReachMap::build(chain, options, progress);
  try {
    fs::create_directories(folder, ignored);
    map.save(path);
    if (path_used != nullptr) *path_used = path;
  } catch (const Error& error) {
    diagnostics.warning({path, 0, 0},
                        std::string("the reachability map cannot be cached: ") + error.what());
  }
  return map;
}

}  // namespace graft::lfd
