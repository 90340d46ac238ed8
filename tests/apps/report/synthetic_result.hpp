// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "types_lfd/learn/learn.hpp"

namespace graft::report::testing {

struct ResultOptions {
  std::string task = "drawer";
  std::string demo_prefix = "demo_";
  int demonstrations = 3;
  bool map = true;
  bool snapshots = true;
  bool torso_estimated = false;
  bool common_grasp = true;
  bool left_out = false;  ///< one more demonstration that holds the object elsewhere
};

/// A result as learn() would give it, made up here: hands that reach for a
/// handle, pull it back by 30 cm and let go, a small robot, a room with a wall,
/// and numbers that are all different. No solver is run.
lfd::LearnResult syntheticResult(const ResultOptions& options = ResultOptions());

}  // namespace graft::report::testing
