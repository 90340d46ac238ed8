// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <vector>

#include "core/solve/innovations.hpp"
#include "core/solve/weighted_rounds.hpp"

namespace graft {

/// Where graduation begins: a set of edges that agree, grown from the trusted ones.
///
/// In every round the edges that are not in use are compared with what those in use
/// predict, in the measure of the prediction's covariance (see Innovations). The ones that
/// are predicted best come first, an eighth of those left at a time: by chance a
/// false edge seldom falls where little is possible, while long loops, where much is, wait
/// until shorter ones have taken the uncertainty away. Who agrees comes into use, the
/// estimates follow, and who is then beyond its threshold goes for good, the worst first.
class Consensus {
 public:
  using Place = RobustEdges::Place;

  Consensus(RobustEdges& edges, WeightedRounds& rounds)
      : edges_(&edges), rounds_(&rounds), innovations_(edges.problem(), rounds.tools().pool) {}

  /// Grows the set and moves the state to its optimum, roughly; thresholds follow the noise
  /// that shows. False, with nothing changed but weights and squared errors, where the
  /// trusted edges do not determine every vertex.
  bool grow(State& state, Evaluation& evaluation);
  /// Takes one edge out of use and lets those come in that agree without it, with thresholds
  /// as they are; `any`: whether there are some.
  Evaluation regrow(Place without, State& state, bool& any);

 private:
  struct Open {
    Place place;
    Innovations::View view;
    bool operator<(const Open& other) const {
      if (view.spread != other.view.spread) return view.spread < other.view.spread;
      return place < other.place;
    }
  };
  std::vector<Open> findOpen();
  bool isConsidered(Place place) const { return all_considered_ || considered_.count(place) > 0; }
  std::vector<Place> choose(const std::vector<Open>& open);
  void presumeNoise(const std::vector<Open>& open);
  std::vector<Place> findWorst() const;
  Evaluation admit(const std::vector<Place>& places, State& state);

  RobustEdges* edges_;
  WeightedRounds* rounds_;
  Innovations innovations_;
  bool all_considered_ = false;
  std::set<Place> considered_;
  std::set<Place> evicted_;
};

}  // namespace graft
