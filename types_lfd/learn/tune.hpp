// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "types_lfd/learn/learn.hpp"

namespace graft::lfd {

/// Multiples of the task's own weights (1 / sigma^2) to try, each of the first
/// list with each of the second.
struct TuneOptions {
  /// Of E6, grasp quality, against E8, resemblance to the hand. The defaults hold
  /// the gripper at a sampled grasp within a tenth of a millimetre; only far lower
  /// weights let it come nearer to where the hand held the object.
  std::vector<double> grasp_quality{1.0 / 1024, 1.0 / 256, 1.0 / 64, 1.0 / 16, 0.25, 1, 4};
  /// Of E9, reachability.
  std::vector<double> reachability{0.25, 1, 4};
};

/// One pair of weights and what the optimization alone, without the last step
/// that moves bases, gives with it.
struct TuneTrial {
  double grasp_quality = 1;  ///< multiples of the weights
  double reachability = 1;
  Table1 table;
  int iterations = 0;
  double chi2 = 0;
  /// No other trial is as good in all and better in one of: distance gripper to
  /// grasp, distance gripper to hand, share of bases in reach.
  bool best = false;
};

/// The trade-off between a sure grasp, a motion like the person's and bases in
/// reach (Pareto front over the grid). Trials in the order of the lists, E6
/// outermost; `options` is passed on, with its progress as share of all trials.
/// Ends early, with the trials so far, where options.interrupt is set.
/// The other arguments are as in learn().
std::vector<TuneTrial> tuneWeights(const RecordedTask& recorded, std::size_t mode,
                                   const std::string& resource_directory, Registry& registry,
                                   const LearnOptions& options,
                                   const TuneOptions& grid = TuneOptions());

/// Sets TuneTrial::best.
void markBest(std::vector<TuneTrial>& trials);

/// tune.json: {"trials": [{grasp_quality, reachability, iterations, chi2, table1,
/// best}]}.
std::string formatTuning(const std::vector<TuneTrial>& trials);

}  // namespace graft::lfd
