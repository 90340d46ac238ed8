// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/base/error.hpp"
#include "core/graph/graph.hpp"
#include "core/graph/information_policy.hpp"
#include "core/types/registry.hpp"

namespace graft {

/// Asking the registry for the loader of this name makes its resolver load
/// every plugin that has a loader; it never names one itself.
constexpr const char* kEveryLoader = "*";

struct LoadOptions {
  /// Lines with unknown tags are skipped, counted and reported instead of being
  /// errors. Nothing else is forgiven.
  bool lenient = false;
  /// Information matrices with a negative eigenvalue get zero in its place,
  /// each with a warning, instead of being errors.
  bool project_information = false;
};

struct LoadCounts {
  std::size_t vertices = 0;
  std::size_t edges = 0;
  std::size_t resources = 0;
  std::size_t fixed = 0;
  std::size_t skipped_lines = 0;     ///< unknown tags, lenient only
  std::size_t made_vertices = 0;     ///< see LoadedGraph::vertices_made
  std::size_t projected = 0;         ///< information matrices changed
  std::size_t zero_information = 0;  ///< edges without weight
  std::size_t isolated = 0;          ///< vertices without any edge
};

struct LoadedGraph {
  Graph graph;
  Values values;
  LoadCounts counts;
  /// The file had no vertex line; vertices were made along the edges and stand
  /// at their types' identity.
  bool vertices_made = false;
  std::string format;  ///< "g2o" or the name of the loader
};

/// Reads a graph from a file ("-" = standard input): the built-in reader for
/// g2o text, or the loader of a plugin that recognises the file. All defects
/// are collected in `diagnostics` with their lines; if there is an error, throws
/// InputErrors with all messages. On success `diagnostics` may hold warnings
/// and notes for the caller to print.
LoadedGraph loadGraph(const std::string& path, Registry& registry, const LoadOptions& options,
                      Diagnostics& diagnostics);

/// Folder that relative names in a graph file refer to.
std::string directoryOf(const std::string& path);

}  // namespace graft
