// SPDX-License-Identifier: BSD-3-Clause
#include "core/types/plugin.hpp"

#include "core/base/error.hpp"
#include "core/base/file.hpp"
#include "plugins/toro/toro_reader.hpp"

namespace graft::toro {

namespace {

int recognizes(const char* path, const char* head, std::int64_t size) {
  return looksLikeToro(path, {head, static_cast<std::size_t>(size)}) ? 1 : 0;
}

int load(const char* path, const graft_graph_sink* sink) {
  try {
    const std::string text = readFile(path);
    return readToro(text, *sink) ? GRAFT_OK : GRAFT_FAILED;
  } catch (const std::exception& error) {
    sink->report(sink->host, 2, nullptr, 0, 0, error.what());
    return GRAFT_FAILED;
  }
}

const graft_loader_type kLoader = {sizeof(graft_loader_type),
                                   "toro",
                                   "TORO's graphs: VERTEX2, EDGE2, VERTEX3, EDGE3",
                                   ".graph",
                                   &recognizes,
                                   &load};

}  // namespace

}  // namespace graft::toro

GRAFT_PLUGIN(toro, registry) { registry.addLoader(graft::toro::kLoader); }
