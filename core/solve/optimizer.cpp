// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/optimizer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/solve/alternatives.hpp"
#include "core/solve/graduated.hpp"
#include "core/solve/inner_iterations.hpp"
#include "core/solve/inspection.hpp"
#include "core/solve/start.hpp"
#include "core/solve/step_strategy.hpp"

namespace graft {

namespace {

/// How often chi2 may change by less than the tolerance under strong damping
/// before that counts as convergence.
constexpr int kSmallChanges = 3;

/// One solve with a session's solver.
class Solve {
 public:
  Solve(const Graph& graph, Values& values, Registry& registry, const SolveOptions& options,
        ThreadPool& pool, LinearSolver& solver, PatternMemory& memory)
      : registry_(registry),
        options_(options),
        values_(values),
        pool_(pool),
        problem_(graph, options.information, options.level),
        solver_(solver),
        memory_(memory),
        linearizer_(problem_, pool_) {
    linearizer_.setInterrupt(options.interrupt);
    summary_.threads = pool_.threads();
    summary_.linear_solver = options.linear_solver;
    summary_.notes = problem_.notes();
    for (const char* phase : {"analyze", "linearize", "factorize", "solve", "update", "inner",
                              "evaluate", "associate"}) {
      summary_.seconds_by_phase[phase] = 0;
    }
    if (options.graduation.kind != RobustEstimation::kNone) {
      graduated_ = std::make_unique<Graduated>(problem_, options, summary_.graduation);
    }
  }

  Summary run() {
    Start start = begin();
    summary_.start = start.kind;
    summary_.start_name = start.name;
    summary_.notes.insert(summary_.notes.end(), start.notes.begin(), start.notes.end());
    summary_.seconds_guess = watch_.seconds();
    const Stopwatch solving;
    if (!start.evaluation.ok()) {
      summary_.chi2_start = summary_.chi2_final = std::numeric_limits<double>::quiet_NaN();
      fail(start.evaluation.failure);
    } else {
      summary_.chi2_start = summary_.chi2_final = start.evaluation.chi2;
      iterate(std::move(start.state), start.evaluation.chi2);
    }
    summary_.seconds_solve = solving.seconds();
    return std::move(summary_);
  }

 private:
  /// The state to begin with. Under graduation it follows what can be trusted, and is
  /// judged by all the rest, too.
  Start begin() {
    State state;
    Evaluation given = linearizer_.begin(values_, state);
    if (given.ok()) given = linearizer_.evaluate(state);
    summary_.chi2_initial = given.ok() ? given.chi2 : std::numeric_limits<double>::quiet_NaN();
    if (graduated_ == nullptr) {
      return chooseStart({problem_, linearizer_, pool_, registry_, options_}, std::move(state),
                         given);
    }
    graduated_->trustOnly();
    const auto cost = [this](const State& at) {
      return graduated_->truncatedCost(linearizer_, at);
    };
    if (given.ok()) given = cost(state);
    return chooseStart({problem_, linearizer_, pool_, registry_, options_, cost}, std::move(state),
                       given);
  }

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

