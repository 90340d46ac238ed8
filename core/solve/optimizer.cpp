// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/optimizer.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/solve/initial_guess.hpp"
#include "core/solve/relaxation.hpp"
#include "core/solve/step_strategy.hpp"

namespace graft {

namespace {

/// How often chi2 may change by less than the tolerance under strong damping
/// before that counts as convergence.
constexpr int kSmallChanges = 3;

class Solve {
 public:
  Solve(const Graph& graph, Values& values, Registry& registry, const SolveOptions& options)
      : options_(options),
        values_(values),
        pool_(options.threads),
        problem_(graph, options.information),
        solver_(LinearSolver::create(options.linear_solver, registry, pool_)),
        linearizer_(problem_, pool_) {
    linearizer_.setInterrupt(options.interrupt);
    summary_.threads = pool_.threads();
    summary_.linear_solver = options.linear_solver;
    summary_.notes = problem_.notes();
    for (const char* phase :
         {"analyze", "linearize", "factorize", "solve", "update", "evaluate", "associate"}) {
      summary_.seconds_by_phase[phase] = 0;
    }
  }

  Summary run() {
    State state;
    Evaluation start = chooseStart(state);
    summary_.seconds_guess = watch_.seconds();
    const Stopwatch solving;
    if (!start.ok()) {
      summary_.chi2_start = summary_.chi2_final = std::numeric_limits<double>::quiet_NaN();
      fail(start.failure);
    } else {
      summary_.chi2_start = summary_.chi2_final = start.chi2;
      iterate(std::move(state), start.chi2);
    }
    summary_.seconds_solve = solving.seconds();
    return std::move(summary_);
  }

 private:
  void finish(Status status, std::string reason) {
    summary_.status = status;
    summary_.reason = std::move(reason);
  }

  /// An evaluation or a step that failed: of itself, or because of an interrupt.
  void fail(const std::string& reason) {
    if (isInterrupted()) return finish(Status::kInterrupted, "interrupted");
    finish(Status::kFailed, reason);
  }
  bool isInterrupted() const {
    return options_.interrupt != nullptr && options_.interrupt->load() != 0;
  }

  Evaluation evaluateAt(const Values& values, State& state) const {
    Evaluation evaluation = linearizer_.begin(values, state);
    return evaluation.ok() ? linearizer_.evaluate(state) : evaluation;
  }

  /// A state to begin with.
  struct Guess {
    State state;
    Evaluation evaluation;
    std::int64_t placed = 0;
    std::int64_t unplaced = 0;
  };

  /// The state that the iterations begin with, and its chi2.
  Evaluation chooseStart(State& state) {
    Evaluation given = evaluateAt(values_, state);
    summary_.chi2_initial = given.ok() ? given.chi2 : std::numeric_limits<double>::quiet_NaN();
    const InitialGuess wanted = options_.initial_guess;
    if (wanted == InitialGuess::kFile) return given;
    if (state.associations.empty()) return given;
    if (wanted == InitialGuess::kChordal) {
      Guess guess = relax(state, true);
      return begin(StartKind::kChordal, std::move(guess), state);
    }
    Guess tree = spread(state);
    if (wanted == InitialGuess::kSpanningTree) {
      return tree.placed == 0 ? given : begin(StartKind::kSpanningTree, std::move(tree), state);
    }
    const bool tree_wins = tree.placed > 0 && isLower(tree.evaluation, given);
    const Evaluation& best = tree_wins ? tree.evaluation : given;
    if (isPoor(best)) {
      Guess chordal = relax(state, false);
      if (chordal.placed > 0 && isLower(chordal.evaluation, best)) {
        noteUnusable(given, "the chordal relaxation");
        return begin(StartKind::kChordal, std::move(chordal), state);
      }
    }
    if (!tree_wins) return given;
    noteUnusable(given, "a spanning tree");
    return begin(StartKind::kSpanningTree, std::move(tree), state);
  }

  static bool isLower(const Evaluation& a, const Evaluation& b) {
    return a.ok() && (!b.ok() || a.chi2 < b.chi2);
  }

