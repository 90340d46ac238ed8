// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/graph/graph.hpp"

namespace graft {

/// The graph as g2o text: resources by rising id, vertices by rising id (each
/// followed by its FIX line), edges by tag, ids, measurement and information.
/// Numbers are the shortest that read back exactly, so that the text depends on
/// the graph alone, and reading and writing it again gives the same bytes.
std::string formatG2o(const Graph& graph, const Values& values);

}  // namespace graft
