// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/linear/linear_solver.hpp"
#include "core/solve/normal_equations.hpp"
#include "core/solve/summary.hpp"

namespace graft {

/// Remembers what a linear solver analyzed last, by vertex ids, so that the next solve of
/// a graph that has hardly changed need not begin anew.
class PatternMemory {
 public:
  /// Makes the solver ready for the equations' pattern. Nothing is done where it is the
  /// one analyzed last; where vertices or edges came or went, the elimination order is
  /// kept, new vertices last, until a factorisation costs twice as much as it did when
  /// the order was found: then a new one is.
  SymbolicReuse analyze(const Problem& problem, const NormalEquations& equations,
                        LinearSolver& solver);
  /// The solver's state is no longer known, e.g. after an exception.
  void forget() { known_ = false; }

 private:
  bool sameAs(const graft_block_pattern& pattern, const std::vector<std::int64_t>& ids) const;
  void keep(const graft_block_pattern& pattern, std::vector<std::int64_t> ids);
  std::vector<std::int32_t> orderFor(const std::vector<std::int64_t>& ids) const;

  bool known_ = false;
  std::vector<std::int64_t> ids_;  ///< vertex id of every block, rising
  // A copy of the pattern, for solvers look at it as long as they use it.
  std::vector<std::int32_t> dims_;
  std::vector<std::int64_t> columns_;
  std::vector<std::int32_t> rows_;
  std::vector<std::int64_t> offsets_;
  graft_block_pattern pattern_ = {};
  std::vector<std::int64_t> order_;  ///< ids in the order of elimination
  double flops_when_ordered_ = 0;
};

}  // namespace graft
