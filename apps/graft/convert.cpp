// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft/commands.hpp"
#include "apps/graft/convert_formats.hpp"
#include "apps/graft/engine_options.hpp"
#include "core/base/file.hpp"
#include "core/io/g2o_writer.hpp"

namespace graft {

namespace {

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
  const Converted converted = options.format == "tum"     ? formatTumPoses(loaded)
                              : options.format == "kitti" ? formatKittiPoses(loaded)
                                                          : formatToro(loaded);
  if (converted.text.empty()) {
    throw Error(ExitCode::kNoResult, {options.input, 0, 0},
                "nothing in it can be written as " + options.format);
  }
  for (const auto& [tag, count] : converted.left_out) {
    printMessage("note", std::to_string(count) + " " + tag + " left out: " + options.format +
                             " has nothing like it");
  }
  writeFileAtomically(options.output, converted.text);
  return ExitCode::kSuccess;
}

}  // namespace

void addConvert(Program& program) {
  auto options = std::make_shared<ConvertOptions>();
  CLI::App* command = program.add(
      "convert", "Write a graph in graft's canonical form, as TORO's, or its poses as a track",
      [options] { return run(*options); });
  command->add_option("IN", options->input, "Graph file, - = stdin")->required();
  command->add_option("-o,--output", options->output, "Output file, - = stdout")->required();
  command
      ->add_option(
          "--to", options->format,
          "g2o; toro (VERTEX2, EDGE2, VERTEX3, EDGE3); or poses: tum (the id is the stamp), "
          "kitti (3 x 4 matrices)")
      ->check(CLI::IsMember({"g2o", "toro", "tum", "kitti"}))
      ->capture_default_str();
  options->engine.addPluginOption(*command);
  options->engine.addLoadOptions(*command);
}

}  // namespace graft
