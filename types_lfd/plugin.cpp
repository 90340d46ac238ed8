// SPDX-License-Identifier: BSD-3-Clause
#include "core/types/plugin.hpp"

#include <cstring>
#include <filesystem>

#include "core/base/error.hpp"
#include "types_lfd/build/base_start.hpp"
#include "types_lfd/build/graph_builder.hpp"
#include "types_lfd/build/grasp_modes.hpp"
#include "types_lfd/build/scene.hpp"
#include "types_lfd/edges/base_pose.hpp"
#include "types_lfd/edges/grasp_edges.hpp"
#include "types_lfd/edges/reachability_edge.hpp"
#include "types_lfd/edges/track_edges.hpp"

namespace graft::lfd {

namespace {

/// A task file as a graph: the same stages, the same choice among ways of holding
/// the object and the same builder as the learner's own program, so both hand the
/// same graph to the engine.
void loadTask(const char* path, const graft_graph_sink& sink) {
  Diagnostics diagnostics;
  const PreparedTask prepared = prepareUsualMode(path, diagnostics);
  const TaskScene scene = loadScene(prepared.task, diagnostics);
  for (const Diagnostics::Message& m : diagnostics.messages()) {
    sink.report(sink.host, m.severity == Diagnostics::Severity::kWarning ? 1 : 0,
                m.where.path.empty() ? nullptr : m.where.path.c_str(), m.where.line, m.where.column,
                m.text.c_str());
  }
  if (scene.reach_file.empty()) {
    throw Error(ExitCode::kOutput, {path, 0, 0},
                "the reachability map could not be stored (set GRAFT_CACHE_DIR to a folder that "
                "can be written)");
  }
  const auto absolute = [](const std::string& file) {
    return file.empty() ? file : std::filesystem::absolute(file).string();
  };
  const ResourceFiles files{absolute(prepared.task.grasps), absolute(scene.reach_file),
                            absolute(prepared.task.map)};
  buildGraph(prepared, files, startBases(prepared, scene)).send(sink);
}

int recognizesTask(const char*, const char* head, std::int64_t size) {
  const std::string_view text(head, static_cast<std::size_t>(size));
  return text.find("<task") != std::string_view::npos ? 1 : 0;
}

int loadTaskFile(const char* path, const graft_graph_sink* sink) {
  const auto report = [&](const char* text) {
    sink->report(sink->host, 2, nullptr, 0, 0, text);
    return GRAFT_FAILED;
  };
  try {
    loadTask(path, *sink);
    return GRAFT_OK;
  } catch (const InputErrors& errors) {
    return report(errors.what());
  } catch (const Error& error) {
    const SourceLocation& where = error.where();
    const int severity = error.code() == ExitCode::kNoResult ? 3 : 2;
    sink->report(sink->host, severity, where.path.empty() ? nullptr : where.path.c_str(),
                 where.line, where.column, error.what());
    return GRAFT_FAILED;
  } catch (const std::exception& error) {
    return report(error.what());
  }
}

constexpr graft_loader_type kTaskLoader = {sizeof(graft_loader_type),
                                           "task",
                                           "task folder of recorded demonstrations (task.xml)",
                                           ".xml",
                                           &recognizesTask,
                                           &loadTaskFile};

void addTypes(PluginRegistry& registry) {
  registry.addVertex<BasePose>();
  registry.addResource<GraspSet>();
  registry.addResource<ReachMap>();
  registry.addResource<FreeSpace>();
  registry.add<ObservationEdge>();
  registry.add<RelativeMotionEdge>();
  registry.add<SteadyMotionEdge>();
  registry.add<GripperSmoothEdge>();
  registry.add<BaseSmoothEdge>();
  registry.add<BasePriorEdge>();
  registry.add<HumanGraspEdge>();
  registry.add<TurnedHumanGraspEdge>();
  registry.add<RobotGraspEdge>();
  registry.add<GraspQualityEdge>();
  registry.add<HandGripperEdge>();
  registry.add<ResemblanceEdge>();
  registry.add<TurnedResemblanceEdge>();
  registry.add<GraspAgreementEdge>();
  registry.add<ReachabilityEdge>();
  registry.addLoader(kTaskLoader);
}

}  // namespace

}  // namespace graft::lfd

GRAFT_PLUGIN(lfd, registry) { graft::lfd::addTypes(registry); }
