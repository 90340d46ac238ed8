// SPDX-License-Identifier: BSD-3-Clause
#include "core/plugin/process_state.hpp"

#include <dirent.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cfenv>
#include <clocale>
#include <cstdio>
#include <cstring>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace graft {

namespace {

constexpr int kLastSignal = 31;

std::string describeStream(int fd) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) return "closed";
  return std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino);
}

std::string describeHandler(int signal) {
  struct sigaction action {};
  if (::sigaction(signal, nullptr, &action) != 0) return "";
  char text[64];
  std::snprintf(text, sizeof text, "%p %d", reinterpret_cast<void*>(action.sa_handler),
                action.sa_flags);
  return text;
}

/// Rounding, exceptions unmasked, and whether tiny numbers are flushed to zero.
std::string describeFloatingPoint() {
  std::string text = std::to_string(std::fegetround());
#if defined(__SSE__)
  constexpr unsigned kControl = 0xffc0;  // the rest are flags of past operations
  text += " " + std::to_string(_mm_getcsr() & kControl);
#endif
  return text;
}

int countThreads() {
  int count = 0;
  DIR* folder = ::opendir("/proc/self/task");
  if (folder == nullptr) return 1;
  while (const dirent* entry = ::readdir(folder)) count += entry->d_name[0] != '.' ? 1 : 0;
  ::closedir(folder);
  return count;
}

}  // namespace

ProcessState::ProcessState() {
  const char* locale = std::setlocale(LC_ALL, nullptr);
  locale_ = locale != nullptr ? locale : "";
  char folder[4096];
  folder_ = ::getcwd(folder, sizeof folder) != nullptr ? folder : "";
  floating_point_ = describeFloatingPoint();
  const mode_t mask = ::umask(0);
  ::umask(mask);
  file_mode_mask_ = mask;
  for (int fd = 0; fd < 3; ++fd) streams_.push_back(describeStream(fd));
  for (int signal = 1; signal <= kLastSignal; ++signal) {
    handlers_.push_back(describeHandler(signal));
  }
  threads_ = countThreads() - 1;
}

std::vector<std::string> ProcessState::changes(const ProcessState& later) const {
  static const char* const kStreams[] = {"standard input", "standard output", "standard error"};
  std::vector<std::string> list;
  if (locale_ != later.locale_) list.emplace_back("the locale");
  if (folder_ != later.folder_) list.emplace_back("the working folder");
  if (floating_point_ != later.floating_point_) list.emplace_back("the floating-point mode");
  if (file_mode_mask_ != later.file_mode_mask_) list.emplace_back("the file mode mask");
  for (std::size_t i = 0; i < streams_.size(); ++i) {
    if (streams_[i] != later.streams_[i]) list.emplace_back(kStreams[i]);
  }
  for (std::size_t i = 0; i < handlers_.size(); ++i) {
    if (handlers_[i] != later.handlers_[i]) {
      list.push_back("the handler of signal " + std::to_string(i + 1));
    }
  }
  return list;
}

}  // namespace graft
