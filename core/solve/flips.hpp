// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <set>
#include <vector>

#include "core/solve/consensus.hpp"
#include "core/solve/weighted_rounds.hpp"

namespace graft {

/// Tries a settled state of truncated least squares with single edges on the other side, and
/// lets be what lowers the sum of min(s, c2). An edge that is hardly checked by others pulls
/// the estimates to itself: false, it is kept with a small error; true, it is missed with a
/// large one. Innovations tell which edges are worth a try.
class Flips {
 public:
  Flips(RobustEdges& edges, WeightedRounds& rounds) : edges_(&edges), rounds_(&rounds) {}

  /// Leaves the best state, settled. Returns F there, or why a round failed. What brought
  /// nothing is not tried again.
  Evaluation run(State& state);

 private:
  using Place = RobustEdges::Place;
  enum class Kind {
    kContradicted,  ///< in use, while chi2 would fall by more than the threshold without it
    kMissed,        ///< not in use, while chi2 would rise by less than the threshold with it
    kUnchecked,     ///< in use, while others hardly say what it should measure
    kUnpredicted    ///< not in use, and the same
  };
  static bool isOff(Kind kind) { return kind == Kind::kMissed || kind == Kind::kUnpredicted; }
  /// The most promising first, for missed ones those that are a near thing, too.
  std::vector<Place> find(Kind kind, const State& state) const;
  /// Settles with an edge on the other side; false if it fails or would not stay there.
  bool flip(Kind kind, Place place, State& state, Evaluation& evaluation);
  /// Whether some flip of a kind has lowered the cost.
  bool tryAll(Kind kind, State& state, Evaluation& evaluation);

  RobustEdges* edges_;
  WeightedRounds* rounds_;
  std::array<std::set<Place>, 4> tried_;  ///< by kind
};

}  // namespace graft
