// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/graduated.hpp"

#include <algorithm>
#include <limits>

#include "core/solve/consensus.hpp"
#include "core/solve/flips.hpp"

namespace graft {

namespace {

constexpr double kSteeper = 1.4;   ///< from round to round, as in the paper
constexpr double kSmoother = 0.1;  ///< where the next pass begins, from where the last did
constexpr int kPatience = 3;       ///< passes without progress that end a search ...
/// ... unless it began with edges that agree. Then false edges that fill the factor do, once
/// it costs so many times what that of the kept edges does.
constexpr double kMostCostly = 8;
constexpr double kSameCost = 1e-9;
/// Parameters under which no weight differs by more from those of the last round need none.
constexpr double kSameWeight = 0.1;
constexpr int kNoiseRounds = 5;

}  // namespace

Evaluation Graduated::pass(WeightedRounds& rounds, double parameter, State& state) {
  const bool truncated = options_->graduation.kind == RobustEstimation::kTruncatedLeastSquares;
  too_smooth_ = false;
  while (!rounds.tools().must_stop() && !too_smooth_) {
    const bool decided = edges_.setWeights(parameter);
    if (truncated && decided && parameter > 1) break;
    if (!grown_ || rounds.weightsDiffer(kSameWeight)) {
      Evaluation evaluation = rounds.run(WeightedRounds::Effort::kRough, state);
      if (!evaluation.ok()) return evaluation;
      too_smooth_ = rounds.wasTooCostly();
    }
    if (!truncated && parameter <= 1) break;
    parameter = truncated ? parameter * kSteeper : std::max(1.0, parameter / kSteeper);
  }
  edges_.setSides();
  return rounds.settle(state);
}

Evaluation Graduated::search(WeightedRounds& rounds, State& state) {
  Flips flips(edges_, rounds);
  const bool truncated = options_->graduation.kind == RobustEstimation::kTruncatedLeastSquares;
  Evaluation evaluation;
  Best best;
  best.cost = std::numeric_limits<double>::infinity();
  if (grown_) {
    edges_.setSides();
    evaluation = rounds.settle(state);
    if (evaluation.ok()) evaluation = flips.run(state);
    best = {edges_.truncatedCost(evaluation.chi2), evaluation.chi2, state, edges_.squares()};
  }
  rounds.limitCost(grown_ ? kMostCostly : 0);
  bool progress = !grown_;
  double parameter = 1;
  for (int worse = 0; worse < kPatience || rounds.isLimited();) {
    if (!evaluation.ok() || rounds.tools().must_stop()) return evaluation;
    evaluation = pass(rounds, parameter, state);
    ++report_->passes;
    if (!evaluation.ok()) return evaluation;
    const double cost = edges_.truncatedCost(evaluation.chi2);
    const bool lower = cost < best.cost * (1 - kSameCost);
    worse = lower ? 0 : worse + 1;
    progress = progress || lower;
    if (lower) best = {cost, evaluation.chi2, state, edges_.squares()};
    state = best.state;
    edges_.squares() = best.squares;
    const double smoothest = edges_.smoothestParameter();
    if (too_smooth_) break;
    if (truncated ? parameter <= smoothest : parameter >= smoothest) break;
    parameter = truncated ? std::max(parameter * kSmoother, smoothest)
                          : std::min(parameter / kSmoother, smoothest);
  }
  rounds.limitCost(0);
  edges_.setSides();
  evaluation.chi2 = best.chi2;
  return progress ? flips.run(state) : evaluation;
}

/// Edges that agree, or the start given where that costs less.
Evaluation Graduated::begin(WeightedRounds& rounds, State& state) {
  const Linearizer& linearizer = rounds.tools().linearizer;
  const State given = state;
  Evaluation evaluation;
  Consensus consensus(edges_, rounds);
  grown_ = consensus.grow(state, evaluation);
  rounds.setCareful(!grown_);
  if (grown_) {
    evaluation = edges_.truncatedCost(linearizer, given);
    Evaluation grown = edges_.truncatedCost(linearizer, state);
    if (!grown.ok()) return grown;
    if (evaluation.ok() && evaluation.chi2 < grown.chi2) state = given;
  } else if (!evaluation.ok()) {
    return evaluation;
  }
  evaluation = linearizer.squaredErrors(state, edges_.squares());
  return evaluation.ok() ? linearizer.evaluate(state) : evaluation;
}

Evaluation Graduated::run(const Tools& tools, State& state) {
  WeightedRounds rounds(edges_, *options_, tools, *report_);
  Evaluation evaluation = begin(rounds, state);
  for (int i = 0; i < kNoiseRounds && evaluation.ok() && !tools.must_stop(); ++i) {
    evaluation = search(rounds, state);
    if (evaluation.ok() && !edges_.fitNoise(evaluation.chi2, false)) break;
  }
  if (evaluation.ok()) edges_.reportOff();
  return evaluation;
}

}  // namespace graft