  void iterate(State state, double chi2) {
    if (problem_.freeVertices().empty()) {
      linearizer_.evaluate(state, &summary_.chi2_by_tag);
      values_ = state.values;
      record({}, chi2);
      const bool edges = !problem_.groups().empty();
      return finish(Status::kConverged,
                    edges ? "every vertex with an edge is fixed" : "the graph has no edges");
    }
    std::optional<SolveContext> made;
    std::optional<InnerIterations> inner;
    try {
      if (!graduate(state, chi2)) return;
      made.emplace(problem_, solver_, memory_, pool_, summary_.seconds_by_phase);
      // Graduation gives edges weights that a part would not know of.
      const Stopwatch building;
      inner.emplace(problem_, registry_, options_.information,
                    graduated_ == nullptr ? options_.inner_iterations : 0, options_.interrupt);
      summary_.seconds_by_phase["inner"] += building.seconds();
    } catch (const Error& error) {
      if (error.code() != ExitCode::kNoResult) throw;
      return finish(Status::kFailed, error.what());  // it would not fit into memory
    }
    SolveContext& context = *made;
    summary_.symbolic_reuse = context.symbolicReuse();
    summary_.ordering = solver_.ordering();
    summary_.factor_flops = solver_.flops();
    summary_.factor_bytes = solver_.bytes();
    context.setInterrupt(options_.interrupt);
    summary_.inner_parts = inner->parts();
    if (inner->parts() > 0) context.setInner(&*inner);
    std::optional<State> first;
    if (options_.alternatives > 0 && hasAlternatives(problem_)) first = state;
    context.start(std::move(state), chi2);
    loop(context);
    if (first && summary_.status == Status::kConverged) tryAlternatives(context, *first);
    noteFreeDirections(context);
    summary_.associations_changed = context.associationsChanged();
    summary_.chi2_final = context.chi2();
    if (!isInterrupted()) linearizer_.evaluate(context.state(), &summary_.chi2_by_tag);
    if (summary_.status != Status::kFailed) values_ = context.state().values;
  }

  /// Names what the edges leave open: damping hides it, undamped systems fail by it.
  void noteFreeDirections(const SolveContext& context) {
    const bool failed = summary_.status == Status::kFailed;
    const bool stopped = isInterrupted() ||
                         (summary_.status == Status::kTimeLimit && summary_.iterations.size() == 1);
    if (stopped) return;
    if (!failed && !hasWeakAnchor(problem_) && !hasOpenBlock(context.equations())) return;
    std::vector<std::string> texts = describeFreeDirections(problem_, context.state().values);
    if (failed && !texts.empty()) summary_.reason += " (" + texts.front() + ")";
    for (std::string& text : texts) summary_.notes.push_back("no edge determines this: " + text);
  }

