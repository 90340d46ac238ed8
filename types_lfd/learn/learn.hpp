// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/solve/summary.hpp"
#include "core/types/registry.hpp"
#include "types_lfd/build/graph_builder.hpp"
#include "types_lfd/build/grasp_modes.hpp"
#include "types_lfd/build/scene.hpp"
#include "types_lfd/eval/metrics.hpp"
#include "types_lfd/model/motion_model.hpp"
#include "types_lfd/refine/refine.hpp"

namespace graft::lfd {

struct LearnOptions {
  int iterations = 20;
  std::vector<int> snapshots{0, 1, 5, 20};
  int threads = 0;  ///< 0 = all processors; results do not depend on it
  const std::atomic<int>* interrupt = nullptr;
  /// Changes the task's weights before the graph is built.
  std::function<void(Weights&)> adjust_weights;
  /// Stop after the optimization: `after` and table_optimized are there, nothing
  /// that comes later.
  bool optimize_only = false;
  /// Told which phase runs and how far it is (0..1).
  std::function<void(const std::string& phase, double fraction)> progress;
};

/// The transforms that the graph estimates and the grasp that was chosen.
struct LearnedGrasp {
  Pose object_T_hand;
  Pose object_T_gripper;
  std::vector<Pose> hand_T_gripper;  ///< per demonstration
  GraspSet::Choice choice;           ///< by E6's metric
  GraspSet::Choice runner_up;        ///< best other row, index -1 if none
  int row = 0;
  int runner_up_row = -1;
  /// Marginal covariances (6 x 6, [translation; rotation]) by name; empty where
  /// they could not be computed.
  std::map<std::string, Eigen::MatrixXd> covariance;
};

/// Everything that was found out about a task.
struct LearnResult {
  PreparedTask task;
  TaskScene scene;
  GraspSpread spread;
  std::vector<GraspMode> modes;  ///< ways of holding the object, most demonstrations first
  /// False where the demonstrations hold the object in different ways; then all
  /// below is empty.
  bool common_grasp = true;
  std::vector<DemonstrationEstimate> before;
  std::vector<DemonstrationEstimate> after;  ///< optimized, bases refined
  RefineResult refinement;
  std::vector<IkTrack> joints;
  Table1 table_before;
  Table1 table_optimized;  ///< before the refinement
  Table1 table_after;
  double residual_per_dof = 0;
  LearnedGrasp grasp;
  Summary summary;
  std::map<int, std::vector<DemonstrationEstimate>> snapshots;
  MotionModel model;
  std::string graph;            ///< text of graph.g2o
  std::string graph_optimized;  ///< text of graph_optimized.g2o
  std::map<std::string, double> seconds;
};

/// Runs all stages. The files that the graph's resources name are written to
/// `resource_directory`/resources (which must exist), so that graph.g2o beside
/// that folder is self-contained. Throws Error; Error(kNoResult) where the
/// solver fails.
LearnResult learn(const std::string& task_path, const std::string& resource_directory,
                  Registry& registry, Diagnostics& diagnostics,
                  const LearnOptions& options = LearnOptions());

/// The stages up to the graph alone, as `learn` does them.
struct BuiltGraph {
  std::string text;                           ///< graph.g2o
  std::map<std::string, std::size_t> counts;  ///< vertices and edges by tag
};
BuiltGraph buildTaskGraph(const std::string& task_path, const std::string& resource_directory,
                          Registry& registry, Diagnostics& diagnostics);

/// Which demonstrations disagree about the grasp, and by how much; one line a
/// pair that is too far apart.
std::vector<std::string> describeDisagreement(const LearnResult& result);

}  // namespace graft::lfd
