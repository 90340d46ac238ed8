// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/consensus.hpp"

#include <algorithm>
#include <cmath>

namespace graft {

namespace {

/// The share of those left that is considered next.
constexpr std::size_t kShare = 8;
/// What is predicted with at most twice the deviation of its own noise needs no turn.
const double kTight = 2 * std::log(2.0);
/// Of the worst error in multiples of the threshold: what is above goes at once.
constexpr double kWorst = 0.5;

}  // namespace

bool Consensus::grow(State& state, Evaluation& evaluation) {
  edges_->trustOnly();
  const State before = state;
  evaluation = rounds_->run(WeightedRounds::Effort::kExact, state);
  while (evaluation.ok() && !rounds_->tools().must_stop()) {
    if (!innovations_.begin(rounds_->tools(), state)) {
      state = before;
      return false;
    }
    const std::vector<Place> places = choose(findOpen());
    if (places.empty()) break;
    evaluation = admit(places, state);
    if (evaluation.ok()) edges_->fitNoise(evaluation.chi2, true);
  }
  return evaluation.ok();
}

Evaluation Consensus::regrow(Place without, State& state, bool& any) {
  edges_->setWeight({without}, 0);
  all_considered_ = true;
  evicted_ = {without};
  any = false;
  Evaluation evaluation = rounds_->run(WeightedRounds::Effort::kFair, state);
  while (evaluation.ok() && !rounds_->tools().must_stop() &&
         innovations_.begin(rounds_->tools(), state)) {
    const std::vector<Place> places = choose(findOpen());
    if (places.empty()) break;
    any = true;
    evaluation = admit(places, state);
  }
  return evaluation;
}

/// The edges that may come into use, best predicted first.
std::vector<Consensus::Open> Consensus::findOpen() {
  std::vector<Open> open;
  for (const Place& p : edges_->candidates()) {
    if (edges_->weight(p) == 0 && evicted_.count(p) == 0) open.push_back({p, {}});
  }
  std::vector<Place> places;
  places.reserve(open.size());
  for (const Open& one : open) places.push_back(one.place);
  const std::vector<Innovations::View> views = innovations_.sample(places);
  for (std::size_t i = 0; i < open.size(); ++i) open[i].view = views[i];
  std::sort(open.begin(), open.end());
  return open;
}

/// Those whose turn it is, or was, and that agree; more turns until there are some.
std::vector<Consensus::Place> Consensus::choose(const std::vector<Open>& open) {
  std::vector<Place> chosen;
  if (considered_.empty() && !all_considered_) presumeNoise(open);
  std::size_t left = 0;
  for (const Open& one : open) left += isConsidered(one.place) ? 0 : 1;
  const std::size_t turn = std::max<std::size_t>(1, left / kShare);
  std::size_t next = 0;
  for (const Open& one : open) {
    if (!isConsidered(one.place)) {
      if (next >= turn && one.view.spread > kTight && !chosen.empty()) continue;
      if (next >= turn && one.view.spread > kTight) next = 0;
      ++next;
      considered_.insert(one.place);
    }
    if (one.view.square <= edges_->threshold(one.place)) chosen.push_back(one.place);
  }
  return chosen;
}

/// Before there is an edge in use to tell the noise: thresholds for that of those whose turn
/// is first.
void Consensus::presumeNoise(const std::vector<Open>& open) {
  std::vector<std::pair<Place, double>> squares;
  for (const Open& one : open) {
    if (squares.size() >= open.size() / kShare && one.view.spread > kTight) break;
    squares.emplace_back(one.place, one.view.square);
  }
  edges_->presumeNoise(squares);
}

Evaluation Consensus::admit(const std::vector<Place>& places, State& state) {
  edges_->setWeight(places, 1);
  bool fair = false;
  for (;;) {
    Evaluation evaluation =
        rounds_->run(fair ? WeightedRounds::Effort::kFair : WeightedRounds::Effort::kRough, state);
    if (!evaluation.ok() || rounds_->tools().must_stop()) return evaluation;
    const std::vector<Place> beyond = findWorst();
    if (beyond.empty()) return evaluation;
    if (fair) {
      edges_->setWeight(beyond, 0);
      evicted_.insert(beyond.begin(), beyond.end());
    }
    fair = !fair;
  }
}

/// The edges in use that are beyond their thresholds, those by far if there are some.
std::vector<Consensus::Place> Consensus::findWorst() const {
  double limit = 1;
  std::vector<Place> used;
  for (const Place& p : edges_->candidates()) {
    if (edges_->weight(p) == 0) continue;
    used.push_back(p);
    limit = std::max(limit, kWorst * edges_->ratio(p));
  }
  const auto within = [&](Place p) { return edges_->ratio(p) <= limit; };
  used.erase(std::remove_if(used.begin(), used.end(), within), used.end());
  return used;
}

}  // namespace graft
