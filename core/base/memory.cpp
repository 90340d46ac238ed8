// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <limits>

#include "core/base/error.hpp"

namespace graft {

namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Requests below this are not worth looking, and heaps have as much in reserve.
constexpr double kNotWorthAsking = 4e6;

/// What may be used of the memory that is free: other things are kept there, too.
constexpr double kUsableShare = 0.95;

/// The number that follows `key` in a file of "key number" lines, or the first number
/// where the key is empty; NaN without one ("max").
double numberIn(const std::string& path, const std::string& key) {
  std::ifstream file(path);
  std::string word;
  while (!key.empty() && file >> word && word != key) {
  }
  double number = 0;
  return file >> number ? number : std::numeric_limits<double>::quiet_NaN();
}

double freeOnMachine() {
  const double kilobytes = numberIn("/proc/meminfo", "MemAvailable:");
  if (kilobytes >= 0) return 1024 * kilobytes;
  const auto pages = double(sysconf(_SC_PHYS_PAGES));
  const auto size = double(sysconf(_SC_PAGESIZE));
  return pages > 0 && size > 0 ? pages * size : kUnlimited;
}

/// What one group leaves: its page cache can be dropped, so it does not count.
double freeInGroup(const std::string& folder, const char* limit, const char* usage,
                   const char* cache) {
  const double most = numberIn(folder + limit, "");
  const double used = numberIn(folder + usage, "");
  if (!(most >= 0)) return kUnlimited;
  if (!(used >= 0)) return most;
  const double droppable = numberIn(folder + "/memory.stat", cache);
  return std::max(0.0, most - std::max(0.0, used - (droppable >= 0 ? droppable : 0)));
}

double freeInAddressSpace() {
  rlimit limit = {};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnlimited;
  const double pages = numberIn("/proc/self/statm", "");
  const double used = pages >= 0 ? pages * double(sysconf(_SC_PAGESIZE)) : 0;
  return std::max(0.0, double(limit.rlim_cur) - used);
}

}  // namespace

double availableInGroups(const std::string& root) {
  double least = kUnlimited;
  std::ifstream groups(root + "/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const bool unified = controllers.empty();
    if (!unified && controllers.find("memory") == std::string::npos) continue;
    const std::string tree = root + (unified ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory");
    std::string path = line.substr(second + 1);
    if (path == "/") path.clear();
    for (;;) {
      const std::string folder = tree + path;
      least = std::min(
          least, unified ? freeInGroup(folder, "/memory.max", "/memory.current", "inactive_file")
                         : freeInGroup(folder, "/memory.limit_in_bytes", "/memory.usage_in_bytes",
                                       "total_inactive_file"));
      if (path.empty()) break;
      path.resize(path.rfind('/') == std::string::npos ? 0 : path.rfind('/'));
    }
  }
  return least;
}

double availableMemory() {
  return std::min({freeOnMachine(), availableInGroups(), freeInAddressSpace()});
}

std::string formatBytes(double bytes) {
  const char* const units[] = {"B", "kB", "MB", "GB", "TB", "PB"};
  std::size_t unit = 0;
  while (bytes >= 999.5 && unit + 1 < std::size(units)) {
    bytes /= 1000;
    ++unit;
  }
  char text[32];
  const int digits = unit == 0 || bytes >= 99.95 ? 0 : bytes >= 9.995 ? 1 : 2;
  std::snprintf(text, sizeof text, "%.*f %s", digits, bytes, units[unit]);
  return text;
}

bool fitsIntoMemory(double bytes) {
  return bytes < kNotWorthAsking || bytes <= kUsableShare * availableMemory();
}

void requireMemory(double bytes, const std::string& what, const std::string& advice) {
  if (fitsIntoMemory(bytes)) return;
  throw Error(ExitCode::kNoResult, what + " needs " + formatBytes(bytes) + ", " +
                                       formatBytes(availableMemory()) + " are free" + advice);
}

}  // namespace graft
