// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/weighted_rounds.hpp"

#include <cmath>
#include <utility>

#include "core/solve/step_strategy.hpp"

namespace graft {

namespace {

constexpr int kSettlingRounds = 60;
/// Iterations of a round, and the relative change of F that ends it.
constexpr int kRoughIterations = 2;
constexpr int kCarefulIterations = 5;
constexpr int kFairIterations = 8;
constexpr int kExactIterations = 30;
constexpr double kRoughTolerance = 1e-4;
constexpr double kExactTolerance = 1e-9;

bool haveSamePattern(const RobustEdges::Numbers& a, const RobustEdges::Numbers& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t g = 0; g < a.size(); ++g) {
    for (std::size_t e = 0; e < a[g].size(); ++e) {
      if ((a[g][e] == 0) != (b[g][e] == 0)) return false;
    }
  }
  return true;
}

}  // namespace

bool WeightedRounds::weightsDiffer(double least) const {
  const RobustEdges::Numbers now = edges_->weights();
  if (weights_.size() != now.size()) return true;
  for (std::size_t g = 0; g < now.size(); ++g) {
    for (std::size_t e = 0; e < now[g].size(); ++e) {
      if (std::abs(now[g][e] - weights_[g][e]) > least) return true;
    }
  }
  return false;
}

void WeightedRounds::limitCost(double factor) {
  most_flops_ = factor * tools_.solver.flops();
  too_costly_ = false;
}

Evaluation WeightedRounds::run(Effort effort, State& state) {
  ++report_->rounds;
  Evaluation evaluation = tools_.linearizer.evaluate(state);
  if (!evaluation.ok()) return evaluation;
  SolveOptions options;
  options.initial_damping = options_->initial_damping;
  const std::unique_ptr<StepStrategy> strategy = StepStrategy::create(options);
  RobustEdges::Numbers weights = edges_->weights();
  // An order of elimination that was found among other edges would be a poor one.
  if (!haveSamePattern(weights, weights_)) tools_.memory.forget();
  weights_ = std::move(weights);
  SolveContext context(edges_->problem(), tools_.solver, tools_.memory, tools_.pool,
                       tools_.seconds);
  too_costly_ = most_flops_ > 0 && tools_.solver.flops() > most_flops_;
  if (too_costly_) return evaluation;
  context.start(std::move(state), evaluation.chi2);
  const bool exact = effort == Effort::kExact;
  const double tolerance = exact ? kExactTolerance : kRoughTolerance;
  const int most = exact                     ? kExactIterations
                   : effort == Effort::kFair ? kFairIterations
                   : careful_                ? kCarefulIterations
                                             : kRoughIterations;
  bool linearized = false;
  for (int i = 0; i < most && !tools_.must_stop(); ++i) {
    if (!linearized) evaluation = context.linearize();
    if (!evaluation.ok()) break;
    linearized = true;
    if (context.gradientMax() <= options.gradient_tolerance) break;
    const double before = context.chi2();
    const StepResult result = strategy->iterate(context);
    ++report_->iterations;
    if (result.kind == StepResult::Kind::kFailed) evaluation.failure = result.reason;
    if (result.kind == StepResult::Kind::kFailed || result.kind == StepResult::Kind::kStuck) break;
    if (result.kind != StepResult::Kind::kAccepted) continue;
    linearized = false;
    if (before - context.chi2() <= tolerance * before) break;
  }
  evaluation.chi2 = context.chi2();
  state = context.state();
  if (!evaluation.ok()) return evaluation;
  evaluation.failure = tools_.linearizer.squaredErrors(state, edges_->squares()).failure;
  return evaluation;
}

Evaluation WeightedRounds::settle(State& state) {
  Evaluation evaluation;
  bool settled = false;
  for (int i = 0; i < kSettlingRounds; ++i) {
    evaluation = run(settled || careful_ ? Effort::kExact : Effort::kRough, state);
    if (!evaluation.ok() || tools_.must_stop()) break;
    const bool changed = edges_->setSides();
    if ((settled || careful_) && !changed) break;
    settled = !changed;
  }
  return evaluation;
}

}  // namespace graft
