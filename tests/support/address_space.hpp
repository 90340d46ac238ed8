// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

#include "core/types/stamp.hpp"

namespace graft::testing {

/// Leaves the process so many bytes of address space while it lives.
class AddressSpaceLimit {
 public:
  explicit AddressSpaceLimit(double bytes) {
    getrlimit(RLIMIT_AS, &before_);
    double pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    rlimit limit = before_;
    limit.rlim_cur = rlim_t(pages * double(sysconf(_SC_PAGESIZE)) + bytes);
    setrlimit(RLIMIT_AS, &limit);
  }
  ~AddressSpaceLimit() { setrlimit(RLIMIT_AS, &before_); }
  AddressSpaceLimit(const AddressSpaceLimit&) = delete;
  AddressSpaceLimit& operator=(const AddressSpaceLimit&) = delete;

 private:
  rlimit before_ = {};
};

}  // namespace graft::testing

// Sanitizers map terabytes, which leaves nothing to limit.
#define GRAFT_REQUIRE_LIMITS() \
  if (::graft::detail::sanitizerBits() != 0) GTEST_SKIP() << "address space cannot be limited"
