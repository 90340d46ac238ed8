// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/parallel.hpp"
#include "core/types/registry.hpp"

namespace graft {

/// Outcome of a factorisation or solution.
struct LinearOutcome {
  bool ok = true;
  std::int32_t failed_block = -1;  ///< not positive definite there, if known
  std::string message;
};

/// Solves (A + diag(damping)) x = b for a symmetric positive definite block
/// matrix; see graft_solver_type for layouts.
class LinearSolver {
 public:
  /// "block" is built in, other names come from the registry. Throws
  /// Error(kUsage) if there is no such solver.
  static std::unique_ptr<LinearSolver> create(const std::string& name, Registry& registry,
                                              ThreadPool& pool);
  virtual ~LinearSolver() = default;

  /// Symbolic work; `pattern` must outlive the solver's use. `order`, if not empty, is
  /// an elimination order (position -> block) to take instead of finding one; solvers
  /// may ignore it. Throws Error(kNoResult) where memory will not suffice, Error(kResources)
  /// where it did not, or Error(kPlugin).
  virtual void analyze(const graft_block_pattern& pattern,
                       const std::vector<std::int32_t>& order = {}) = 0;
  virtual LinearOutcome factorize(const double* values, const double* damping) = 0;
  virtual LinearOutcome solve(const double* b, double* x) = 0;
  virtual std::string ordering() const { return {}; }
  virtual double flops() const { return 0; }
  /// What the factor takes; 0 if the solver does not tell.
  virtual double bytes() const { return 0; }
  /// The elimination order in use (position -> block); null if the solver does not tell.
  virtual const std::vector<std::int32_t>* order() const { return nullptr; }
};

}  // namespace graft
