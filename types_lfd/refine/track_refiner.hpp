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
  bool fast(const Path& path, std::size_t i) const;

  Path asOptimized() const;
  Path planCoarsely(const Path& optimized);
  void fillBetween(Path& path, std::size_t begin, std::size_t end) const;
  void replanBadStretches(Path& path, std::size_t margin) const;
  void smooth(Path& path) const;
  bool improve(Path& path, std::size_t i, const BaseOffset& offset) const;
  RefinedTrack summarize(Path path) const;

  const DemonstrationEstimate& demo_;
  const RefineOptions& options_;
  Placement placement_;
  std::vector<BaseOffset> lattice_;
  std::vector<Eigen::VectorXd> postures_;
};

}  // namespace graft::lfd
