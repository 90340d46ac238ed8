// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace graft {

/// One line on standard error that is rewritten in place; silent unless that is
/// a terminal. The line is wiped at the end.
class ProgressBar {
 public:
  ProgressBar(std::string label, int total);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void update(int done, const std::string& text);

 private:
  std::string label_;
  int total_;
  bool active_;
};

}  // namespace graft
