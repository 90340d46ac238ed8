// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "types_lfd/learn/learn.hpp"

namespace graft::lfd {

/// A result as a report needs it, from the files of its folder alone: what was
/// matched and measured from graph.g2o, tracks, tables, grasp, models, weights.
/// Not restored: the graph's covariances beyond grasp.json, joint vectors' costs,
/// refinement per tuple.
struct RestoredResult {
  LearnResult result;
  std::vector<std::string> messages;  ///< what was said while it was learned
};

/// Throws Error(kInput) naming the file (and line) that is missing or not as
/// `learn` writes it, also where DIR holds no learned result but the folders of
/// several.
RestoredResult restoreResult(const std::string& directory);

}  // namespace graft::lfd
