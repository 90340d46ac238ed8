// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/solve/options.hpp"
#include "core/solve/solve_context.hpp"

namespace graft {

/// What one iteration did.
struct StepResult {
  enum class Kind {
    kAccepted,  ///< the state has moved
    kRefused,   ///< it has not; the next iteration tries shorter steps
    kStuck,     ///< no step lowers chi2 by more than rounding
    kFailed
  };
  Kind kind = Kind::kRefused;
  double damping = 0;
  /// The step is that of the undamped model, so that a small change of chi2
  /// means convergence and not mere caution.
  bool full = false;
  std::string reason;  ///< kStuck, kFailed
};

/// How steps are found from the linear model. Keeps its damping or radius
/// between iterations. Every strategy only accepts steps that lower chi2.
class StepStrategy {
 public:
  static std::unique_ptr<StepStrategy> create(const SolveOptions& options);
  virtual ~StepStrategy() = default;
  /// Tries steps from the context's linear model until one is accepted, or a
  /// few were refused. The model is valid on entry.
  virtual StepResult iterate(SolveContext& context) = 0;
};

}  // namespace graft
