// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "core/base/error.hpp"

namespace graft {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kDeviceLimit = std::size_t{1} << 26;

[[noreturn]] void failInput(const std::string& path, const std::string& why) {
  throw Error(ExitCode::kInput, {path, 0, 0}, why);
}

[[noreturn]] void failOutput(const std::string& path, const std::string& why) {
  throw Error(ExitCode::kOutput, {path, 0, 0}, why);
}

/// A file descriptor that is closed on every way out.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ > 2) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  int release() {
    const int fd = fd_;
    fd_ = -1;
    return fd;
  }

 private:
  int fd_;
};

bool writeAll(int fd, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(fd, content.data(), content.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return false;
    }
    if (written == 0) {
      errno = ENOSPC;
      return false;
    }
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

std::string parentOf(const std::string& path) {
  const fs::path parent = fs::path(path).parent_path();
  return parent.empty() ? std::string(".") : parent.string();
}

bool isSpecialFile(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

int makeTemporary(const std::string& path, std::string& name) {
  name =
      parentOf(path) + "/.graft-" + fs::path(path).filename().string().substr(0, 200) + "-XXXXXX";
  const int fd = ::mkostemp(name.data(), O_CLOEXEC);
  if (fd < 0) failOutput(path, std::strerror(errno));
  return fd;
}

void syncFolder(const std::string& path) {
  const Descriptor folder(::open(parentOf(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.get() < 0 || (::fsync(folder.get()) != 0 && errno != EINVAL)) {
    failOutput(path,
               std::string("written, but durability is not confirmed: ") + std::strerror(errno));
  }
}

void writeDirectly(const std::string& path, int fd, std::string_view content) {
  if (!writeAll(fd, content))
    failOutput(path, std::string("write failed: ") + std::strerror(errno));
}

}  // namespace

std::string readFile(const std::string& path, std::size_t limit) {
  const bool standard_input = path == "-";
  const Descriptor file(standard_input ? 0 : ::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  const std::string name = standard_input ? "<stdin>" : path;
  if (file.get() < 0) failInput(name, std::strerror(errno));
  struct stat status {};
  if (::fstat(file.get(), &status) == 0 && S_ISDIR(status.st_mode)) {
    failInput(name, "is a directory, expected a file");
  }
  // A device may have no end (/dev/zero); files and pipes have one.
  if (S_ISCHR(status.st_mode)) limit = std::min(limit, kDeviceLimit);
  std::string content;
  std::size_t piece = std::size_t{1} << 20;
  if (S_ISREG(status.st_mode)) {
    // Most files are small; one byte more than there is tells the end.
    const std::size_t expected = static_cast<std::size_t>(status.st_size) + 1;
    content.reserve(expected);
    piece = std::clamp<std::size_t>(expected, 4096, piece);
  }
  std::string buffer(piece, '\0');
  for (;;) {
    const ssize_t count = ::read(file.get(), buffer.data(), buffer.size());
    if (count < 0) {
      if (errno == EINTR) continue;
      failInput(name, std::string("read failed: ") + std::strerror(errno));
    }
    if (count == 0) return content;
    content.append(buffer.data(), static_cast<std::size_t>(count));
    if (content.size() > limit) {
      throw Error(ExitCode::kResources, {name, 0, 0},
                  "larger than the limit of " + std::to_string(limit) + " bytes");
    }
  }
}

void writeFileAtomically(const std::string& path, std::string_view content) {
  if (path == "-") return writeDirectly("<stdout>", 1, content);
  if (isSpecialFile(path)) {
    const Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    if (file.get() < 0) failOutput(path, std::strerror(errno));
    return writeDirectly(path, file.get(), content);
  }
  std::string temporary;
  Descriptor file(makeTemporary(path, temporary));
  const auto fail = [&](const char* what) {
    const std::string why = std::strerror(errno);
    ::unlink(temporary.c_str());
    failOutput(path, std::string(what) + " failed: " + why + "; the previous file is kept");
  };
  // mkostemp makes the file private; give it what open() would have given.
  const mode_t mask = ::umask(0);
  ::umask(mask);
  struct stat old {};
  const mode_t mode = ::stat(path.c_str(), &old) == 0 && S_ISREG(old.st_mode) ? (old.st_mode & 0777)
                                                                              : (0666 & ~mask);
  if (::fchmod(file.get(), mode) != 0) fail("fchmod");
  if (!writeAll(file.get(), content)) fail("write");
  if (::fsync(file.get()) != 0) fail("fsync");
  if (::close(file.release()) != 0) fail("close");
  if (::rename(temporary.c_str(), path.c_str()) != 0) fail("rename");
  syncFolder(path);
}

void checkWritable(const std::string& path) {
  if (path == "-" || isSpecialFile(path)) return;
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode)) {
    failOutput(path, "is a directory");
  }
  std::string temporary;
  const Descriptor file(makeTemporary(path, temporary));
  ::unlink(temporary.c_str());
}

StagedDirectory::StagedDirectory(std::string target) : target_(std::move(target)) {
  while (target_.size() > 1 && target_.back() == '/') target_.pop_back();
  std::error_code error;
  made_target_ = !fs::exists(target_, error);
  fs::create_directories(target_, error);
  if (error) failOutput(target_, error.message());
  if (!fs::is_directory(target_)) failOutput(target_, "exists and is not a directory");
  staging_ = target_ + "/.graft-staging-XXXXXX";
  if (::mkdtemp(staging_.data()) == nullptr) failOutput(target_, std::strerror(errno));
}

StagedDirectory::~StagedDirectory() {
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
  if (made_target_ && !committed_) fs::remove(target_, ignored);
}

void StagedDirectory::write(const std::string& name, std::string_view content) {
  const fs::path path = fs::path(staging_) / name;
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) failOutput(target_ + "/" + name, error.message());
  const Descriptor file(
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666));
  if (file.get() < 0) failOutput(target_ + "/" + name, std::strerror(errno));
  if (!writeAll(file.get(), content) || ::fsync(file.get()) != 0) {
    failOutput(target_ + "/" + name, std::string("write failed: ") + std::strerror(errno) +
                                         "; the previous outputs are kept");
  }
}

void StagedDirectory::commit() {
  // Old entries go to a folder inside the staging area, so that a failed
  // rename can be noticed before anything is deleted for good.
  const fs::path old = fs::path(staging_) / ".replaced";
  std::error_code error;
  fs::create_directory(old, error);
  std::vector<fs::path> entries;
  for (const auto& entry : fs::directory_iterator(staging_)) {
    if (entry.path() != old) entries.push_back(entry.path());
  }
  const auto retire = [&](const fs::path& name) {
    const fs::path existing = fs::path(target_) / name;
    if (!fs::exists(fs::symlink_status(existing))) return;
    fs::rename(existing, old / name, error);
    if (error) failOutput(existing.string(), error.message());
  };
  for (const std::string& name : replaced_) retire(name);
  for (const fs::path& entry : entries) {
    retire(entry.filename());
    fs::rename(entry, fs::path(target_) / entry.filename(), error);
    if (error) failOutput((fs::path(target_) / entry.filename()).string(), error.message());
  }
  committed_ = true;
  syncFolder(target_ + "/.");
}

}  // namespace graft
