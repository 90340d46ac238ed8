// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "core/solve/linearizer.hpp"
#include "core/solve/summary.hpp"
#include "core/types/registry.hpp"

namespace graft {

/// The state that iterations begin with.
struct Start {
  StartKind kind = StartKind::kGiven;
  std::string name;  ///< of the guess, if a plugin's
  State state;
  Evaluation evaluation;
  std::vector<std::string> notes;
};

/// What a guess is made from.
struct StartTools {
  const Problem& problem;
  const Linearizer& linearizer;
  ThreadPool& pool;
  Registry& registry;
  const SolveOptions& options;
  /// What starts are judged by; none = F.
  std::function<Evaluation(const State&)> cost = {};
};

/// Makes the guess that the options ask for. `given`: the state of the values given and
/// its cost. Throws Error(kNoResult) where a guess that was asked for by name cannot be
/// made, with its reason.
Start chooseStart(const StartTools& tools, State given, Evaluation evaluation);

}  // namespace graft
