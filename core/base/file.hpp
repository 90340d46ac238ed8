// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace graft {

/// Reads a whole regular file (or "-" = standard input) into memory.
/// Throws Error(kInput) naming the path where it is missing, unreadable or a
/// directory, Error(kResources) beyond `limit` bytes (64 MiB of a device), and
/// Error(kOutput) where no more files can be open.
std::string readFile(const std::string& path, std::size_t limit = std::size_t{1} << 36);

/// Writes `content` so that `path` holds either its old or its complete new
/// content at any moment: temporary file in the same folder, fsync, rename,
/// fsync of the folder. A symbolic link is replaced, never followed. Special
/// files (/dev/stdout, pipes) are written directly; "-" is standard output.
/// Temporary files that killed runs have left for the same path are removed.
/// Throws Error(kOutput) with the system's reason; the old file is then intact (or, if the
/// text says so, the new one is complete but may not be on the disk yet).
void writeFileAtomically(const std::string& path, std::string_view content);

/// Throws Error(kOutput) unless `path` can be created or replaced; call it
/// before long work so that a typo does not cost the result.
void checkWritable(const std::string& path);

}  // namespace graft
