// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace graft {

class Descriptor;

/// A folder of outputs that appears as a whole: files are written to a hidden
/// staging folder beside the target, and commit() moves the top-level entries
/// into place (creating the target, replacing entries of the same name, leaving
/// others alone). Without commit() nothing of the target changes, nor where it fails; every
/// entry is the old or the new one at any moment (where the file system can exchange names,
/// as those of Linux do). What killed runs have left is removed by the next commit().
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
  /// Throws Error(kOutput); see above.
  void commit();

 private:
  std::vector<std::string> stagedNames() const;
  std::string target_;
  std::string staging_;
  std::vector<std::string> to_sync_;  ///< folders that have got a new folder
  std::unique_ptr<Descriptor> lock_;  ///< tells other runs that this one lives
  std::vector<std::string> replaced_;
  bool made_target_ = false;
  bool committed_ = false;
  bool keep_staging_ = false;  ///< it holds what could not be put back
};

}  // namespace graft
