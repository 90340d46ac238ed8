// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace graft {

/// Reads sections of a 64-bit ELF file by name without loading it, so that
/// nothing of the file runs. Every offset and size is checked against the file.
class ElfFile {
 public:
  /// Opens a shared library of this machine's kind. Throws Error(kPlugin) with
  /// "not a plugin: <reason>" for anything else.
  explicit ElfFile(const std::string& path);
  ~ElfFile();
  ElfFile(const ElfFile&) = delete;
  ElfFile& operator=(const ElfFile&) = delete;

  /// Bytes of the section; nothing where there is no such section.
  std::optional<std::string> section(const std::string& name) const;

  dev_t device() const { return device_; }
  ino_t inode() const { return inode_; }
  /// True where anyone may change the file.
  bool worldWritable() const { return world_writable_; }

 private:
  struct Section {
    std::string name;
    std::uint64_t offset;
    std::uint64_t size;
  };
  void open();
  void readSections();
  std::string read(std::uint64_t offset, std::uint64_t size, const char* what) const;
  [[noreturn]] void reject(const std::string& why) const;

  std::string path_;
  int fd_ = -1;
  std::uint64_t file_size_ = 0;
  dev_t device_ = 0;
  ino_t inode_ = 0;
  bool world_writable_ = false;
  std::vector<Section> sections_;
};

}  // namespace graft
