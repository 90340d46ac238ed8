// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/solve/problem.hpp"

namespace graft {

/// What a plugin's guess did.
struct PluginGuessResult {
  Values values;
  std::vector<VertexRef> placed;  ///< free vertices that it gave an estimate
  bool failed = false;            ///< it has no guess
  std::string reason;             ///< its own words why, maybe none
};

/// Runs a guess that a plugin provides from the state's estimates. Throws
/// Error(kPlugin) where it breaks its contract: an estimate that is not finite or that
/// its type refuses, a held vertex that was moved, a vertex written but not marked.
PluginGuessResult guessByPlugin(const Problem& problem, const State& state,
                                const graft_guess_type& type);

}  // namespace graft
