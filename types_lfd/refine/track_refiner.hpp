// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "types_lfd/refine/path_plan.hpp"

namespace graft::lfd {

/// The last step for one demonstration; see refineBases.
class TrackRefiner {
 public:
  TrackRefiner(const DemonstrationEstimate& demo, const TaskScene& scene,
               const RefineOptions& options);

  RefinedTrack run();

 private:
  using Path = std::vector<Placed>;

  /// What is wrong in a stretch of a path: a number, 0 = nothing.
  double faults(const Path& path, std::size_t begin, std::size_t end) const;
  bool tupleGood(const Path& path, std::size_t i) const;
  /// From tuple i to i + 1.
  bool wayFree(const Path& path, std::size_t i) const;
  /// Speed of the fastest joint, or the base, as a share of what is allowed.
  double haste(const Path& path, std::size_t i) const;
  /// The larger of the steps to and from a tuple.
  double hasteAround(const Path& path, std::size_t i) const;

  Path asOptimized() const;
  std::vector<double> torsoHeights(const Path& optimized) const;
  /// The best path over torso heights, then over places far off.
  Path search(const Path& optimized);
  void fillBetween(Path& path, std::size_t begin, std::size_t end) const;
  /// How a bad stretch is planned again.
  struct Replan {
    std::size_t margin;  ///< tuples added on both sides
    std::size_t stride;  ///< between keys
    Spread spread;       ///< of the places that are tried
  };
  void replanBadStretches(Path& path, const Replan& replan) const;
  std::vector<std::size_t> keysFrom(std::size_t begin, std::size_t end, std::size_t stride) const;
  /// Plans bad stretches tuple by tuple, closely around the path and then
  /// with longer steps.
  void repair(Path& path) const;
  void smooth(Path& path) const;
  bool improve(Path& path, std::size_t i, const BaseOffset& offset) const;
  RefinedTrack summarize(Path path) const;

  const DemonstrationEstimate& demo_;
  const RefineOptions& options_;
  Placement placement_;
  std::vector<Eigen::VectorXd> postures_;
};

}  // namespace graft::lfd
