// SPDX-License-Identifier: BSD-3-Clause
#include "core/plugin/plugin_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <sstream>

#include "core/base/error.hpp"
#include "core/plugin/elf_file.hpp"
#include "core/types/stamp.hpp"

namespace graft {

namespace {

template <std::size_t N>
std::string textOf(const char (&field)[N]) {
  return std::string(field, ::strnlen(field, N));
}

std::vector<std::string> words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> list;
  for (std::string word; stream >> word;) list.push_back(word);
  return list;
}

/// Instruction sets that the library was compiled for and this processor lacks.
std::string missingInstructions(std::uint32_t isa) {
  std::string missing;
#if defined(__x86_64__)
  __builtin_cpu_init();
  const auto need = [&](std::uint32_t bit, bool supported, const char* name) {
    if ((isa & bit) != 0 && !supported) missing += std::string(missing.empty() ? "" : ", ") + name;
  };
  need(1u, __builtin_cpu_supports("avx") != 0, "AVX");
  need(2u, __builtin_cpu_supports("avx2") != 0, "AVX2");
  need(4u, __builtin_cpu_supports("fma") != 0, "FMA");
  need(8u, __builtin_cpu_supports("avx512f") != 0, "AVX-512F");
  if ((isa & ~15u) != 0) missing += std::string(missing.empty() ? "" : ", ") + "unknown features";
#else
  if (isa != 0) missing = "x86 extensions";
#endif
  return missing;
}

/// True where everybody may write the folder of a file, and rename what others
/// put there (no sticky bit).
bool anyoneMayReplace(const std::string& path) {
  std::string folder = std::filesystem::path(path).parent_path().string();
  if (folder.empty()) folder = ".";
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0) return false;
  return (status.st_mode & S_IWOTH) != 0 && (status.st_mode & S_ISVTX) == 0;
}

}  // namespace

std::string folderRefusal(const std::string& folder) {
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0) return "";
  if ((status.st_mode & S_IWOTH) != 0) {
    return "anyone may put files into this folder (mode o+w); its plugins are not used";
  }
  if (status.st_uid != 0 && status.st_uid != ::geteuid()) {
    return "this folder belongs to another user; its plugins are not used";
  }
  return "";
}

const char* metadataWord(Kind kind) {
  switch (kind) {
    case Kind::kVertex:
      return "vertex";
    case Kind::kEdge:
      return "edge";
    case Kind::kResource:
      return "resource";
    case Kind::kKernel:
      return "kernel";
    case Kind::kSolver:
      return "solver";
    case Kind::kLoader:
      return "loader";
    case Kind::kGuess:
      return "guess";
  }
  return "unknown";
}

std::string formatMetadata(const std::vector<Provided>& provides) {
  std::string text;
  for (const Provided& one : provides) {
    text += std::string(metadataWord(one.kind)) + ' ' + one.name + '\n';
  }
  return text;
}

std::vector<Provided> parseMetadata(const std::string& text) {
  std::vector<Provided> provides;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string> parts = words(line);
    if (parts.size() < 2) continue;
    for (const Kind kind : kAllKinds) {
      if (parts[0] == metadataWord(kind)) provides.push_back({kind, parts[1]});
    }
  }
  return provides;
}

std::string stampMismatch(const graft_abi_stamp& theirs) {
  const graft_abi_stamp ours = makeStamp("", "", "", "");
  const auto differs = [](const char* field, std::uint32_t theirs_value, std::uint32_t ours_value) {
    return std::string("plugin ABI mismatch: ") + field + " is " + std::to_string(theirs_value) +
           ", this program has " + std::to_string(ours_value);
  };
#define GRAFT_COMPARE(field) \
  if (theirs.field != ours.field) return differs(#field, theirs.field, ours.field)
  GRAFT_COMPARE(magic);
  GRAFT_COMPARE(abi_major);
  GRAFT_COMPARE(stamp_size);
  GRAFT_COMPARE(size_of_real);
  GRAFT_COMPARE(size_of_pointer);
  GRAFT_COMPARE(size_of_vertex_type);
  GRAFT_COMPARE(size_of_edge_type);
  // It grows at its end with minor versions.
  if (theirs.abi_minor >= ours.abi_minor || theirs.size_of_registrar > ours.size_of_registrar) {
    GRAFT_COMPARE(size_of_registrar);
  }
  GRAFT_COMPARE(sanitizers);
#undef GRAFT_COMPARE
  if (theirs.abi_minor > ours.abi_minor) {
    return differs("abi_minor", theirs.abi_minor, ours.abi_minor) + " (it is newer)";
  }
  const std::string missing = missingInstructions(theirs.isa);
  if (!missing.empty()) return "it needs a processor with " + missing + ", this one has not";
  return "";
}

PluginFile readPluginFile(const std::string& path) {
  const ElfFile elf(path);
  const std::optional<std::string> bytes = elf.section(GRAFT_STAMP_SECTION);
  const auto reject = [&path](const std::string& why) {
    throw Error(ExitCode::kPlugin, {path, 0, 0}, "not a plugin: " + why);
  };
  if (!bytes) reject(std::string("it has no section ") + GRAFT_STAMP_SECTION);
  PluginFile file;
  file.path = path;
  file.device = elf.device();
  file.inode = elf.inode();
  // A stamp of another size is still compared as far as it goes, so that the
  // message names the field.
  graft_abi_stamp stamp = {};
  std::memcpy(&stamp, bytes->data(), std::min(bytes->size(), sizeof stamp));
  if (stamp.magic != GRAFT_ABI_MAGIC) reject("its stamp has the wrong magic number");
  if (bytes->size() < sizeof stamp && stamp.stamp_size == sizeof stamp) {
    reject("its stamp is cut short");
  }
  file.refusal = stampMismatch(stamp);
  file.name = textOf(stamp.name);
  file.version = textOf(stamp.version);
  file.license = textOf(stamp.license);
  file.requires_plugins = words(textOf(stamp.requires_plugins));
  if (const std::optional<std::string> metadata = elf.section(GRAFT_METADATA_SECTION)) {
    file.has_metadata = true;
    file.provides = parseMetadata(*metadata);
  }
  if (file.refusal.empty() && elf.worldWritable()) {
    file.refusal = "anyone may change this file (mode o+w); it is not loaded";
  }
  if (file.refusal.empty() && anyoneMayReplace(path)) {
    file.refusal = "anyone may replace this file (its folder has mode o+w); it is not loaded";
  }
  return file;
}

}  // namespace graft
