// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/linear/linear_solver.hpp"
#include "core/solve/robust_edges.hpp"
#include "core/solve/solve_context.hpp"

namespace graft {

/// What a solve lends to graduation.
struct GraduationTools {
  const Linearizer& linearizer;
  LinearSolver& solver;
  PatternMemory& memory;
  ThreadPool& pool;
  std::map<std::string, double>& seconds;  ///< by phase
  std::function<bool()> must_stop;         ///< true once the solve has to end early
};

/// The rounds of graduation: weighted least squares, begun where the last one ended.
class WeightedRounds {
 public:
  WeightedRounds(RobustEdges& edges, const SolveOptions& options, const GraduationTools& tools,
                 GraduationReport& report)
      : edges_(&edges), options_(&options), tools_(tools), report_(&report) {}

  /// A few iterations (the cost changes anyway before the next round), as many as bring
  /// something, or the minimum.
  enum class Effort { kRough, kFair, kExact };
  /// Minimises with the weights as they are and keeps the squared errors at the new state.
  /// Returns F there, or why it failed.
  Evaluation run(Effort effort, State& state);
  /// Rounds of truncated least squares proper (weight 1 where s <= c2, else 0) until no
  /// edge changes sides, from the weights as they are.
  Evaluation settle(State& state);
  /// From now on, rough rounds have more iterations, and those that settle are exact: where
  /// the state may be far from the one sought, following the weights closely pays.
  void setCareful(bool careful) { careful_ = careful; }
  /// From now on, rounds do nothing where a factorisation is predicted to cost more than
  /// so many times what it did in the last round; 0 = no limit.
  void limitCost(double factor);
  /// Not where the linear solver does not predict what it costs.
  bool isLimited() const { return most_flops_ > 0; }
  /// Whether the last round was one of those.
  bool wasTooCostly() const { return too_costly_; }
  /// Whether some weight is other by more than `least` than in the last round.
  bool weightsDiffer(double least) const;

  const GraduationTools& tools() const { return tools_; }

 private:
  RobustEdges* edges_;
  const SolveOptions* options_;
  GraduationTools tools_;
  GraduationReport* report_;
  RobustEdges::Numbers weights_;  ///< in the last round
  bool careful_ = false;
  double most_flops_ = 0;  ///< 0 = no limit
  bool too_costly_ = false;
};

}  // namespace graft
