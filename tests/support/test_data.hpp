// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace graft::testing {

/// Path of a file or folder of the shared evaluation data ($GRAFT_DATA, else a
/// folder beside the checkout).
std::string dataPath(const std::string& relative);
bool dataExists(const std::string& relative);

/// Build folder of this build: programs in bin, plugins in lib/graft/plugins.
std::string binaryDirectory();

/// An empty folder of its own for each call, deleted at the end of the process.
std::string makeTemporaryDirectory();

/// Writes a small file and returns its path.
std::string writeTestFile(const std::string& directory, const std::string& name,
                          const std::string& content);
std::string readTestFile(const std::string& path);

/// What a command did.
struct CommandResult {
  int exit_code = -1;
  std::string out;
  std::string err;
};
/// Runs a shell command line and captures both streams.
CommandResult runCommand(const std::string& command);

}  // namespace graft::testing

/// Skips the test, visibly, where the shared data is not there.
#define GRAFT_REQUIRE_DATA(relative)                                          \
  if (!::graft::testing::dataExists(relative)) {                              \
    GTEST_SKIP() << "needs " << ::graft::testing::dataPath(relative)          \
                 << " (set GRAFT_DATA to the folder of the evaluation data)"; \
  }
