// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "core/solve/linearizer.hpp"
#include "core/solve/summary.hpp"

namespace graft {

/// The edges of a problem that graduation may switch off ("candidates"): their thresholds,
/// last squared errors and weights. All others are trusted and always have weight 1.
///
/// The threshold c2 of an edge is the quantile of chi-square with the rank of its
/// information matrix, times a noise factor of at most 1.
class RobustEdges {
 public:
  using Place = EdgePlace;
  using Numbers = std::vector<std::vector<double>>;  ///< per group and edge

  /// Takes the robust kernels off the candidates. Throws Error(kUsage) for a tag of
  /// Graduation::trusted_tags that no edge has.
  RobustEdges(Problem& problem, const Graduation& options, GraduationReport& report);

  const std::vector<Place>& candidates() const { return candidates_; }
  double threshold(Place p) const { return thresholds_[p.first][p.second]; }
  /// Its last squared error e' Omega e, and the same as a multiple of the threshold.
  double square(Place p) const { return squares_[p.first][p.second]; }
  double ratio(Place p) const;
  double weight(Place p) const {
    return problem_->groups()[p.first].weight(std::int64_t(p.second));
  }
  Numbers& squares() { return squares_; }
  Numbers weights() const;
  Problem& problem() { return *problem_; }

  /// Gives weight 1 to the trusted edges and 0 to all others.
  void trustOnly();
  void setWeight(const std::vector<Place>& places, double weight);
  /// Graduated weights for the last squared errors (equations 12 and 14 of the paper);
  /// returns whether all are 0 or 1 (nearly).
  bool setWeights(double parameter);
  /// Those of truncated least squares proper; returns whether any has changed.
  bool setSides();
  /// Where the cost is nearly convex: remark 5 of the paper, at the last errors.
  double smoothestParameter() const;

  /// The sum of min(s, c2) if the edges in use have the sum `kept`.
  double truncatedCost(double kept) const;
  /// The same at a state: over trusted edges s as it is.
  Evaluation truncatedCost(const Linearizer& linearizer, const State& state) const;

  /// Fits the noise factor to the edges in use, whose F is `kept`: nine times their
  /// a-posteriori variance factor, but not more than 1 (a factor that is nearly right
  /// stays unless `always`). Returns whether thresholds have changed.
  bool fitNoise(double kept, bool always);
  /// The same from edges that are not in use, with what chi2 would rise by with each: as if a
  /// quarter or more of them were true.
  void presumeNoise(const std::vector<std::pair<Place, double>>& rises);
  /// Writes down which edges have weight 0.
  void reportOff() const;

 private:
  bool isTrusted(const EdgeGroup& group, std::int64_t edge) const;
  void rankVertices();
  void findCandidates();
  void findFreedoms();
  void findThresholds();
  bool setNoise(double variance, bool always);
  double weightOf(double square, double threshold, double parameter) const;

  Problem* problem_;
  const Graduation* options_;
  GraduationReport* report_;
  std::vector<Place> candidates_;
  std::vector<std::vector<std::int64_t>> ranks_;  ///< of a vertex among those of its type
  std::vector<std::vector<int>> freedoms_;        ///< rank of the information
  Numbers thresholds_;
  Numbers squares_;
};

}  // namespace graft
