// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "core/linear/linear_solver.hpp"
#include "core/solve/normal_equations.hpp"
#include "core/solve/pattern_memory.hpp"

namespace graft {

class InnerIterations;

/// Seconds since it was made.
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// The state of a solve, its linear model, and what one may do with them. Times
/// are added to `seconds` by phase.
class SolveContext {
 public:
  /// `memory`: of what the solver analyzed last.
  SolveContext(const Problem& problem, LinearSolver& solver, PatternMemory& memory,
               ThreadPool& pool, std::map<std::string, double>& seconds);

  /// See Linearizer::setInterrupt().
  void setInterrupt(const std::atomic<int>* interrupt) { linearizer_.setInterrupt(interrupt); }
  /// What runs after every step, before it is judged; null = nothing.
  void setInner(InnerIterations* inner) { inner_ = inner; }
  /// Takes over a state whose chi2 is known.
  void start(State state, double chi2);
  /// Forms the linear model at the state.
  Evaluation linearize();

  /// Factors H + diag(damping); damping may be null.
  LinearOutcome factorize(const double* damping);
  /// step() = -(last factor)^-1 gradient; not ok if that is not finite.
  LinearOutcome solveForStep();
  /// Associates and evaluates the state moved by step() and inner iterations. Returns
  /// whether there is a finite chi2; it is then trialChi2().
  bool evaluateTrial();
  /// Factors with the least damping that works and solves for the step; false if none does.
  bool factorizeForStep();
  /// x = (last factor)^-1 b; false if it is not finite.
  bool solve(const std::vector<double>& b, std::vector<double>& x);
  /// Goes to a state of this problem, but with another association of an edge, which it
  /// keeps from then on. False if there is no chi2 there.
  bool hold(State state, const EdgePlace& edge, const std::vector<double>& association);
  /// Lets the edge of hold() choose again; returns whether no edge would choose anew at the
  /// state, which stays as it is.
  bool release();
  /// Goes back to a state of this context.
  void restore(State state, double chi2);
  /// After a refused trial: forms the linear model at the state anew, with the trial's
  /// association for every edge that is worse off by it, so that the next step counts on
  /// what the last one ran into. False if there is no such edge.
  bool anticipate();
  /// Takes back what anticipate() did since the last linearize(); false if an edge fails.
  bool withdraw();
  /// The trial becomes the state.
  void acceptTrial();

  const State& state() const { return state_; }
  double chi2() const { return chi2_; }
  double trialChi2() const { return trial_chi2_; }
  std::vector<double>& step() { return step_; }
  double stepNorm() const;
  /// Length of the free estimates' numbers, to judge steps by.
  double estimateNorm() const;
  const std::vector<double>& gradient() const { return equations_.gradient(); }
  double gradientMax() const;
  /// diag(H), raised to 1e-9 of its largest entry: the scale that damping is
  /// relative to (Marquardt 1963), positive in directions without information, too.
  const std::vector<double>& scale() const { return scale_; }
  const NormalEquations& equations() const { return equations_; }
  const Problem& problem() const { return *problem_; }
  bool hasAssociations() const { return linearizer_.hasAssociations(); }
  std::int64_t associationsChanged() const { return associations_changed_; }
  SymbolicReuse symbolicReuse() const { return symbolic_reuse_; }
  int factorizations() const { return factorizations_; }
  /// Why the last factorisation failed, with the vertex.
  std::string describe(const LinearOutcome& outcome) const;

 private:
  Evaluation linearizeAt(const State& state);
  Evaluation linearizeAt(const State& state, const std::vector<EdgePlace>& edges);
  /// Fails it where the normal equations are not finite; finds scale().
  Evaluation finishModel(Evaluation evaluation);

  const Problem* problem_;
  LinearSolver* solver_;
  ThreadPool* pool_;
  InnerIterations* inner_ = nullptr;
  std::map<std::string, double>* seconds_;
  Linearizer linearizer_;
  NormalEquations equations_;
  State state_;
  State trial_;
  State anticipated_;             // the state's estimates
  std::vector<EdgePlace> taken_;  // edges with a trial's association there
  double chi2_ = 0;
  double trial_chi2_ = 0;
  std::int64_t trial_changed_ = 0;
  std::int64_t associations_changed_ = 0;
  int factorizations_ = 0;
  SymbolicReuse symbolic_reuse_ = SymbolicReuse::kNothing;
  std::vector<double> step_;
  std::vector<double> scale_;
};

}  // namespace graft
