// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "core/types/abi.h"
#include "core/types/registry.hpp"

namespace graft {

/// What a plugin file says about itself; read without running anything of it.
struct PluginFile {
  std::string path;
  std::string name;
  std::string version;
  std::string license;
  std::vector<std::string> requires_plugins;
  std::vector<Provided> provides;  ///< from the metadata section
  bool has_metadata = false;
  dev_t device = 0;
  ino_t inode = 0;
  /// Empty, or why this program does not load it (incompatible stamp, missing
  /// processor features, a file that anyone may change).
  std::string refusal;
};

/// Reads stamp and metadata. Throws Error(kPlugin) with the path where the file
/// is no plugin at all; a plugin that does not fit comes with a `refusal`.
PluginFile readPluginFile(const std::string& path);

/// Why plugins of a folder from the environment are not used: anyone may write
/// it, or it belongs to somebody who is neither root nor the user. Empty = no
/// reason.
std::string folderRefusal(const std::string& folder);

/// Empty where a library with this stamp fits this program; else the first
/// field that does not, with both values.
std::string stampMismatch(const graft_abi_stamp& theirs);

/// Text of the metadata section: one line "kind name" per thing provided, with
/// kind one of vertex, edge, resource, kernel, solver, loader, guess.
std::string formatMetadata(const std::vector<Provided>& provides);
/// Reads it back; lines of unknown kind are left out.
std::vector<Provided> parseMetadata(const std::string& text);

/// "vertex", "edge", ...: the kind in metadata.
const char* metadataWord(Kind kind);

}  // namespace graft
