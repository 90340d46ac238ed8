// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace graft {

/// A file descriptor that is closed on every way out (standard streams are not).
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor();
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

[[noreturn]] void failOutput(const std::string& path, const std::string& why);

/// The folder of a path, "." where it names none.
std::string parentOf(const std::string& path);

/// False with errno where not everything could be written.
bool writeAll(int fd, std::string_view content);

/// fsync of a folder; false with errno. Where a file system has none, that is success.
bool syncFolder(const std::string& folder);

/// A new file beside `path`, of hidden name, locked as long as a descriptor of it is open:
/// files of that kind without a lock are of runs that were killed, and are removed first.
/// Throws Error(kOutput).
int makeTemporary(const std::string& path, std::string& name);

/// The same for a new folder inside `folder`; `name` receives its path. Does not remove any.
int makeTemporaryFolder(const std::string& folder, std::string& name);

/// Removes the folders of that kind that killed runs have left; errors are ignored.
void removeStaleFolders(const std::string& folder);

}  // namespace graft
