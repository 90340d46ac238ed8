// SPDX-License-Identifier: BSD-3-Clause
// Stamp and metadata of plugin files: nothing of a file runs, and every refusal is the
// plugin's fault.
#include "core/plugin/plugin_file.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace graft::fuzz {

void fuzzOne(std::string_view bytes) {
  const File file(bytes);
  try {
    readPluginFile(file.path());
  } catch (const Error& error) {
    require(error.code() == ExitCode::kPlugin, "wrong exit code: " + error.formatted());
  }
  for (const Provided& provided : parseMetadata(std::string(bytes))) {
    require(std::string(metadataWord(provided.kind)).size() > 3, "a kind without a name");
  }
}

}  // namespace graft::fuzz
