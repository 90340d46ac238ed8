// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/types/abi.h"

namespace graft::lfd {

/// A factor graph as plain lists, with types by tag: what the builder makes and
/// what is sent to the engine, whether by the learner's program or by the
/// plugin's loader of task files.
struct GraphDescription {
  struct Vertex {
    const char* tag;
    std::int64_t id;
    std::vector<double> estimate;
  };
  struct Resource {
    const char* tag;
    std::int64_t id;
    std::vector<std::string> tokens;
  };
  struct Edge {
    const char* tag;
    std::vector<std::int64_t> vertices;
    std::vector<std::int64_t> resources;
    std::vector<double> measurement;
    std::vector<double> information;  ///< upper triangle, row by row
  };
  std::vector<Vertex> vertices;
  std::vector<Resource> resources;
  std::vector<Edge> edges;

  std::map<std::string, std::size_t> countsByTag() const;
  /// Passes everything on; GRAFT_FAILED as soon as the host says so.
  int send(const graft_graph_sink& sink) const;
};

}  // namespace graft::lfd
