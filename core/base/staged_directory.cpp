// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/staged_directory.hpp"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/base/error.hpp"
#include "core/base/temporary.hpp"

namespace graft {

namespace fs = std::filesystem;

namespace {

/// Renames that can be taken back.
class Moves {
 public:
  /// `staged` gets the name `target`; what has it now, gets the other. False with errno.
  bool place(const fs::path& staged, const fs::path& target) {
    if (!fs::exists(fs::symlink_status(target))) return move(staged, target);
    if (::renameat2(AT_FDCWD, staged.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) == 0) {
      done_.push_back({staged, target, true});
      return true;
    }
    if (errno != EINVAL && errno != ENOSYS) return false;
    // A file system that cannot exchange.
    const fs::path aside = staged.string() + ".old";
    return move(target, aside) && move(staged, target);
  }
  bool move(const fs::path& from, const fs::path& to) {
    if (::rename(from.c_str(), to.c_str()) != 0) return false;
    done_.push_back({from, to, false});
    return true;
  }
  /// False if anything could not be put back.
  bool undo() {
    bool good = true;
    for (; !done_.empty(); done_.pop_back()) {
      const Move& last = done_.back();
      const int status = last.exchanged ? ::renameat2(AT_FDCWD, last.from.c_str(), AT_FDCWD,
                                                      last.to.c_str(), RENAME_EXCHANGE)
                                        : ::rename(last.to.c_str(), last.from.c_str());
      good = good && status == 0;
    }
    return good;
  }

 private:
  struct Move {
    fs::path from;
    fs::path to;
    bool exchanged;
  };
  std::vector<Move> done_;
};

/// fsync of a folder and of those in it: what is renamed must not lose its own entries.
bool syncTree(const std::string& folder) {
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
    if (entry.is_directory(error) && !entry.is_symlink(error) && !syncFolder(entry.path())) {
      return false;
    }
  }
  return !error && syncFolder(folder);
}

}  // namespace

StagedDirectory::StagedDirectory(std::string target) : target_(std::move(target)) {
  while (target_.size() > 1 && target_.back() == '/') target_.pop_back();
  std::error_code error;
  made_target_ = !fs::exists(target_, error);
  for (std::string folder = target_; !fs::exists(folder, error);) {
    folder = parentOf(folder);
    to_sync_.push_back(folder);
  }
  fs::create_directories(target_, error);
  if (error) failOutput(target_, error.message());
  if (!fs::is_directory(target_, error)) {
    failOutput(target_, "exists and is not a directory");
  }
  lock_ = std::make_unique<Descriptor>(makeTemporaryFolder(target_, staging_));
}

StagedDirectory::~StagedDirectory() {
  std::error_code ignored;
  if (!keep_staging_) fs::remove_all(staging_, ignored);
  if (made_target_ && !committed_) fs::remove(target_, ignored);
}

void StagedDirectory::write(const std::string& name, std::string_view content) {
  const fs::path path = fs::path(staging_) / name;
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) failOutput(target_ + "/" + name, error.message());
  Descriptor file(
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666));
  if (file.get() < 0) failOutput(target_ + "/" + name, std::strerror(errno));
  if (!writeAll(file.get(), content) || ::fsync(file.get()) != 0 || ::close(file.release()) != 0) {
    failOutput(target_ + "/" + name, std::string("write failed: ") + std::strerror(errno) +
                                         "; the previous outputs are kept");
  }
}

std::vector<std::string> StagedDirectory::stagedNames() const {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(staging_, error)) {
    names.push_back(entry.path().filename().string());
  }
  if (error) failOutput(target_, error.message() + "; the previous outputs are kept");
  std::sort(names.begin(), names.end());
  return names;
}

void StagedDirectory::commit() {
  const std::vector<std::string> names = stagedNames();
  Moves moves;
  const auto fail = [&](const fs::path& what) {
    const std::string why = std::strerror(errno);
    keep_staging_ = !moves.undo();
    failOutput(
        what.string(),
        why + (keep_staging_ ? "; previous outputs that could not be put back are in " + staging_
                             : std::string("; the previous outputs are kept")));
  };
  if (!syncTree(staging_)) fail(target_);
  for (const std::string& name : names) {
    const fs::path target = fs::path(target_) / name;
    if (!moves.place(fs::path(staging_) / name, target)) fail(target);
  }
  for (const std::string& name : replaced_) {
    const fs::path target = fs::path(target_) / name;
    if (std::binary_search(names.begin(), names.end(), name)) continue;
    if (!fs::exists(fs::symlink_status(target))) continue;
    if (!moves.move(target, fs::path(staging_) / name)) fail(target);
  }
  committed_ = true;
  to_sync_.push_back(target_);
  for (const std::string& folder : to_sync_) {
    if (syncFolder(folder)) continue;
    failOutput(target_,
               std::string("written, but durability is not confirmed: ") + std::strerror(errno));
  }
  removeStaleFolders(target_);
}

}  // namespace graft
