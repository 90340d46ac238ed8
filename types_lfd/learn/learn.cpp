// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/learn/learn.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/base/text.hpp"
#include "core/io/g2o_writer.hpp"
#include "core/io/graph_builder.hpp"
#include "core/solve/covariance.hpp"
#include "core/solve/optimizer.hpp"
#include "types_lfd/build/base_start.hpp"
#include "types_lfd/learn/result_reader.hpp"

namespace graft::lfd {

namespace {

using Clock = std::chrono::steady_clock;

/// Measures phases and passes their progress on.
class Phases {
 public:
  /// `reading`: seconds that reading the task took.
  Phases(LearnResult& result, const LearnOptions& options, double reading)
      : seconds_(result.seconds),
        options_(options),
        start_(Clock::now()),
        total_(start_),
        reading_(reading) {
    seconds_["prepare"] = reading;
  }

  void begin(const std::string& phase) {
    end();
    name_ = phase;
    start_ = Clock::now();
    report(0);
  }
  void report(double fraction) const {
    if (options_.progress) options_.progress(name_, fraction);
  }
  void end() {
    const auto now = Clock::now();
    if (!name_.empty()) seconds_[name_] += seconds(start_, now);
    seconds_["total"] = reading_ + seconds(total_, now);
    name_.clear();
  }

 private:
  static double seconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
  }

  std::map<std::string, double>& seconds_;
  const LearnOptions& options_;
  std::string name_;
  Clock::time_point start_;
  Clock::time_point total_;
  double reading_;
};

/// Hands the description to the engine exactly as a file would be.
LoadedGraph assemble(const GraphDescription& description, const std::string& path,
                     Registry& registry, Diagnostics& diagnostics) {
  const LoadOptions options;
  GraphBuilder builder(path, registry, options, diagnostics);
  const auto known = [&](const char* tag) -> const TagType& {
    const TagType& type = builder.tag(tag);
    if (!type.known()) {
      throw Error(ExitCode::kPlugin, std::string("no plugin provides ") + tag +
                                         " (is libgraft_lfd.so beside the program?)");
    }
    return type;
  };
  for (const auto& r : description.resources) builder.addResource(known(r.tag), r.id, r.tokens, 0);
  for (const auto& v : description.vertices) {
    builder.addVertex(known(v.tag), v.id, v.estimate.data(), int(v.estimate.size()), 0);
  }
  for (const auto& e : description.edges) {
    builder.addEdge(known(e.tag),
                    {e.vertices.data(), int(e.vertices.size()), e.resources.data(),
                     int(e.resources.size()), e.measurement.data(), int(e.measurement.size()),
                     e.information.data(), int(e.information.size())},
                    0);
  }
  LoadedGraph loaded = builder.finish();
  diagnostics.throwIfErrors();
  return loaded;
}

class Extractor {
 public:
  Extractor(const LearnResult& result, const Graph& graph)
      : result_(result), graph_(graph), layout_(result.task.demonstrations) {}

  Pose pose(const Values& values, std::int64_t id) const {
    return Pose::fromArray(values.at(graph_.find(id)));
  }
  const GraphLayout& layout() const { return layout_; }

  std::vector<DemonstrationEstimate> demonstrations(const Values& values) const {
    std::vector<DemonstrationEstimate> all = result_.before;
    for (std::size_t d = 0; d < all.size(); ++d) {
      for (std::size_t i = 0; i < all[d].size(); ++i) {
        const auto read = [&](GraphLayout::Entity entity) {
          return pose(values, layout_.vertex(d, i, entity));
        };
        all[d].hand[i] = read(GraphLayout::kHand);
        all[d].object[i] = read(GraphLayout::kObject);
        all[d].torso[i] = read(GraphLayout::kTorso);
        all[d].gripper[i] = read(GraphLayout::kGripper);
        all[d].base[i] =
            Pose2::fromArray(values.at(graph_.find(layout_.vertex(d, i, GraphLayout::kBase))));
      }
    }
    return all;
  }

