// SPDX-License-Identifier: BSD-3-Clause
#include "core/plugin/elf_file.hpp"

#include <elf.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/base/error.hpp"

namespace graft {

namespace {

// A section that is read holds a stamp or a list of names; a table of sections
// of a real library has a few dozen entries.
constexpr std::uint64_t kSectionLimit = std::uint64_t{1} << 20;

#if defined(__x86_64__)
constexpr int kMachine = EM_X86_64;
#elif defined(__aarch64__)
constexpr int kMachine = EM_AARCH64;
#elif defined(__riscv)
constexpr int kMachine = EM_RISCV;
#elif defined(__powerpc64__)
constexpr int kMachine = EM_PPC64;
#else
constexpr int kMachine = -1;
#endif

}  // namespace

ElfFile::ElfFile(const std::string& path) : path_(path) {
  try {
    open();
    readSections();
  } catch (...) {
    if (fd_ >= 0) ::close(fd_);
    throw;
  }
}

ElfFile::~ElfFile() {
  if (fd_ >= 0) ::close(fd_);
}

void ElfFile::reject(const std::string& why) const {
  throw Error(ExitCode::kPlugin, {path_, 0, 0}, "not a plugin: " + why);
}

void ElfFile::open() {
  fd_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd_ < 0) {
    // That is not the file's fault, and to go on without it would blame others.
    if (errno == EMFILE || errno == ENFILE) {
      throw Error(ExitCode::kOutput, {path_, 0, 0},
                  std::string("cannot be opened: ") + std::strerror(errno));
    }
    reject(std::string("it cannot be opened: ") + std::strerror(errno));
  }
  struct stat status {};
  if (::fstat(fd_, &status) != 0) reject(std::strerror(errno));
  if (!S_ISREG(status.st_mode)) reject("it is no regular file");
  file_size_ = static_cast<std::uint64_t>(status.st_size);
  device_ = status.st_dev;
  inode_ = status.st_ino;
  world_writable_ = (status.st_mode & S_IWOTH) != 0;
}

std::string ElfFile::read(std::uint64_t offset, std::uint64_t size, const char* what) const {
  if (size > file_size_ || offset > file_size_ - size) {
    reject(std::string("truncated: ") + what + " lies behind the end of the file");
  }
  std::string bytes(static_cast<std::size_t>(size), '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got =
        ::pread(fd_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) reject(std::string("cannot read ") + what);
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

void ElfFile::readSections() {
  Elf64_Ehdr header;
  if (file_size_ < sizeof header) reject("it is no ELF file");
  std::memcpy(&header, read(0, sizeof header, "the header").data(), sizeof header);
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) reject("it is no ELF file");
  if (header.e_ident[EI_CLASS] != ELFCLASS64) reject("it is no 64-bit library");
  if (header.e_ident[EI_DATA] != ELFDATA2LSB) reject("it is for another byte order");
  if (header.e_type != ET_DYN) reject("it is no shared library");
  if (kMachine >= 0 && header.e_machine != kMachine) {
    reject("it is for another processor (ELF machine " + std::to_string(header.e_machine) +
           ", this program " + std::to_string(kMachine) + ")");
  }
  if (header.e_shnum == 0) return;
  if (header.e_shentsize != sizeof(Elf64_Shdr)) reject("its section table is malformed");
  const std::string table =
      read(header.e_shoff, std::uint64_t{header.e_shnum} * sizeof(Elf64_Shdr), "the section table");
  const auto entry = [&table](std::size_t i) {
    Elf64_Shdr section;
    std::memcpy(&section, table.data() + i * sizeof section, sizeof section);
    return section;
  };
  if (header.e_shstrndx >= header.e_shnum) reject("its section table is malformed");
  const Elf64_Shdr name_section = entry(header.e_shstrndx);
  if (name_section.sh_size > kSectionLimit) reject("its section names are too long");
  const std::string names = read(name_section.sh_offset, name_section.sh_size, "a section name");
  for (std::size_t i = 0; i < header.e_shnum; ++i) {
    const Elf64_Shdr section = entry(i);
    if (section.sh_name >= names.size() || section.sh_type == SHT_NOBITS) continue;
    sections_.push_back(
        {std::string(names.c_str() + section.sh_name), section.sh_offset, section.sh_size});
  }
}

std::optional<std::string> ElfFile::section(const std::string& name) const {
  for (const Section& section : sections_) {
    if (section.name != name) continue;
    if (section.size > kSectionLimit) reject("section " + name + " is too long");
    return read(section.offset, section.size, name.c_str());
  }
  return std::nullopt;
}

}  // namespace graft
