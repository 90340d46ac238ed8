// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/graph_description.hpp"

namespace graft::lfd {

std::map<std::string, std::size_t> GraphDescription::countsByTag() const {
  std::map<std::string, std::size_t> counts;
  for (const Vertex& v : vertices) ++counts[v.tag];
  for (const Edge& e : edges) ++counts[e.tag];
  return counts;
}

int GraphDescription::send(const graft_graph_sink& sink) const {
  for (const Resource& r : resources) {
    std::vector<const char*> tokens;
    for (const std::string& token : r.tokens) tokens.push_back(token.c_str());
    if (sink.add_resource(sink.host, r.tag, r.id, std::int32_t(tokens.size()), tokens.data(), 0) !=
        GRAFT_OK) {
      return GRAFT_FAILED;
    }
  }
  for (const Vertex& v : vertices) {
    if (sink.add_vertex(sink.host, v.tag, v.id, v.estimate.data(), std::int32_t(v.estimate.size()),
                        0) != GRAFT_OK) {
      return GRAFT_FAILED;
    }
  }
  for (const Edge& e : edges) {
    if (sink.add_edge(sink.host, e.tag, std::int32_t(e.vertices.size()), e.vertices.data(),
                      std::int32_t(e.resources.size()), e.resources.data(),
                      std::int32_t(e.measurement.size()), e.measurement.data(),
                      std::int32_t(e.information.size()), e.information.data(), 0) != GRAFT_OK) {
      return GRAFT_FAILED;
    }
  }
  return GRAFT_OK;
}

}  // namespace graft::lfd
