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
  /// Stop after the optimization: `after` and table_optimized are there, nothing
  /// that comes later.
  bool optimize_only = false;
  /// Told which phase runs and how far it is (0..1).
  std::function<void(const std::string& phase, double fraction)> progress;
};

/// A task read up to its segments, and the ways in which it is demonstrated.
struct RecordedTask {
  PreparedTask task;
  RecordedHolds holds;
  double seconds = 0;  ///< that reading took
};

/// The stages before the choice of a way of holding the object. Throws as
/// prepareTask() does.
RecordedTask readRecordings(const std::string& task_path, Diagnostics& diagnostics);

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
  PreparedTask task;  ///< with the demonstrations of the learned mode only
  TaskScene scene;
  RecordedHolds holds;   ///< of all demonstrations
  std::size_t mode = 0;  ///< the one of holds.modes that was learned
  /// False where no two demonstrations hold the object alike; then `task` has all
  /// demonstrations and all below is empty.
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

/// Runs all stages after reading on one of `recorded.holds.modes`. The files that
/// the graph's resources name are written to `resource_directory`/resources
/// (`resource_directory` must exist), so that graph.g2o beside that folder is
/// self-contained. Throws Error; Error(kNoResult) where the solver fails.
LearnResult learn(const RecordedTask& recorded, std::size_t mode,
                  const std::string& resource_directory, Registry& registry,
                  Diagnostics& diagnostics, const LearnOptions& options = LearnOptions());

/// What is known where no two demonstrations hold the object alike.
LearnResult withoutCommonGrasp(const RecordedTask& recorded);

/// Reads a task and learns the mode that most demonstrations show.
LearnResult learn(const std::string& task_path, const std::string& resource_directory,
                  Registry& registry, Diagnostics& diagnostics,
                  const LearnOptions& options = LearnOptions());

/// The stages up to the graph alone, as `learn` does them for the mode that most
/// demonstrations show. Throws Error(kNoResult) where no two hold the object alike.
struct BuiltGraph {
  std::string text;                           ///< graph.g2o
  std::map<std::string, std::size_t> counts;  ///< vertices and edges by tag
};
BuiltGraph buildTaskGraph(const std::string& task_path, const std::string& resource_directory,
                          Registry& registry, Diagnostics& diagnostics);

}  // namespace graft::lfd
