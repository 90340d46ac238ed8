// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/base/error.hpp"
#include "core/base/temporary.hpp"

namespace graft {

namespace {

constexpr std::size_t kDeviceLimit = std::size_t{1} << 26;

[[noreturn]] void failInput(const std::string& path, const std::string& why) {
  throw Error(ExitCode::kInput, {path, 0, 0}, why);
}

bool isSpecialFile(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
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
  if (file.get() < 0) {
    // That is not the file's fault.
    if (errno == EMFILE || errno == ENFILE) failOutput(name, std::strerror(errno));
    failInput(name, std::strerror(errno));
  }
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
  // Holds the lock that tells other runs to leave the file alone until it has its name.
  const Descriptor lock(::fcntl(file.get(), F_DUPFD_CLOEXEC, 3));
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
  if (lock.get() < 0) fail("dup");
  if (::fchmod(file.get(), mode) != 0) fail("fchmod");
  if (!writeAll(file.get(), content)) fail("write");
  if (::fsync(file.get()) != 0) fail("fsync");
  if (::close(file.release()) != 0) fail("close");
  if (::rename(temporary.c_str(), path.c_str()) != 0) fail("rename");
  if (!syncFolder(parentOf(path))) {
    failOutput(path,
               std::string("written, but durability is not confirmed: ") + std::strerror(errno));
  }
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

}  // namespace graft
