// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace graft {

/// What a library must leave alone: it belongs to the whole process.
class ProcessState {
 public:
  /// As it is now.
  ProcessState();

  /// What differs in `later`, in words: "the locale", "the floating-point mode",
  /// "the handler of signal 15", ...
  std::vector<std::string> changes(const ProcessState& later) const;
  /// Threads that run beside the caller's.
  int threads() const { return threads_; }

 private:
  std::string locale_;
  std::string folder_;
  std::string floating_point_;
  unsigned file_mode_mask_ = 0;
  std::vector<std::string> streams_;
  std::vector<std::string> handlers_;
  int threads_ = 0;
};

}  // namespace graft