 private:
  const LearnResult& result_;
  const Graph& graph_;
  GraphLayout layout_;
};

void extractGrasp(const Extractor& extractor, const Values& values, const Graph& graph, int threads,
                  LearnResult& result) {
  LearnedGrasp& grasp = result.grasp;
  grasp.object_T_hand = extractor.pose(values, GraphLayout::kHumanGrasp);
  grasp.object_T_gripper = extractor.pose(values, GraphLayout::kRobotGrasp);
  std::vector<std::int64_t> ids{GraphLayout::kHumanGrasp, GraphLayout::kRobotGrasp};
  std::vector<std::string> names{"object_T_hand", "object_T_gripper"};
  for (std::size_t d = 0; d < result.task.demonstrations.size(); ++d) {
    ids.push_back(extractor.layout().handToGripper(d));
    names.push_back("hand_T_gripper/" + result.task.demonstrations[d].matched.name);
    grasp.hand_T_gripper.push_back(extractor.pose(values, ids.back()));
  }
  const Sigma& metric = result.task.weights.grasp_quality;
  grasp.choice =
      result.scene.grasps->nearest(grasp.object_T_gripper, metric.t, metric.r, &grasp.runner_up);
  const auto& valid = result.scene.grasps->valid();
  grasp.row = valid[std::size_t(grasp.choice.index)].row;
  if (grasp.runner_up.index >= 0) {
    grasp.runner_up_row = valid[std::size_t(grasp.runner_up.index)].row;
  }
  std::vector<VertexRef> vertices;
  vertices.reserve(ids.size());
  for (const std::int64_t id : ids) vertices.push_back(graph.find(id));
  const std::vector<Eigen::MatrixXd> blocks =
      marginalCovariances(graph, values, vertices, {InformationPolicy::kError, threads});
  for (std::size_t k = 0; k < blocks.size(); ++k) grasp.covariance[names[k]] = blocks[k];
}

/// Says where the grasp is not the one that the optimizer went to at first.
void noteOtherGrasp(const LearnResult& result, Diagnostics& diagnostics) {
  double gain = 0;
  for (const IterationRecord& record : result.summary.iterations) {
    if (record.alternative) gain += record.chi2_change;
  }
  if (!(gain > 0)) return;
  diagnostics.note({}, "grasp: row " + std::to_string(result.grasp.row) + " lowers chi2 by " +
                           formatDouble(std::round(100 * gain) / 100) +
                           " against the one nearest to the person's (" +
                           std::to_string(result.summary.alternatives_tried) + " tried)");
}

/// The last step: bases where the arm reaches and nothing is hit, with the arm's
/// configurations.
void refine(LearnResult& result, const LearnOptions& options, Diagnostics& diagnostics) {
  RefineOptions refinement;
  refinement.threads = options.threads;
  result.refinement = refineBases(result.after, result.scene, refinement);
  for (std::size_t d = 0; d < result.after.size(); ++d) {
    result.after[d].base = result.refinement.tracks[d].base;
    result.joints.push_back(result.refinement.tracks[d].joints);
  }
  for (const std::string& note : result.refinement.notes) diagnostics.note({}, note);
}

void runOptimizer(LoadedGraph& loaded, Registry& registry, const LearnOptions& options,
                  const Extractor& extractor, const Phases& phases, LearnResult& result) {
  const auto wants = [&](int iteration) {
    return std::count(options.snapshots.begin(), options.snapshots.end(), iteration) > 0;
  };
  // 0 is what was demonstrated, before the base goes where the arm reaches.
  if (wants(0)) result.snapshots[0] = result.before;
  SolveOptions solve;
  solve.iterations = options.iterations;
  solve.threads = options.threads;
  solve.interrupt = options.interrupt;
  solve.callback = [&](const IterationRecord& record, const Values& values) {
    phases.report(double(record.iteration) / std::max(1, options.iterations));
    const int iteration = record.iteration;
    if (iteration > 0 && wants(iteration)) {
      result.snapshots[iteration] = extractor.demonstrations(values);
    }
    return true;
  };
  result.summary = optimize(loaded.graph, loaded.values, registry, solve);
  if (!result.summary.usable()) {
    throw Error(ExitCode::kNoResult, {result.task.task.path, 0, 0},
                "the optimization failed: " + result.summary.reason);
  }
  // A solve that converged early stays where it is.
  for (const int wanted : options.snapshots) {
    if (result.snapshots.count(wanted) == 0 && wanted <= options.iterations) {
      result.snapshots[wanted] = extractor.demonstrations(loaded.values);
    }
  }
}

}  // namespace

