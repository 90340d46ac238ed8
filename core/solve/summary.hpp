// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/solve/options.hpp"

namespace graft {

/// What the caller holds after a solve. On kFailed the values are those before
/// the call; on every other status they are the best accepted ones.
enum class Status { kConverged, kIterationLimit, kTimeLimit, kInterrupted, kFailed };

/// "converged", "iteration_limit", "time_limit", "interrupted", "failed".
const char* statusName(Status status);

/// Where the iterations began: the values given, or a guess.
enum class StartKind { kGiven, kSpanningTree, kChordal, kPlugin };

/// What was kept of the symbolic analysis of an earlier solve.
enum class SymbolicReuse { kNothing, kOrdering, kEverything };

/// An edge that graduation switched off.
struct SwitchedOff {
  std::string tag;
  std::vector<std::int64_t> ids;
  std::int64_t line = 0;  ///< of the file, 0 = none
  std::size_t block = 0;  ///< of Graph::edgeBlocks()
  std::size_t edge = 0;   ///< place in that block
  double weight = 0;      ///< in the final solve
  double square = 0;      ///< its squared error e' Omega e at the result
  double threshold = 0;   ///< above which it counts as an outlier
};

/// What graduation did, see SolveOptions::graduation.
struct GraduationReport {
  RobustEstimation kind = RobustEstimation::kNone;
  std::int64_t candidates = 0;  ///< edges that might have been switched off
  std::int64_t kernels_left_out = 0;
  double noise_factor = 1;  ///< of the chi-square thresholds
  int passes = 0;
  int rounds = 0;
  int iterations = 0;  ///< of all rounds; those of the final solve are not among them
  std::vector<SwitchedOff> off;
};

struct Summary {
  Status status = Status::kFailed;
  std::string reason;
  double chi2_initial = 0;  ///< at the values given
  double chi2_start = 0;    ///< after the initial guess; what graduation minimises if it runs
  double chi2_final = 0;
  StartKind start = StartKind::kGiven;      ///< which guess the iterations began with
  std::string start_name;                   ///< of the guess, if a plugin's
  std::vector<IterationRecord> iterations;  ///< iterations.size() - 1 were made
  std::int64_t associations_changed = 0;
  std::size_t inner_parts = 0;  ///< that were solved by themselves after every step
  int alternatives_tried = 0;   ///< other choices of edges that list theirs
  int alternatives_taken = 0;   ///< that led to a lower chi2
  /// Vertices that were held fixed because their component had no anchor, and
  /// other remarks a user should read; one text each.
  std::vector<std::string> notes;
  std::string linear_solver;
  std::string ordering;     ///< see Ordering::name; chosen by the predicted flops
  double factor_flops = 0;  ///< predicted, one factorisation
  double factor_bytes = 0;  ///< of the factor and what its computation needs
  SymbolicReuse symbolic_reuse = SymbolicReuse::kNothing;
  int threads = 1;
  double seconds_guess = 0;
  double seconds_solve = 0;
  /// Seconds by phase: analyze, linearize, factorize, solve, update, inner, associate,
  /// evaluate.
  std::map<std::string, double> seconds_by_phase;
  std::map<std::string, double> chi2_by_tag;  ///< at the final values
  GraduationReport graduation;

  bool usable() const { return status != Status::kFailed; }
  int iterationCount() const { return iterations.empty() ? 0 : int(iterations.size()) - 1; }
};

}  // namespace graft
