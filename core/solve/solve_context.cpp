// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/solve_context.hpp"

#include <algorithm>
#include <cmath>

#include "core/solve/inner_iterations.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

constexpr double kSmallestScale = 1e-9;
constexpr double kLeastDamping = 1e-7;

/// Adds the time of a scope to a phase.
class PhaseTimer {
 public:
  PhaseTimer(std::map<std::string, double>& seconds, const char* phase)
      : seconds_(&seconds[phase]) {}
  ~PhaseTimer() { *seconds_ += watch_.seconds(); }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  double* seconds_;
  Stopwatch watch_;
};

}  // namespace

SolveContext::SolveContext(const Problem& problem, LinearSolver& solver, PatternMemory& memory,
                           ThreadPool& pool, std::map<std::string, double>& seconds)
    : problem_(&problem),
      solver_(&solver),
      pool_(&pool),
      seconds_(&seconds),
      linearizer_(problem, pool),
      equations_(problem) {
  const PhaseTimer timer(*seconds_, "analyze");
  symbolic_reuse_ = memory.analyze(problem, equations_, solver);
  step_.resize(std::size_t(problem.dim()));
  scale_.resize(std::size_t(problem.dim()));
}

void SolveContext::start(State state, double chi2) {
  state_ = std::move(state);
  trial_ = state_;
  chi2_ = chi2;
}

Evaluation SolveContext::linearize() {
  taken_.clear();
  return linearizeAt(state_);
}

bool SolveContext::anticipate() {
  std::vector<EdgePlace> taken;
  {
    const PhaseTimer timer(*seconds_, "associate");
    if (taken_.empty()) anticipated_ = state_;
    if (!linearizer_.takeGreater(anticipated_, trial_, taken).ok() || taken.empty()) return false;
  }
  taken_.insert(taken_.end(), taken.begin(), taken.end());
  return linearizeAt(anticipated_, taken).ok();
}

bool SolveContext::withdraw() {
  if (taken_.empty()) return true;
  std::sort(taken_.begin(), taken_.end());
  taken_.erase(std::unique(taken_.begin(), taken_.end()), taken_.end());
  const bool done = linearizeAt(state_, taken_).ok();
  taken_.clear();
  return done;
}

Evaluation SolveContext::linearizeAt(const State& state) {
  const PhaseTimer timer(*seconds_, "linearize");
  Evaluation evaluation = linearizer_.linearize(state);
  if (!evaluation.ok()) return evaluation;
  equations_.gather(linearizer_, *pool_);
  return finishModel(std::move(evaluation));
}

Evaluation SolveContext::linearizeAt(const State& state, const std::vector<EdgePlace>& edges) {
  const PhaseTimer timer(*seconds_, "linearize");
  Evaluation evaluation = linearizer_.linearizeEdges(state, edges);
  if (!evaluation.ok()) return evaluation;
  equations_.gather(linearizer_, edges);
  return finishModel(std::move(evaluation));
}

Evaluation SolveContext::finishModel(Evaluation evaluation) {
  double largest = 0;
  double sum = 0;
  for (const double entry : equations_.diagonal()) {
    largest = std::max(largest, entry);
    sum += entry;
  }
  for (const double entry : equations_.gradient()) sum += entry;
  if (!std::isfinite(sum)) evaluation.failure = "the normal equations are not finite";
  for (std::size_t i = 0; i < scale_.size(); ++i) {
    scale_[i] = std::max(equations_.diagonal()[i], kSmallestScale * largest);
  }
  return evaluation;
}

LinearOutcome SolveContext::factorize(const double* damping) {
  const PhaseTimer timer(*seconds_, "factorize");
  ++factorizations_;
  return solver_->factorize(equations_.hessian().data(), damping);
}

LinearOutcome SolveContext::solveForStep() {
  const PhaseTimer timer(*seconds_, "solve");
  LinearOutcome outcome = solver_->solve(equations_.gradient().data(), step_.data());
  if (!outcome.ok) return outcome;
  double sum = 0;
  for (double& entry : step_) {
    entry = -entry;
    sum += 0.0 * entry;
  }
  if (sum != 0 || std::isnan(sum)) {
    outcome.ok = false;
    outcome.message = "the solution of the normal equations is not finite";
  }
  return outcome;
}

