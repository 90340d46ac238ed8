// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft/commands.hpp"
#include "apps/graft/engine_options.hpp"
#include "core/base/file.hpp"
#include "core/base/text.hpp"
#include "core/io/g2o_writer.hpp"

namespace graft {

namespace {

/// Poses as TUM lines, the vertex id in the place of the stamp.
std::string formatPoses(const LoadedGraph& loaded, std::size_t& left_out) {
  std::string out;
  for (const VertexRef v : loaded.graph.verticesById()) {
    if (std::string(loaded.graph.type(v).tag) != "VERTEX_SE3:QUAT") {
      ++left_out;
      continue;
    }
    out += std::to_string(loaded.graph.id(v));
    for (int i = 0; i < 7; ++i) {
      out += ' ';
      appendDouble(out, loaded.values.at(v)[i]);
    }
    out += '\n';
  }
  return out;
}

struct ConvertOptions {
  EngineOptions engine;
  std::string input;
  std::string output;
  std::string format = "g2o";
};

ExitCode run(const ConvertOptions& options) {
  if (options.output != "-") checkWritable(options.output);
  const auto engine = makeEngine(options.engine);
  const LoadedGraph loaded = loadAndReport(options.input, *engine, options.engine);
  if (options.format == "g2o") {
    writeFileAtomically(options.output,
                        formatG2o(loaded.graph, loaded.values,
                                  {directoryOf(options.input), directoryOf(options.output)}));
    return ExitCode::kSuccess;
  }
  std::size_t left_out = 0;
  const std::string poses = formatPoses(loaded, left_out);
  if (poses.empty()) {
    throw Error(ExitCode::kNoResult, {options.input, 0, 0}, "there is no VERTEX_SE3:QUAT to write");
  }
  if (left_out > 0) {
    printMessage("note",
                 std::to_string(left_out) + " vertices are no VERTEX_SE3:QUAT and left out");
  }
  writeFileAtomically(options.output, poses);
  return ExitCode::kSuccess;
}

}  // namespace

void addConvert(Program& program) {
  auto options = std::make_shared<ConvertOptions>();
  CLI::App* command =
      program.add("convert", "Write a graph in graft's canonical form, or its poses as TUM",
                  [options] { return run(*options); });
  command->add_option("IN", options->input, "Graph file, - = stdin")->required();
  command->add_option("-o,--output", options->output, "Output file, - = stdout")->required();
  command->add_option("--to", options->format, "g2o, or tum (poses; the id is the stamp)")
      ->check(CLI::IsMember({"g2o", "tum"}))
      ->capture_default_str();
  options->engine.addPluginOption(*command);
  options->engine.addLoadOptions(*command);
}

}  // namespace graft
