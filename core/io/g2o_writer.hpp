// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/graph/graph.hpp"

namespace graft {

/// Folders that relative file names of resources refer to: those in the graph,
/// and where the text will lie. Equal folders change nothing.
struct ResourceFolders {
  std::string graph = ".";
  std::string text = ".";
};

/// The graph as g2o text: resources by rising id, vertices by rising id (each
/// followed by its FIX line), edges by tag, ids, measurement and information.
/// Numbers are the shortest that read back exactly, so that the text depends on
/// the graph alone, and reading and writing it again gives the same bytes.
/// A token of a resource that names a file in `folders.graph` is written relative
/// to `folders.text`, so that it names the same file.
std::string formatG2o(const Graph& graph, const Values& values,
                      const ResourceFolders& folders = {});

}  // namespace graft