bool SolveContext::factorizeForStep() {
  std::vector<double> damping(scale_.size());
  double lambda = kLeastDamping;
  while (lambda < 1) {
    for (std::size_t i = 0; i < damping.size(); ++i) damping[i] = lambda * scale_[i];
    if (factorize(damping.data()).ok && solveForStep().ok) return true;
    lambda *= 100;
  }
  return false;
}

bool SolveContext::solve(const std::vector<double>& b, std::vector<double>& x) {
  const PhaseTimer timer(*seconds_, "solve");
  if (!solver_->solve(b.data(), x.data()).ok) return false;
  double sum = 0;
  for (const double entry : x) sum += 0.0 * entry;
  return sum == 0;
}

bool SolveContext::hold(State state, const EdgePlace& edge,
                        const std::vector<double>& association) {
  linearizer_.hold(edge);
  std::copy(
      association.begin(), association.end(),
      state.associations[edge.first].begin() + std::ptrdiff_t(edge.second * association.size()));
  const Evaluation evaluation = linearizer_.evaluate(state);
  if (evaluation.ok()) restore(std::move(state), evaluation.chi2);
  return evaluation.ok();
}

bool SolveContext::release() {
  linearizer_.hold(std::nullopt);
  trial_ = state_;
  std::int64_t changed = 0;
  return linearizer_.associate(trial_, changed).ok() && changed == 0;
}

void SolveContext::restore(State state, double chi2) {
  state_ = std::move(state);
  chi2_ = chi2;
}

bool SolveContext::evaluateTrial() {
  {
    const PhaseTimer timer(*seconds_, "update");
    trial_ = state_;
    const std::vector<VertexRef>& free = problem_->freeVertices();
    for (std::size_t i = 0; i < free.size(); ++i) {
      const graft_vertex_type& type = problem_->graph().type(free[i]);
      callPlugin(Callback::kPlus, type.tag, [&] {
        type.plus(1, state_.values.at(free[i]), step_.data() + problem_->offsets()[i],
                  trial_.values.at(free[i]));
      });
      // An estimate that is not finite makes an edge fail below, if it is used.
    }
  }
  if (inner_ != nullptr) {
    const PhaseTimer timer(*seconds_, "inner");
    inner_->run(trial_.values, *pool_);
  }
  trial_changed_ = 0;
  if (linearizer_.hasAssociations()) {
    const PhaseTimer timer(*seconds_, "associate");
    if (!linearizer_.associate(trial_, trial_changed_).ok()) return false;
  }
  const PhaseTimer timer(*seconds_, "evaluate");
  const Evaluation evaluation = linearizer_.evaluate(trial_);
  trial_chi2_ = evaluation.chi2;
  return evaluation.ok();
}

void SolveContext::acceptTrial() {
  std::swap(state_, trial_);
  chi2_ = trial_chi2_;
  associations_changed_ += trial_changed_;
}

double SolveContext::stepNorm() const {
  double sum = 0;
  for (const double entry : step_) sum += entry * entry;
  return std::sqrt(sum);
}

double SolveContext::estimateNorm() const {
  double sum = 0;
  for (const VertexRef v : problem_->freeVertices()) {
    const double* x = state_.values.at(v);
    for (std::size_t i = 0; i < state_.values.dim(v.type); ++i) sum += x[i] * x[i];
  }
  return std::sqrt(sum);
}

double SolveContext::gradientMax() const {
  double largest = 0;
  for (const double entry : equations_.gradient()) largest = std::max(largest, std::abs(entry));
  return largest;
}

std::string SolveContext::describe(const LinearOutcome& outcome) const {
  if (!outcome.message.empty()) return outcome.message;
  std::string text = "the normal equations are not positive definite";
  if (outcome.failed_block >= 0) {
    text += " at vertex " +
            problem_->describeVertex(problem_->freeVertices()[std::size_t(outcome.failed_block)]) +
            ": its edges do not determine it";
  }
  return text;
}

}  // namespace graft
