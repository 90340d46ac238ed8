// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/solve/robust_edges.hpp"
#include "core/solve/weighted_rounds.hpp"

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
/// slow, for false edges fill the factor, and it gets lost where drift is large beside few
/// loops. So it begins with edges that agree (see Consensus), if the trusted ones determine
/// every vertex, or else with the start given. The sum of min(s, c2) tells which state is
/// best. At the best, single edges are tried on the other side (see Flips). Then there are
/// passes, each ending at the cost itself: the first begins with it, each further one ten
/// times smoother, from the best state so far, until smoothness as in the paper is reached.
/// They end earlier where false edges make a round's factor eight times as costly as that of
/// the kept edges, or, if there are no edges that agree to begin with, with three passes
/// without progress. A pass ends with rounds of truncated least squares proper until no edge
/// changes sides, for either kind. So what remains is plain least squares over the edges that
/// are kept, every one of which is within its threshold, and every one that is switched off
/// is not.
///
/// Information matrices often claim much more noise than there is, and then false edges
/// pass that everybody else would see. The a-posteriori variance factor (chi2 of the kept
/// edges over their redundancy) tells; where nine times that (thrice the deviation) is less
/// than 1, thresholds shrink by it, and the search is repeated where that changes them.
///
/// Trusted edges always have weight 1 and keep their robust kernels; those of the others
/// are left out, for graduation takes their place. Deterministic for any number of
/// threads and order of insertion.
class Graduated {
 public:
  using Tools = GraduationTools;

  /// Decides which edges are trusted. Throws Error(kUsage) for a tag of
  /// Graduation::trusted_tags that no edge has.
  Graduated(Problem& problem, const SolveOptions& options, GraduationReport& report)
      : options_(&options), report_(&report), edges_(problem, options.graduation, report) {
    report.kind = options.graduation.kind;
  }

  /// Gives weight 1 to the trusted edges and 0 to all others: for initial guesses.
  void trustOnly() { edges_.trustOnly(); }
  /// The sum of s over trusted edges and of min(s, c2) over all others: what starts are
  /// judged by.
  Evaluation truncatedCost(const Linearizer& linearizer, const State& state) const {
    return edges_.truncatedCost(linearizer, state);
  }

  /// Runs the rounds from a state and leaves their weights, each 0 or 1, in the problem
  /// and what was switched off in the report. Returns F at the new state, or why a
  /// round failed.
  Evaluation run(const Tools& tools, State& state);

 private:
  using Place = RobustEdges::Place;
  /// The best state so far, with weights settled there.
  struct Best {
    double cost = 0;
    double chi2 = 0;
    State state;
    RobustEdges::Numbers squares;
  };

  Evaluation begin(WeightedRounds& rounds, State& state);
  /// Passes from smoother and smoother costs; leaves the best state and its weights.
  Evaluation search(WeightedRounds& rounds, State& state);
  /// Rounds from one parameter to the cost itself.
  Evaluation pass(WeightedRounds& rounds, double parameter, State& state);

  const SolveOptions* options_;
  GraduationReport* report_;
  RobustEdges edges_;
  bool grown_ = false;       ///< whether the search begins with edges that agree
  bool too_smooth_ = false;  ///< the last pass ended at once, for its rounds cost too much
};

}  // namespace graft
