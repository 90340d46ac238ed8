// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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
  double chi2_given = 0;  ///< at the values given; NaN where they have none
  std::vector<std::string> notes;
};

/// Makes the guess that the options ask for. Throws Error(kNoResult) where a guess that
/// was asked for by name cannot be made, with its reason.
Start chooseStart(const Problem& problem, const Linearizer& linearizer, ThreadPool& pool,
                  Registry& registry, const SolveOptions& options, const Values& given);

}  // namespace graft