  /// Whether a start is so far from what noise explains that a relaxation, which
  /// costs about as much as an iteration, is worth a try.
  bool isPoor(const Evaluation& evaluation) const {
    constexpr double kPoor = 10;
    double errors = 0;
    for (const EdgeGroup& group : problem_.groups()) {
      errors += double(group.count) * group.error_dim;
    }
    return !evaluation.ok() || evaluation.chi2 > kPoor * errors;
  }

  Guess spread(const State& state, const std::vector<VertexRef>& placed = {}) const {
    SpreadResult result = spreadEstimates(problem_, state, placed);
    Guess guess;
    guess.placed = result.placed;
    guess.unplaced = result.unplaced;
    if (guess.placed > 0 || !placed.empty()) {
      guess.evaluation = evaluateAt(result.values, guess.state);
    }
    return guess;
  }

  /// The relaxation, and a spanning tree for what it leaves. Without one, or with one
  /// that says no more than a tree: throws if it is required, else the guess has no
  /// vertex placed.
  Guess relax(const State& state, bool required) {
    RelaxResult result = relaxEstimates(problem_, state, pool_, !required);
    if (!result.failure.empty()) {
      if (!required) return {};
      throw Error(ExitCode::kNoResult, "there is no chordal initial guess: " + result.failure);
    }
    State relaxed = state;
    relaxed.values = std::move(result.values);
    Guess guess = spread(relaxed, result.placed);
    guess.placed += std::int64_t(result.placed.size());
    return guess;
  }

  void noteUnusable(const Evaluation& given, const char* start) {
    if (given.ok()) return;
    summary_.notes.push_back("began with " + std::string(start) + ", because " + given.failure);
  }

  Evaluation begin(StartKind kind, Guess guess, State& state) {
    if (guess.unplaced > 0) {
      summary_.notes.push_back("no edge of the spanning tree could place " +
                               std::to_string(guess.unplaced) +
                               " vertices; they begin where they were");
    }
    summary_.start = kind;
    state = std::move(guess.state);
    return guess.evaluation;
  }

  void iterate(State state, double chi2) {
    if (problem_.freeVertices().empty()) {
      linearizer_.evaluate(state, &summary_.chi2_by_tag);
      values_ = state.values;
      record({}, chi2);
      const bool edges = !problem_.groups().empty();
      return finish(Status::kConverged,
                    edges ? "every vertex with an edge is fixed" : "the graph has no edges");
    }
    SolveContext context(problem_, *solver_, pool_, summary_.seconds_by_phase);
    summary_.ordering = solver_->ordering();
    summary_.factor_flops = solver_->flops();
    context.setInterrupt(options_.interrupt);
    context.start(std::move(state), chi2);
    loop(context);
    summary_.associations_changed = context.associationsChanged();
    summary_.chi2_final = context.chi2();
    if (!isInterrupted()) linearizer_.evaluate(context.state(), &summary_.chi2_by_tag);
    if (summary_.status != Status::kFailed) values_ = context.state().values;
  }

  void record(IterationRecord record, double chi2) {
    record.chi2 = chi2;
    record.seconds = watch_.seconds();
    summary_.iterations.push_back(record);
  }

  /// True if the solve has to end between two iterations.
  bool mustStop(const SolveContext& context) {
    const IterationRecord& last = summary_.iterations.back();
    if (options_.callback && !options_.callback(last, context.state().values)) {
      finish(Status::kInterrupted, "the callback asked to stop");
    } else if (isInterrupted()) {
      finish(Status::kInterrupted, "interrupted");
    } else if (options_.time_limit > 0 && watch_.seconds() >= options_.time_limit) {
      finish(Status::kTimeLimit,
             "the time limit of " + formatDouble(options_.time_limit) + " seconds is reached");
    } else {
      return false;
    }
    return true;
  }

