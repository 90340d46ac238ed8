// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>

#include "apps/graft_lfd/commands.hpp"
#include "apps/graft_lfd/session.hpp"
#include "core/base/file.hpp"
#include "core/base/staged_directory.hpp"
#include "core/io/trajectory.hpp"
#include "types_lfd/demo/segments_file.hpp"
#include "types_lfd/learn/learn.hpp"
#include "types_lfd/learn/result_reader.hpp"
#include "types_lfd/model/model_file.hpp"

namespace graft::lfd {

namespace {

struct Options {
  std::string in;
  std::string out;
};

PreparedTask prepare(const std::string& path) {
  Diagnostics diagnostics;
  PreparedTask prepared = prepareTask(path, diagnostics);
  printMessages(diagnostics);
  return prepared;
}

ExitCode runMatch(const Options& options) {
  const PreparedTask prepared = prepare(options.in);
  StagedDirectory out(options.out);
  for (const PreparedDemonstration& demo : prepared.demonstrations) {
    const MatchedDemonstration& m = demo.matched;
    const auto write = [&](const char* name, const MatchedTrack& track) {
      out.write(m.name + "/" + name + ".tum", formatTum({m.times, track.poses}));
    };
    write("hand", m.hand);
    write("object", m.object);
    write("torso", m.torso);
    std::printf("%s: %zu tuples; measured: hand %zu, object %zu, torso %zu\n", m.name.c_str(),
                m.size(), m.hand.measuredCount(), m.object.measuredCount(),
                m.torso.measuredCount());
  }
  out.commit();
  return ExitCode::kSuccess;
}

ExitCode runSegment(const Options& options) {
  const PreparedTask prepared = prepare(options.in);
  std::vector<MatchedDemonstration> matched;
  std::vector<Segmentation> segments;
  for (const PreparedDemonstration& demo : prepared.demonstrations) {
    matched.push_back(demo.matched);
    segments.push_back(demo.segments);
  }
  writeFileAtomically(options.out, formatSegments(matched, segments));
  return ExitCode::kSuccess;
}

ExitCode runBuild(const Options& options) {
  Session session;
  StagedDirectory out(options.out);
  out.replaces({"graph.g2o", "resources"});
  Diagnostics diagnostics;
  const BuiltGraph built =
      buildTaskGraph(options.in, out.stagingPath(), session.registry(), diagnostics);
  printMessages(diagnostics);
  out.write("graph.g2o", built.text);
  out.commit();
  for (const auto& [tag, count] : built.counts) std::printf("%7zu %s\n", count, tag.c_str());
  return ExitCode::kSuccess;
}

ExitCode runFit(const Options& options) {
  const LearnedFolder folder = readLearnedFolder(options.in);
  Diagnostics diagnostics;
  const MotionModel model = fitMotionModel(folder.task.name, folder.demonstrations, diagnostics);
  printMessages(diagnostics);
  writeFileAtomically(options.out.empty() ? options.in + "/model.json" : options.out,
                      formatModel(model));
  for (const SegmentModel& segment : model.segments) {
    std::printf("%s: %d demonstrations, %d components, %.2f s\n", segment.name.c_str(),
                segment.demonstrations, int(segment.mixture.components.size()), segment.duration);
  }
  return ExitCode::kSuccess;
}

void addStage(Program& program, const char* name, const char* description, const char* in,
              const char* out, bool out_required, ExitCode (*run)(const Options&),
              const char* out_default = "") {
  auto options = std::make_shared<Options>();
  options->out = out_default;
  CLI::App* app = program.add(name, description, [options, run] { return run(*options); });
  app->add_option(in, options->in, "Input of this stage")->required();
  auto* output = app->add_option("-o,--output", options->out, out);
  if (out_required) output->required();
}

}  // namespace

void addStages(Program& program) {
  addStage(program, "match", "Bring the tracks of a task to common stamps", "TASK.xml",
           "Folder for DEMO/{hand,object,torso}.tum", true, &runMatch);
  addStage(program, "segment", "Find grasp and release in every demonstration", "TASK.xml",
           "segments.csv (default: standard output)", false, &runSegment, "-");
  addStage(program, "build", "Build the factor graph of a task", "TASK.xml",
           "Folder for graph.g2o and what it refers to", true, &runBuild);
  addStage(program, "fit", "Fit the motion models to a result folder's trajectories", "DIR",
           "model.json (default: that of the folder)", false, &runFit);
}

}  // namespace graft::lfd
