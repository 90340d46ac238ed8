// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tests/support/test_data.hpp"

namespace graft::testing {

/// Runs graft-lfd with reachability maps cached in the build folder, so that
/// each robot's is built once for all tests.
inline CommandResult graftLfd(const std::string& arguments) {
  return runCommand("GRAFT_CACHE_DIR=" + binaryDirectory() + "/tests/cache " + binaryDirectory() +
                    "/bin/graft-lfd " + arguments);
}
inline CommandResult graftProgram(const std::string& arguments) {
  return runCommand("GRAFT_CACHE_DIR=" + binaryDirectory() + "/tests/cache " + binaryDirectory() +
                    "/bin/graft " + arguments);
}

}  // namespace graft::testing
