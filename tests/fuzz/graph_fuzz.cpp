// SPDX-License-Identifier: BSD-3-Clause
// Graph files, g2o and TORO: whatever is loaded is written, read again and written
// the same; what the strict reader takes, the lenient one takes.
#include <cmath>

#include "core/io/g2o_writer.hpp"
#include "core/io/graph_loader.hpp"
#include "core/plugin/engine.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace graft::fuzz {

namespace {

Engine& engine() {
  static Engine engine = [] {
    PluginOptions options;
    options.use_environment = false;
    return Engine(options);
  }();
  return engine;
}

/// The text that is written of what was read; empty if it was refused.
std::string rewritten(std::string_view bytes, const LoadOptions& options) {
  const File file(bytes);
  std::string text;
  const bool taken = accepts([&](Diagnostics& diagnostics) {
    const LoadedGraph loaded = loadGraph(file.path(), engine().registry(), options, diagnostics);
    text = formatG2o(loaded.graph, loaded.values);
  });
  return taken ? text : std::string();
}

}  // namespace

void fuzzOne(std::string_view bytes) {
  LoadOptions forgiving;
  forgiving.lenient = true;
  forgiving.project_information = true;
  const std::string strict = rewritten(bytes, LoadOptions());
  const std::string lenient = rewritten(bytes, forgiving);
  require(strict.empty() || !lenient.empty(), "the lenient reader refuses what the strict takes");
  for (const std::string& text : {strict, lenient}) {
    if (text.empty()) continue;
    const std::string again = rewritten(text, LoadOptions());
    require(!again.empty(), "what was written is refused:\n" + text);
    require(again == text,
            "written, read and written again it is not the same:\n" + text + "\nis now\n" + again);
  }
}

}  // namespace graft::fuzz