  /// Switches off the edges that contradict the others, if that is wanted. False if the
  /// solve has ended with that.
  bool graduate(State& state, double& chi2) {
    if (graduated_ == nullptr) return true;
    const auto must_stop = [this] { return isOver(); };
    const Evaluation evaluation = graduated_->run(
        {linearizer_, solver_, memory_, pool_, summary_.seconds_by_phase, must_stop}, state);
    chi2 = evaluation.chi2;
    if (evaluation.ok()) return true;
    fail(evaluation.failure);
    if (!isInterrupted()) return false;
    // What there is so far, weights in between included, is the best there is.
    linearizer_.setInterrupt(nullptr);
    const Evaluation reached = linearizer_.evaluate(state, &summary_.chi2_by_tag);
    summary_.chi2_final = reached.chi2;
    if (reached.ok()) values_ = state.values;
    return false;
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

  /// Whether other choices of edges lead lower from the first state on, those first that
  /// promise most.
  void tryAlternatives(SolveContext& context, const State& first) {
    // Predictions are as linear as the model: what is worse by three standard deviations of
    // one measurement may still be better in truth.
    constexpr double kDoubt = 9;
    std::vector<Alternative> been;  // choices that were tried or left
    std::vector<Alternative> found;
    while (summary_.alternatives_tried < options_.alternatives && !isOver()) {
      if (found.empty()) found = findAlternatives(context);
      const auto next = std::find_if(found.begin(), found.end(), [&](const Alternative& a) {
        return std::none_of(been.begin(), been.end(),
                            [&](const Alternative& b) { return b.isSameAs(a); });
      });
      if (next == found.end() || next->predicted_chi2 > context.chi2() + kDoubt) return;
      been.push_back(*next);
      been.push_back(currentChoice(context, *next));
      ++summary_.alternatives_tried;
      const State kept = context.state();
      const double chi2 = context.chi2();
      const int factorizations = context.factorizations();
      const std::int64_t changed = context.associationsChanged();
      const EdgePlace edge(next->group, std::size_t(next->edge));
      const bool held = context.hold(first, edge, next->association);
      if (held) pursue(context, chi2);
      if (!context.release() || !held || !(context.chi2() < chi2)) {
        context.restore(kept, chi2);
        continue;
      }
      ++summary_.alternatives_taken;
      IterationRecord entry;
      entry.iteration = summary_.iterations.back().iteration + 1;
      entry.chi2_change = chi2 - context.chi2();
      entry.linear_solves = context.factorizations() - factorizations;
      entry.associations_changed = context.associationsChanged() - changed;
      entry.alternative = true;
      record(entry, context.chi2());
      found.clear();
    }
  }

  /// Iterates as long as that may end below a chi2.
  void pursue(SolveContext& context, double wanted) {
    constexpr double kOutlook = 10;  // more than this many times the last gain is not expected
    const std::unique_ptr<StepStrategy> strategy = StepStrategy::create(options_);
    bool linearized = false;
    for (int i = 0; i < options_.iterations && !isOver(); ++i) {
      const double before = context.chi2();
      if (!linearized && !context.linearize().ok()) return;
      const StepResult::Kind kind = strategy->iterate(context).kind;
      linearized = kind == StepResult::Kind::kRefused;
      if (linearized) continue;
      if (kind != StepResult::Kind::kAccepted) return;
      const double change = before - context.chi2();
      if (change <= options_.association_tolerance * before) return;
      if (context.chi2() - kOutlook * change > wanted) return;
    }
  }
  bool isOver() const {
    return isInterrupted() || (options_.time_limit > 0 && watch_.seconds() >= options_.time_limit);
  }

  /// No step lowers chi2: at a minimum that is convergence. Where not even the
  /// first step worked though one was predicted to, derivatives must be wrong.
  void finishStuck(const StepResult& result, bool moved) {
    const bool wrong = result.damping > 1 && !moved && !linearizer_.hasAssociations();
    if (!wrong) return finish(Status::kConverged, result.reason);
    finish(Status::kFailed, result.reason + ": is the Jacobian of an edge type wrong?");
  }

  Registry& registry_;
  const SolveOptions& options_;
  Values& values_;
  Stopwatch watch_;
  ThreadPool& pool_;
  Problem problem_;
  LinearSolver& solver_;
  PatternMemory& memory_;
  Linearizer linearizer_;
  Summary summary_;
  std::unique_ptr<Graduated> graduated_;
};

}  // namespace

struct Optimizer::Session {
  Session(Registry& types, SolveOptions given)
      : registry(types),
        options(std::move(given)),
        pool(options.threads),
        solver(LinearSolver::create(options.linear_solver, registry, pool)) {}

  Registry& registry;
  SolveOptions options;
  ThreadPool pool;
  std::unique_ptr<LinearSolver> solver;
  PatternMemory memory;
};

Optimizer::Optimizer(Registry& registry, SolveOptions options) {
  const std::string defect = options.validate();
  if (!defect.empty()) throw Error(ExitCode::kUsage, defect);
  session_ = std::make_unique<Session>(registry, std::move(options));
}

Optimizer::~Optimizer() = default;
Optimizer::Optimizer(Optimizer&&) noexcept = default;
Optimizer& Optimizer::operator=(Optimizer&&) noexcept = default;

Summary Optimizer::solve(const Graph& graph, Values& values) {
  Session& s = *session_;
  return Solve(graph, values, s.registry, s.options, s.pool, *s.solver, s.memory).run();
}

Summary optimize(const Graph& graph, Values& values, Registry& registry,
                 const SolveOptions& options) {
  return Optimizer(registry, options).solve(graph, values);
}

double evaluateChi2(const Graph& graph, const Values& values, std::map<std::string, double>* by_tag,
                    std::int32_t level) {
  ThreadPool pool(1);
  const Problem problem(graph, InformationPolicy::kProject, level);
  const Linearizer linearizer(problem, pool);
  State state;
  Evaluation evaluation = linearizer.begin(values, state);
  if (evaluation.ok()) evaluation = linearizer.evaluate(state, by_tag);
  if (!evaluation.ok()) throw Error(ExitCode::kNoResult, evaluation.failure);
  return evaluation.chi2;
}

}  // namespace graft