RecordedTask readRecordings(const std::string& task_path, Diagnostics& diagnostics) {
  const auto start = Clock::now();
  RecordedTask recorded;
  recorded.task = prepareTask(task_path, diagnostics);
  recorded.holds = recordedHolds(recorded.task.demonstrations);
  recorded.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return recorded;
}

BuiltGraph buildTaskGraph(const std::string& task_path, const std::string& resource_directory,
                          Registry& registry, Diagnostics& diagnostics) {
  const PreparedTask prepared = prepareUsualMode(task_path, diagnostics);
  const TaskScene scene = loadScene(prepared.task, diagnostics);
  const ResourceFiles files = writeSceneFiles(prepared.task, scene, resource_directory);
  const GraphDescription description = buildGraph(prepared, files, startBases(prepared, scene));
  const LoadedGraph loaded =
      assemble(description, resource_directory + "/graph.g2o", registry, diagnostics);
  return {formatG2o(loaded.graph, loaded.values), description.countsByTag()};
}

LearnResult withoutCommonGrasp(const RecordedTask& recorded) {
  LearnResult result;
  result.task = recorded.task;
  result.holds = recorded.holds;
  result.common_grasp = false;
  result.seconds = {{"prepare", recorded.seconds}, {"total", recorded.seconds}};
  return result;
}

LearnResult learn(const std::string& task_path, const std::string& resource_directory,
                  Registry& registry, Diagnostics& diagnostics, const LearnOptions& options) {
  const RecordedTask recorded = readRecordings(task_path, diagnostics);
  if (!recorded.holds.common()) return withoutCommonGrasp(recorded);
  warnOfLeftOut(recorded.task, recorded.holds, 0, diagnostics);
  return learn(recorded, 0, resource_directory, registry, diagnostics, options);
}

LearnResult learn(const RecordedTask& recorded, std::size_t mode,
                  const std::string& resource_directory, Registry& registry,
                  Diagnostics& diagnostics, const LearnOptions& options) {
  LearnResult result;
  Phases phases(result, options, recorded.seconds);
  result.holds = recorded.holds;
  result.mode = mode;
  result.task = taskOfMode(recorded.task, recorded.holds, mode, diagnostics);
  phases.begin("reachability");
  result.scene =
      loadScene(result.task.task, diagnostics, [&](double fraction) { phases.report(fraction); });
  phases.begin("build");
  const ResourceFiles files = writeSceneFiles(result.task.task, result.scene, resource_directory);
  LoadedGraph loaded =
      assemble(buildGraph(result.task, files, startBases(result.task, result.scene)),
               resource_directory + "/graph.g2o", registry, diagnostics);
  result.graph = formatG2o(loaded.graph, loaded.values);
  for (const PreparedDemonstration& demo : result.task.demonstrations) {
    result.before.push_back(estimateFromInput(demo));
  }
  const Scene scene{result.scene.grasps.get(), result.scene.reach.get(),
                    result.scene.footprint.get(), result.task.weights.grasp_quality};
  result.table_before = computeTable1(result.before, scene, true);

  phases.begin("optimize");
  const Extractor extractor(result, loaded.graph);
  runOptimizer(loaded, registry, options, extractor, phases, result);
  result.after = extractor.demonstrations(loaded.values);
  result.table_optimized = computeTable1(result.after, scene, false);
  if (options.optimize_only) {
    phases.end();
    return result;
  }
  result.graph_optimized = formatG2o(loaded.graph, loaded.values);

  phases.begin("refine");
  refine(result, options, diagnostics);

  phases.begin("evaluate");
  result.table_after = computeTable1(result.after, scene, false);
  result.table_after.ik_achievable =
      double(result.refinement.solved) / double(result.refinement.tuples);
  result.residual_per_dof = observationResidualPerDof(result.task.demonstrations, result.after);
  extractGrasp(extractor, loaded.values, loaded.graph, options.threads, result);
  noteOtherGrasp(result, diagnostics);
  phases.begin("fit");
  result.model = fitMotionModel(result.task.task.name, result.after, diagnostics);
  phases.end();
  return result;
}

}  // namespace graft::lfd
