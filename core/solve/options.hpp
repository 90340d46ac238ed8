// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/graph/information_policy.hpp"
#include "core/graph/values.hpp"

namespace graft {

enum class Algorithm { kLevenbergMarquardt, kGaussNewton, kDogleg };
enum class InitialGuess { kAuto, kFile, kSpanningTree, kChordal, kPlugin };

/// SolveOptions::level: edges of every level take part.
constexpr std::int32_t kAllLevels = -1;

/// How edges that contradict the others are found and switched off.
enum class RobustEstimation { kNone, kTruncatedLeastSquares, kGemanMcClure };

/// Graduated non-convexity, see core/solve/graduated.hpp. Edges that are not trusted
/// may be switched off.
struct Graduation {
  RobustEstimation kind = RobustEstimation::kNone;
  /// An edge is switched off where chi-square noise of its rank would exceed its squared
  /// error with this probability.
  double inlier_probability = 0.99;
  /// Lowers thresholds where the edges that are kept show less noise than their
  /// information matrices say.
  bool fit_noise = true;
  /// Trusts edges on one vertex, and those between two vertices of one type whose ids
  /// follow each other among that type's: odometry.
  bool trust_consecutive = true;
  std::vector<std::string> trusted_tags;  ///< edges of these are trusted, too
};

/// One line of the log: what an iteration did.
struct IterationRecord {
  int iteration = 0;        ///< 0 = the state before the first step
  double chi2 = 0;          ///< after the iteration
  double chi2_change = 0;   ///< old minus new, 0 if the step was refused
  double gradient_max = 0;  ///< largest |J' W r| before the step
  double step_norm = 0;     ///< length of the tangent step
  double damping = 0;       ///< lambda used
  bool accepted = true;
  bool alternative = false;  ///< not a step: another choice of an edge, and all that followed
  int linear_solves = 0;     ///< factorisations in this iteration
  std::int64_t associations_changed = 0;
  double seconds = 0;  ///< since the start of the solve
};

struct SolveOptions {
  Algorithm algorithm = Algorithm::kLevenbergMarquardt;
  InitialGuess initial_guess = InitialGuess::kAuto;
  std::string guess_name;  ///< for InitialGuess::kPlugin: which guess of the registry
  InformationPolicy information = InformationPolicy::kError;
  std::string linear_solver = "block";
  Graduation graduation;
  std::int32_t level = 0;  ///< edges of this level take part; kAllLevels = all
  int iterations = 100;
  int threads = 0;        ///< 0 = all processors; results do not depend on it
  double time_limit = 0;  ///< seconds, 0 = none; checked between iterations
  /// How many other choices of edges that list theirs (GRAFT_EDGE_HAS_ALTERNATIVES) are
  /// tried once converged, from the first state on, those that promise the lowest chi2
  /// first; 0 = none. Free where no edge lists any.
  int alternatives = 3;
  /// At most so many iterations after every step for what hangs on the rest by edges that
  /// choose alone (core/solve/inner_iterations.hpp); 0 = none.
  int inner_iterations = 8;
  /// Converged when an accepted step changes chi2 by less than this, relative.
  double function_tolerance = 1e-10;
  /// The same for graphs with edges that choose what they measure to (nearest
  /// grasp, nearest base): chi2 is smooth only until a choice changes, and what
  /// is left below this are changes of choice that only tiny steps get past.
  double association_tolerance = 1e-4;
  /// ... or when the step is shorter than this, relative to the estimates.
  double step_tolerance = 1e-10;
  /// ... or when every entry of the gradient is below this.
  double gradient_tolerance = 1e-10;
  /// Relative to the diagonal of J'WJ. Small, for pose graphs bend easily along
  /// long loops; where it is too small a few refused steps raise it quickly.
  double initial_damping = 1e-10;
  /// Called with the state before the first step and after every iteration;
  /// returning false stops the solve (status kInterrupted).
  std::function<bool(const IterationRecord&, const Values&)> callback;
  /// Polled between iterations; nonzero stops the solve.
  const std::atomic<int>* interrupt = nullptr;

  /// Empty, or which option has which value and violates what.
  std::string validate() const;
};

}  // namespace graft
