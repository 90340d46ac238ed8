// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace graft {

/// Reads a whole regular file (or "-" = standard input) into memory.
/// Throws Error(kInput) naming the path where it is missing, unreadable or a
/// directory, and Error(kResources) beyond `limit` bytes (64 MiB of a device).
std::string readFile(const std::string& path, std::size_t limit = std::size_t{1} << 36);

/// Writes `content` so that `path` holds either its old or its complete new
/// content at any moment: temporary file in the same folder, fsync, rename,
/// fsync of the folder. A symbolic link is replaced, never followed. Special
/// files (/dev/stdout, pipes) are written directly; "-" is standard output.
/// Throws Error(kOutput) with the system's reason; the old file is then intact.
void writeFileAtomically(const std::string& path, std::string_view content);

/// Throws Error(kOutput) unless `path` can be created or replaced; call it
/// before long work so that a typo does not cost the result.
void checkWritable(const std::string& path);

/// A folder of outputs that appears as a whole: files are written to a hidden
/// staging folder beside the target, and commit() moves the top-level entries
/// into place (creating the target, replacing entries of the same name, leaving
/// others alone). Without commit() nothing of the target changes.
class StagedDirectory {
 public:
  /// Throws Error(kOutput) where the target cannot be created or written.
  explicit StagedDirectory(std::string target);
  ~StagedDirectory();
  StagedDirectory(const StagedDirectory&) = delete;
  StagedDirectory& operator=(const StagedDirectory&) = delete;

  /// Writes one file; `name` is relative to the target, folders are made.
  void write(const std::string& name, std::string_view content);
  /// Path of the staging folder, for writers that need a real file name.
  const std::string& stagingPath() const { return staging_; }
  /// Top-level entries of an earlier run that commit() deletes if this run did
  /// not write them, so that two runs never mix.
  void replaces(std::vector<std::string> entries) { replaced_ = std::move(entries); }
  void commit();

 private:
  std::string target_;
  std::string staging_;
  std::vector<std::string> replaced_;
  bool made_target_ = false;
  bool committed_ = false;
};

}  // namespace graft