  void loop(SolveContext& context) {
    const std::unique_ptr<StepStrategy> strategy = StepStrategy::create(options_);
    bool linearized = false;
    bool moved = false;
    int small_changes = 0;
    record({}, context.chi2());
    for (int iteration = 1;; ++iteration) {
      if (mustStop(context)) return;
      if (!linearized) {
        const Evaluation evaluation = context.linearize();
        if (!evaluation.ok()) return fail(evaluation.failure);
        linearized = true;
      }
      IterationRecord entry;
      entry.gradient_max = context.gradientMax();
      if (entry.gradient_max <= options_.gradient_tolerance) {
        return finish(Status::kConverged, "the gradient is below gradient_tolerance");
      }
      if (iteration > options_.iterations) {
        return finish(
            Status::kIterationLimit,
            "the iteration limit of " + std::to_string(options_.iterations) + " is reached");
      }
      const double before = context.chi2();
      const int factorizations = context.factorizations();
      const std::int64_t changed = context.associationsChanged();
      const StepResult result = strategy->iterate(context);
      entry.iteration = iteration;
      entry.accepted = result.kind == StepResult::Kind::kAccepted;
      entry.chi2_change = entry.accepted ? before - context.chi2() : 0;
      entry.step_norm = context.stepNorm();
      entry.damping = result.damping;
      entry.linear_solves = context.factorizations() - factorizations;
      entry.associations_changed = context.associationsChanged() - changed;
      record(entry, context.chi2());
      if (result.kind == StepResult::Kind::kFailed) {
        return fail("iteration " + std::to_string(iteration) + ": " + result.reason);
      }
      if (!entry.accepted && isInterrupted()) return fail(result.reason);
      if (result.kind == StepResult::Kind::kStuck) return finishStuck(result, moved);
      if (!entry.accepted) continue;
      moved = true;
      linearized = false;
      if (linearizer_.hasAssociations() &&
          entry.chi2_change <= options_.association_tolerance * before) {
        return finish(Status::kConverged, "chi2 changes by less than association_tolerance");
      }
      const bool small = entry.chi2_change <= options_.function_tolerance * before;
      small_changes = small ? small_changes + 1 : 0;
      if ((small && result.full) || small_changes >= kSmallChanges) {
        return finish(Status::kConverged, "chi2 changes by less than function_tolerance");
      }
      const double length = context.estimateNorm() + options_.step_tolerance;
      if (result.full && entry.step_norm <= options_.step_tolerance * length) {
        return finish(Status::kConverged, "the step is below step_tolerance");
      }
    }
  }

  /// No step lowers chi2: at a minimum that is convergence. Where not even the
  /// first step worked though one was predicted to, derivatives must be wrong.
  void finishStuck(const StepResult& result, bool moved) {
    const bool wrong = result.damping > 1 && !moved && !linearizer_.hasAssociations();
    if (!wrong) return finish(Status::kConverged, result.reason);
    finish(Status::kFailed, result.reason + ": is the Jacobian of an edge type wrong?");
  }

  const SolveOptions& options_;
  Values& values_;
  Stopwatch watch_;
  ThreadPool pool_;
  Problem problem_;
  std::unique_ptr<LinearSolver> solver_;
  Linearizer linearizer_;
  Summary summary_;
};

}  // namespace

Summary optimize(const Graph& graph, Values& values, Registry& registry,
                 const SolveOptions& options) {
  const std::string defect = options.validate();
  if (!defect.empty()) throw Error(ExitCode::kUsage, defect);
  return Solve(graph, values, registry, options).run();
}

double evaluateChi2(const Graph& graph, const Values& values,
                    std::map<std::string, double>* by_tag) {
  ThreadPool pool(1);
  const Problem problem(graph, InformationPolicy::kProject);
  const Linearizer linearizer(problem, pool);
  State state;
  Evaluation evaluation = linearizer.begin(values, state);
  if (evaluation.ok()) evaluation = linearizer.evaluate(state, by_tag);
  if (!evaluation.ok()) throw Error(ExitCode::kNoResult, evaluation.failure);
  return evaluation.chi2;
}

}  // namespace graft
