// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <set>
#include <utility>

#include "core/linear/linear_solver.hpp"
#include "core/solve/linearizer.hpp"
#include "core/solve/solve_context.hpp"
#include "core/solve/summary.hpp"

namespace graft {

/// Graduated non-convexity: finds the edges that contradict the others, and switches
/// them off (Yang, Antonante, Tzoumas, Carlone, "Graduated Non-Convexity for Robust
/// Spatial Perception: From Non-Minimal Solvers to Global Outlier Rejection", RA-L 2020).
///
/// With the squared whitened error s of an edge and its threshold c2 (the quantile of
/// chi-square with the rank of its information matrix) the cost min(s, c2) of truncated
/// least squares, or c2 s / (c2 + s) of Geman and McClure, is reached through a sequence
/// of smoother ones: rounds of weighted least squares whose weights follow from the
/// errors of the round before (equations 12 and 14), under a parameter mu that makes the
/// cost steeper each time by 1.4.
///
/// The paper begins where the cost is nearly convex. From a start by odometry that is
/// slow, and it gets lost where drift is large beside few loops. So there are several
/// passes, each ending at the cost itself: the first begins with it, each further one ten
/// times smoother, from the best state so far, until smoothness as in the paper
/// is reached or three passes have brought no progress. A pass ends with rounds of
/// truncated least squares proper (weight 1 where s <= c2, else 0) until no edge changes
/// sides, for either kind; the sum of min(s, c2) tells which state is best. At the best,
/// the edges with the largest errors are tried without, and then those that are off by
/// little with. So what
/// remains is plain least squares over the edges that are kept, every one of which is
/// within its threshold, and every one that is switched off is not.
///
/// Information matrices often claim much more noise than there is, and then false edges
/// pass that everybody else would see. The a-posteriori variance factor (chi2 of the kept
/// edges over their redundancy) tells; where nine times that (thrice the deviation) is less
/// than 1, thresholds shrink by it and the passes are repeated. Thresholds never grow.
///
/// Trusted edges always have weight 1 and keep their robust kernels; those of the others
/// are left out, for graduation takes their place. Deterministic for any number of
/// threads and order of insertion.
class Graduated {
 public:
  /// Decides which edges are trusted. Throws Error(kUsage) for a tag of
  /// Graduation::trusted_tags that no edge has.
  Graduated(Problem& problem, const SolveOptions& options, GraduationReport& report);

  /// Gives weight 1 to the trusted edges and 0 to all others: for initial guesses.
  void trustOnly();
  /// The sum of s over trusted edges and of min(s, c2) over all others: what starts are
  /// judged by.
  Evaluation truncatedCost(const Linearizer& linearizer, const State& state) const;

  /// What a solve lends.
  struct Tools {
    const Linearizer& linearizer;
    LinearSolver& solver;
    PatternMemory& memory;
    ThreadPool& pool;
    std::map<std::string, double>& seconds;  ///< by phase
    std::function<bool()> must_stop;         ///< true once the solve has to end early
  };
  /// Runs the rounds from a state and leaves their weights, each 0 or 1, in the problem
  /// and what was switched off in the report. Returns F at the new state, or why a
  /// round failed.
  Evaluation run(const Tools& tools, State& state);

 private:
  bool isTrusted(const EdgeGroup& group, std::int64_t edge) const;
  void findCandidates();
  void findFreedoms();
  void findThresholds();
  /// Passes from smoother and smoother costs; leaves the best state and its weights.
  Evaluation search(const Tools& tools, State& state);
  /// Rounds from one parameter to the cost itself.
  Evaluation pass(const Tools& tools, double parameter, State& state);
  /// Rounds of truncated least squares proper until no edge changes sides.
  Evaluation settle(const Tools& tools, State& state);
  /// Tries to do without single edges that are kept, those with the largest errors first,
  /// or with single ones that are not, those with the smallest first, and lets be what
  /// lowers the cost. An edge that is hardly checked by others pulls the estimates to
  /// itself: false, it is kept with a small error; true, it is missed with a large one.
  Evaluation flipSuspects(const Tools& tools, bool kept, State& state);
  using Place = std::pair<std::size_t, std::size_t>;  ///< group and edge
  bool findSuspect(bool kept, const std::set<Place>& known, Place& suspect) const;
  /// Weighted least squares, roughly or exactly; keeps the squared errors.
  Evaluation round(const Tools& tools, bool exact, State& state);
  /// Whether other edges than in the last round have a weight above 0.
  bool edgesHaveChanged();
  /// Lowers the thresholds to the noise that the kept edges show; whether it did.
  bool fitNoise(double kept);
  /// Sum of min(s, c2) if the kept edges' F is `kept`.
  double truncatedCost(double kept) const;
  /// Where the cost is nearly convex: remark 5 of the paper, at the last errors.
  double smoothestParameter() const;
  double weightOf(double square, double threshold, double parameter) const;
  /// Weights from the last squared errors; returns whether all are 0 or 1 (nearly).
  bool setWeights(double parameter);
  /// The same for truncated least squares proper; returns whether any has changed.
  bool setSides();
  void fillReport();

  Problem* problem_;
  const SolveOptions* options_;
  GraduationReport* report_;
  std::vector<std::vector<std::int64_t>> ranks_;  ///< of a vertex among those of its type
  std::vector<std::vector<char>> candidates_;     ///< per group and edge: not trusted
  std::vector<std::vector<int>> freedoms_;        ///< per group and edge: rank of its information
  std::vector<std::vector<double>> thresholds_;   ///< per group and edge
  std::vector<char> active_;                      ///< weight above 0 in the last round
  std::vector<std::vector<double>> squares_;      ///< per group and edge, last errors
};

}  // namespace graft
