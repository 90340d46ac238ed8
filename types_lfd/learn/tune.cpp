// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/learn/tune.hpp"

#include <algorithm>
#include <cmath>

#include "types_lfd/learn/result_json.hpp"

namespace graft::lfd {

namespace {

void multiply(Sigma& sigma, double weight) {
  sigma.t /= std::sqrt(weight);
  sigma.r /= std::sqrt(weight);
}

/// True if a is as good as b in all and better in one.
bool dominates(const TuneTrial& a, const TuneTrial& b) {
  const double values_a[] = {a.table.gripper_grasp_m, a.table.gripper_hand_m.value_or(0),
                             -a.table.kinematically_achievable};
  const double values_b[] = {b.table.gripper_grasp_m, b.table.gripper_hand_m.value_or(0),
                             -b.table.kinematically_achievable};
  bool better = false;
  for (int k = 0; k < 3; ++k) {
    if (values_a[k] > values_b[k]) return false;
    better = better || values_a[k] < values_b[k];
  }
  return better;
}

}  // namespace

void markBest(std::vector<TuneTrial>& trials) {
  for (TuneTrial& trial : trials) {
    trial.best = std::none_of(trials.begin(), trials.end(),
                              [&](const TuneTrial& other) { return dominates(other, trial); });
  }
}

std::vector<TuneTrial> tuneWeights(const RecordedTask& recorded, std::size_t mode,
                                   const std::string& resource_directory, Registry& registry,
                                   const LearnOptions& options, const TuneOptions& grid) {
  LearnOptions once = options;
  once.progress = nullptr;
  once.snapshots.clear();
  once.optimize_only = true;
  std::vector<TuneTrial> trials;
  const auto count = double(grid.grasp_quality.size() * grid.reachability.size());
  for (const double grasp_quality : grid.grasp_quality) {
    for (const double reachability : grid.reachability) {
      if (options.interrupt != nullptr && options.interrupt->load() != 0) break;
      if (options.progress) options.progress("tune", double(trials.size()) / count);
      RecordedTask changed = recorded;
      multiply(changed.task.weights.grasp_quality, grasp_quality);
      multiply(changed.task.weights.reachability, reachability);
      Diagnostics quiet;  // said already when the task's own weights were learned
      const LearnResult result = learn(changed, mode, resource_directory, registry, quiet, once);
      TuneTrial trial;
      trial.grasp_quality = grasp_quality;
      trial.reachability = reachability;
      trial.table = result.table_optimized;
      trial.iterations = result.summary.iterationCount();
      trial.chi2 = result.summary.chi2_final;
      trials.push_back(trial);
    }
  }
  markBest(trials);
  return trials;
}

std::string formatTuning(const std::vector<TuneTrial>& trials) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const TuneTrial& trial : trials) {
    list.push_back({{"grasp_quality", trial.grasp_quality},
                    {"reachability", trial.reachability},
                    {"iterations", trial.iterations},
                    {"chi2", trial.chi2},
                    {"best", trial.best},
                    {"table1", table1Json(trial.table)}});
  }
  return nlohmann::ordered_json({{"trials", list}}).dump(2) + "\n";
}

}  // namespace graft::lfd
