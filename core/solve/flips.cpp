// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/flips.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/solve/innovations.hpp"

namespace graft {

namespace {

constexpr double kSameCost = 1e-9;
/// Flips in a row that bring nothing end the search.
constexpr int kFailures = 8;
constexpr int kUncheckedFailures = 16;
/// A sample tells by what chi2 rises to some ten per cent.
constexpr double kSlack = 1.25;
/// What others tell with less than a quarter of its precision is hardly checked by them.
constexpr double kHardlyChecked = 1.0 / 16;
const double kHardlyPredicted = -std::log(kHardlyChecked);
/// Ten times the deviation that is allowed: too far for the prediction to be so wrong.
constexpr double kFarOff = 100;
constexpr int kRepetitions = 3;

}  // namespace

std::vector<Flips::Place> Flips::find(Kind kind, const State& state) const {
  Innovations innovations(edges_->problem(), rounds_->tools().pool);
  std::vector<Place> places;
  for (const Place& p : edges_->candidates()) {
    if ((edges_->weight(p) == 0) == isOff(kind)) places.push_back(p);
  }
  if (places.empty() || !innovations.begin(rounds_->tools(), state)) return {};
  std::vector<std::pair<double, Place>> ranked;
  if (isOff(kind)) {
    const std::vector<Innovations::View> views = innovations.sample(places);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double ratio = views[i].square / edges_->threshold(places[i]);
      const bool missed = ratio < kSlack;
      if (missed != (kind == Kind::kMissed)) continue;
      if (missed || (views[i].spread > kHardlyPredicted && ratio < kFarOff)) {
        ranked.emplace_back(ratio, places[i]);
      }
    }
  } else {
    const std::vector<Innovations::Removal> removals = innovations.removals(places);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double ratio = removals[i].fall / edges_->threshold(places[i]);
      const bool contradicted = ratio > 1;
      if (contradicted != (kind == Kind::kContradicted)) continue;
      if (contradicted) {
        ranked.emplace_back(-ratio, places[i]);
      } else if (removals[i].checked < kHardlyChecked) {
        ranked.emplace_back(removals[i].checked, places[i]);
      }
    }
  }
  std::sort(ranked.begin(), ranked.end());
  places.clear();
  for (const auto& one : ranked) places.push_back(one.second);
  return places;
}

bool Flips::flip(Kind kind, Place place, State& state, Evaluation& evaluation) {
  bool changed = true;
  if (kind == Kind::kUnchecked) {
    evaluation = Consensus(*edges_, *rounds_).regrow(place, state, changed);
  } else {
    edges_->setWeight({place}, kind == Kind::kContradicted ? 0 : 1);
    evaluation = rounds_->run(WeightedRounds::Effort::kFair, state);
    changed = isOff(kind) ? edges_->ratio(place) <= 1 : edges_->ratio(place) > 1;
  }
  if (!evaluation.ok() || !changed) return false;
  edges_->setSides();
  evaluation = rounds_->settle(state);
  return evaluation.ok();
}

bool Flips::tryAll(Kind kind, State& state, Evaluation& evaluation) {
  double cost = edges_->truncatedCost(evaluation.chi2);
  bool any = false;
  std::set<Place>& known = tried_[std::size_t(kind)];
  std::vector<Place> suspects = find(kind, state);
  std::size_t next = 0;
  const int patience = kind == Kind::kUnchecked ? kUncheckedFailures : kFailures;
  for (int failures = 0; failures < patience && !rounds_->tools().must_stop();) {
    while (next < suspects.size() && known.count(suspects[next]) > 0) ++next;
    if (next == suspects.size()) break;
    known.insert(suspects[next]);
    const State before = state;
    const RobustEdges::Numbers squares = edges_->squares();
    Evaluation flipped;
    const bool changed = flip(kind, suspects[next], state, flipped);
    const double flipped_cost = edges_->truncatedCost(flipped.chi2);
    if (changed && flipped_cost < cost * (1 - kSameCost)) {
      evaluation = flipped;
      cost = flipped_cost;
      any = true;
      failures = 0;
      suspects = find(kind, state);
      next = 0;
      continue;
    }
    ++failures;
    state = before;
    edges_->squares() = squares;
    edges_->setSides();
    if (flipped.ok()) continue;
    evaluation = flipped;
    break;
  }
  return any && evaluation.ok();
}

Evaluation Flips::run(State& state) {
  Evaluation evaluation = rounds_->tools().linearizer.evaluate(state);
  for (int i = 0; i < kRepetitions && evaluation.ok(); ++i) {
    bool any = false;
    for (const Kind kind :
         {Kind::kUnchecked, Kind::kUnpredicted, Kind::kContradicted, Kind::kMissed}) {
      if (evaluation.ok()) any = tryAll(kind, state, evaluation) || any;
    }
    if (!any) break;
  }
  return evaluation;
}

}  // namespace graft
