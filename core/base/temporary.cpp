// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/temporary.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>

#include "core/base/error.hpp"

namespace graft {

namespace fs = std::filesystem;

namespace {

constexpr const char* kPattern = "XXXXXX";
constexpr std::size_t kPatternSize = 6;
constexpr const char* kStaging = ".graft-staging-";

/// Whether an open entry is a file (or folder) of ours that no process held; it is held
/// from then on.
bool isStale(int entry, const std::string& path, mode_t kind) {
  struct stat opened {};
  struct stat named {};
  return entry >= 0 && ::fstat(entry, &opened) == 0 && (opened.st_mode & S_IFMT) == kind &&
         opened.st_uid == ::geteuid() && ::flock(entry, LOCK_EX | LOCK_NB) == 0 &&
         ::lstat(path.c_str(), &named) == 0 && named.st_dev == opened.st_dev &&
         named.st_ino == opened.st_ino;
}

/// Calls remove(path) for the stale entries of a folder. Each is held meanwhile: who has
/// just made one and waits for its lock finds it gone, and makes another.
template <class Remove>
void removeStale(const std::string& folder, const std::string& head, mode_t kind,
                 const Remove& remove) {
  const std::unique_ptr<DIR, int (*)(DIR*)> stream(::opendir(folder.c_str()), &::closedir);
  if (!stream) return;
  while (const dirent* entry = ::readdir(stream.get())) {
    const std::string name = entry->d_name;
    if (name.size() != head.size() + kPatternSize || name.compare(0, head.size(), head) != 0) {
      continue;
    }
    const std::string path = fs::path(folder) / name;
    const Descriptor opened(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    if (isStale(opened.get(), path, kind)) remove(path);
  }
}

/// Locks what was just made. False if another run took it for stale before that.
bool lock(int fd) {
  // A file system without locks has no stale entries removed either.
  while (::flock(fd, LOCK_EX) != 0 && errno == EINTR) continue;
  struct stat status {};
  return ::fstat(fd, &status) == 0 && status.st_nlink > 0;
}

}  // namespace

Descriptor::~Descriptor() {
  if (fd_ > 2) ::close(fd_);
}

void failOutput(const std::string& path, const std::string& why) {
  throw Error(ExitCode::kOutput, {path, 0, 0}, why);
}

std::string parentOf(const std::string& path) {
  const fs::path parent = fs::path(path).parent_path();
  return parent.empty() ? std::string(".") : parent.string();
}

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

bool syncFolder(const std::string& folder) {
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return opened.get() >= 0 && (::fsync(opened.get()) == 0 || errno == EINVAL);
}

int makeTemporary(const std::string& path, std::string& name) {
  const std::string head = ".graft-" + fs::path(path).filename().string().substr(0, 200) + "-";
  const std::string folder = parentOf(path);
  removeStale(folder, head, S_IFREG, [](const std::string& stale) { ::unlink(stale.c_str()); });
  const std::string pattern = folder + "/" + head + kPattern;
  for (;;) {
    name = pattern;
    const int fd = ::mkostemp(name.data(), O_CLOEXEC);
    if (fd < 0) failOutput(path, std::strerror(errno));
    if (lock(fd)) return fd;
    ::close(fd);
  }
}

int makeTemporaryFolder(const std::string& folder, std::string& name) {
  for (;;) {
    name = folder + "/" + kStaging + kPattern;
    if (::mkdtemp(name.data()) == nullptr) failOutput(folder, std::strerror(errno));
    const int fd = ::open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0 && lock(fd)) return fd;
    const int why = errno;
    if (fd >= 0) {
      ::close(fd);
      continue;
    }
    ::rmdir(name.c_str());
    if (why != ENOENT) failOutput(folder, std::strerror(why));
  }
}

void removeStaleFolders(const std::string& folder) {
  std::error_code ignored;
  removeStale(folder, kStaging, S_IFDIR,
              [&](const std::string& stale) { fs::remove_all(stale, ignored); });
}

}  // namespace graft
