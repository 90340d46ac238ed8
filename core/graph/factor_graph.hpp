// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/graph/graph.hpp"
#include "core/types/registry.hpp"

namespace graft {

/// A graph built in code by tags and ids. Graph and Values stay accessible for
/// everything else. All calls throw Error(kInput) for what does not fit, naming
/// tag and id.
class FactorGraph {
 public:
  explicit FactorGraph(Registry& registry) : registry_(registry) {}

  /// `estimate`: the type's numbers, empty = its identity.
  void addVertex(const std::string& tag, std::int64_t id, std::vector<double> estimate = {});
  /// `information`: upper triangle row by row, empty = identity. `resources`:
  /// ids given to addResource().
  EdgeId addEdge(const std::string& tag, const std::vector<std::int64_t>& vertices,
                 std::vector<double> measurement, std::vector<double> information = {},
                 const std::vector<std::int64_t>& resources = {});
  void removeEdge(EdgeId edge) { graph_.removeEdges({edge}); }
  /// Removes the edges that touch it, too; returns how many.
  std::size_t removeVertex(std::int64_t id) { return graph_.removeVertices({id}, values_); }
  /// `tokens` as in a file; relative file names are relative to `directory`.
  void addResource(const std::string& tag, std::int64_t id, std::vector<std::string> tokens,
                   const std::string& directory = ".");
  void fix(std::int64_t id, bool fixed = true);
  /// Puts a robust kernel on all edges, or on those of one tag.
  void setKernel(const std::string& name, double width, const std::string& tag = "");

  /// The numbers of a vertex.
  std::vector<double> estimate(std::int64_t id) const;
  void setEstimate(std::int64_t id, const std::vector<double>& numbers);

  const Graph& graph() const { return graph_; }
  Graph& graph() { return graph_; }
  const Values& values() const { return values_; }
  Values& values() { return values_; }

 private:
  VertexRef at(std::int64_t id) const;

  Registry& registry_;
  Graph graph_;
  Values values_;
};

}  // namespace graft
