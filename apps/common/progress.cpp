// SPDX-License-Identifier: BSD-3-Clause
#include "apps/common/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace graft {

namespace {
constexpr int kWidth = 24;
}

ProgressBar::ProgressBar(std::string label, int total)
    : label_(std::move(label)), total_(std::max(total, 1)), active_(::isatty(2) == 1) {}

ProgressBar::~ProgressBar() {
  if (active_) std::fputs("\r\033[K", stderr);
}

void ProgressBar::update(int done, const std::string& text) {
  if (!active_) return;
  const int filled = std::clamp(done, 0, total_) * kWidth / total_;
  std::string bar(static_cast<std::size_t>(filled), '=');
  bar.resize(kWidth, ' ');
  std::fprintf(stderr, "\r%s [%s] %d/%d %s\033[K", label_.c_str(), bar.c_str(), done, total_,
               text.c_str());
  std::fflush(stderr);
}

}  // namespace graft
