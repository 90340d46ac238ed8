// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/graduated.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <cstdio>
#include <limits>
#include <set>

#include "core/base/error.hpp"
#include "core/solve/consensus.hpp"
#include "core/solve/innovations.hpp"

namespace graft {

namespace {

constexpr double kSteeper = 1.4;   ///< from round to round, as in the paper
constexpr double kSmoother = 0.1;  ///< where the next pass begins, from where the last did
constexpr int kPatience = 3;       ///< passes without progress that end the first search
constexpr int kLaterPatience = 2;  ///< ... and those for the noise that it found
constexpr double kSameCost = 1e-9;
/// Parameters under which no weight differs by more from those of the last round need none.
constexpr double kSameWeight = 0.1;
/// Flips are tried where chi2 is predicted to change by this share of the threshold (more
/// for edges that are kept, less than its inverse for others), until so many in a row have
/// brought nothing.
constexpr double kSuspicious = 0.5;
constexpr int kSuspects = 8;
constexpr int kNoiseRounds = 5;

}  // namespace

Evaluation Graduated::pass(WeightedRounds& rounds, double parameter, State& state) {
  const bool truncated = options_->graduation.kind == RobustEstimation::kTruncatedLeastSquares;
  while (!rounds.tools().must_stop()) {
    const bool decided = edges_.setWeights(parameter);
    if (truncated && decided && parameter > 1) break;
    if (rounds.weightsDiffer(kSameWeight)) {
      const Evaluation evaluation = rounds.run(WeightedRounds::Effort::kRough, state);
      if (!evaluation.ok()) return evaluation;
    }
    if (!truncated && parameter <= 1) break;
    parameter = truncated ? parameter * kSteeper : std::max(1.0, parameter / kSteeper);
  }
  edges_.setSides();
  return rounds.settle(state);
}

Evaluation Graduated::search(WeightedRounds& rounds, int patience, State& state) {
  const bool truncated = options_->graduation.kind == RobustEstimation::kTruncatedLeastSquares;
  Best best;
  best.cost = std::numeric_limits<double>::infinity();
  double parameter = 1;
  for (int worse = 0; worse < patience;) {
    Evaluation evaluation = pass(rounds, parameter, state);
    ++report_->passes;
    if (!evaluation.ok()) return evaluation;
    const double cost = edges_.truncatedCost(evaluation.chi2);
    worse = cost < best.cost * (1 - kSameCost) ? 0 : worse + 1;
    fprintf(stderr,"PASS mu %.3g rounds %d iters %d cpu %.2f cost %.8g noise %.3g\n",parameter,report_->rounds,report_->iterations,clock()/1e6,cost,report_->noise_factor);
    if (cost < best.cost) best = {cost, state, edges_.squares()};
    state = best.state;
    edges_.squares() = best.squares;
    if (rounds.tools().must_stop()) break;
    const double smoothest = edges_.smoothestParameter();
    if (truncated ? parameter <= smoothest : parameter >= smoothest) break;
    parameter = truncated ? std::max(parameter * kSmoother, smoothest)
                          : std::min(parameter / kSmoother, smoothest);
  }
  edges_.setSides();
  Evaluation evaluation = flipSuspects(rounds, true, state);
  fprintf(stderr,"FLIP1 rounds %d iters %d cpu %.2f\n",report_->rounds,report_->iterations,clock()/1e6);
  if (evaluation.ok()) evaluation = flipSuspects(rounds, false, state);
  fprintf(stderr,"FLIP2 rounds %d iters %d cpu %.2f\n",report_->rounds,report_->iterations,clock()/1e6);
  return evaluation;
}

std::vector<Graduated::Place> Graduated::findSuspects(const WeightedRounds& rounds, bool kept,
                                                      const State& state) {
  Innovations innovations(edges_.problem(), rounds.tools().pool);
  if (!innovations.begin(rounds.tools(), state)) return {};
  std::vector<Place> places;
  for (const Place& p : edges_.candidates()) {
    if ((edges_.weight(p) != 0) == kept) places.push_back(p);
  }
  std::vector<double> changes(places.size());
  if (kept) {
    changes = innovations.removals(places);
  } else {
    const std::vector<Innovations::View> views = innovations.sample(places);
    for (std::size_t i = 0; i < places.size(); ++i) changes[i] = views[i].square;
  }
  std::vector<std::pair<double, Place>> ranked;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double ratio = changes[i] / edges_.threshold(places[i]);
    if (kept ? ratio > kSuspicious : ratio * kSuspicious < 1) {
      ranked.emplace_back(kept ? -ratio : ratio, places[i]);
    }
  }
  std::sort(ranked.begin(), ranked.end());
  places.clear();
  for (const auto& one : ranked) places.push_back(one.second);
  return places;
}

Evaluation Graduated::flipSuspects(WeightedRounds& rounds, bool kept, State& state) {
  Evaluation evaluation = rounds.tools().linearizer.evaluate(state);
  double cost = edges_.truncatedCost(evaluation.chi2);
  std::set<Place> known;
  std::vector<Place> suspects = findSuspects(rounds, kept, state);
  std::size_t next = 0;
  for (int failures = 0; failures < kSuspects && evaluation.ok() && !rounds.tools().must_stop();) {
    while (next < suspects.size() && known.count(suspects[next]) > 0) ++next;
    if (next == suspects.size()) break;
    known.insert(suspects[next]);
    const State before = state;
    const RobustEdges::Numbers squares = edges_.squares();
    edges_.setWeight({suspects[next]}, kept ? 0 : 1);
    const Evaluation flipped = rounds.settle(state);
    const double flipped_cost = edges_.truncatedCost(flipped.chi2);
    if (flipped.ok() && flipped_cost < cost * (1 - kSameCost)) {
      evaluation = flipped;
      cost = flipped_cost;
      failures = 0;
      suspects = findSuspects(rounds, kept, state);
      next = 0;
      continue;
    }
    ++failures;
    state = before;
    edges_.squares() = squares;
    edges_.setSides();
    if (!flipped.ok()) evaluation = flipped;
  }
  return evaluation;
}

/// Edges that agree, or the start given where that costs less.
Evaluation Graduated::begin(WeightedRounds& rounds, State& state) {
  const Linearizer& linearizer = rounds.tools().linearizer;
  const State given = state;
  Evaluation evaluation;
  Consensus consensus(edges_, rounds);
  if (consensus.grow(state, evaluation)) {
    fprintf(stderr,"GROWN rounds %d iters %d cpu %.2f noise %.3g\n",report_->rounds,report_->iterations,clock()/1e6,report_->noise_factor);
    evaluation = edges_.truncatedCost(linearizer, given);
    const Evaluation grown = edges_.truncatedCost(linearizer, state);
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
    evaluation = search(rounds, i == 0 ? kPatience : kLaterPatience, state);
    if (evaluation.ok() && !edges_.fitNoise(evaluation.chi2, false)) break;
  }
  if (evaluation.ok()) edges_.reportOff();
  return evaluation;
}

}  // namespace graft
