// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/graph/values.hpp"
#include "core/types/abi.h"

namespace graft {

/// A robust kernel as edges refer to it.
struct Kernel {
  const graft_kernel_type* type = nullptr;
  double width = 1.0;
};

/// What names an edge as long as its graph lives; rises with every edge.
using EdgeId = std::int64_t;

/// All vertices of one type.
struct VertexBlock {
  const graft_vertex_type* type = nullptr;
  std::vector<std::int64_t> ids;
  std::vector<char> fixed;
  std::vector<std::int64_t> lines;  ///< line of the file it came from, 0 = none
};

/// All edges of one type. Arrays over edges are contiguous; the *_begin arrays
/// (one more entry than edges) delimit what each edge owns.
struct EdgeBlock {
  const graft_edge_type* type = nullptr;
  std::vector<std::int64_t> vertex_begin{0};
  std::vector<VertexRef> vertices;
  std::vector<std::int64_t> measurement_begin{0};
  std::vector<double> measurements;
  std::vector<std::int32_t> error_dims;
  std::vector<std::int64_t> information_begin{0};
  std::vector<double> information;      ///< upper triangle, row by row, as given
  std::vector<std::int32_t> resources;  ///< resource_count indices per edge
  std::vector<std::int32_t> kernels;    ///< index into Graph::kernels(), -1 = none
  std::vector<std::int32_t> levels;     ///< 0 or more; a solve takes the edges of one level
  std::vector<std::int64_t> lines;
  std::vector<EdgeId> ids;  ///< rising

  std::size_t size() const { return lines.size(); }
  int arity(std::size_t e) const { return int(vertex_begin[e + 1] - vertex_begin[e]); }
  int measurementDim(std::size_t e) const {
    return int(measurement_begin[e + 1] - measurement_begin[e]);
  }
};

/// A loaded resource; edges share it.
struct Resource {
  const graft_resource_type* type = nullptr;
  std::int64_t id = 0;
  std::vector<std::string> tokens;
  std::shared_ptr<const void> data;
};

/// Loads a resource by its type; null, with the reason in `message`, where the type refuses.
/// `directory`: what file names among the tokens are relative to.
std::shared_ptr<const void> loadResource(const graft_resource_type& type,
                                         const std::string& directory,
                                         const std::vector<std::string>& tokens,
                                         graft_message& message);

/// The structure of a factor graph: vertices with ids, edges with measurements
/// and information, resources. Estimates live apart, in Values. Every insertion
/// is checked and either succeeds or throws Error(kInput) and changes nothing.
class Graph {
 public:
  /// A new vertex; its estimate is appended to `values` (identity if null).
  /// Throws where the id exists, is negative, or the numbers are no estimate.
  VertexRef addVertex(const graft_vertex_type& type, std::int64_t id, const double* estimate,
                      Values& values, std::int64_t line = 0);

  /// What an edge is made of. `information`: upper triangle row by row, empty =
  /// identity.
  struct EdgeSpec {
    const graft_edge_type* type = nullptr;
    std::vector<VertexRef> vertices;
    std::vector<std::int32_t> resources;  ///< indices from addResource
    std::vector<double> measurement;
    std::vector<double> information;
    std::int32_t kernel = -1;
    std::int32_t level = 0;
    std::int64_t line = 0;
  };
  /// Checks arity, the vertex type of every slot, repeats, resource types and
  /// all dimensions, normalises the measurement. The information matrix is
  /// stored as given: factorInformation() judges it.
  EdgeId addEdge(EdgeSpec spec);

  /// Takes edges out. Throws Error(kInput), and changes nothing, where one is not in
  /// the graph. Costs a pass over all edges, so remove many at once.
  void removeEdges(std::vector<EdgeId> edges);
  /// Takes vertices and their estimates out, and all edges that touch them; returns how
  /// many edges. References to other vertices (VertexRef) change, their ids do not.
  /// Throws Error(kInput), and changes nothing, where a vertex is not in the graph.
  std::size_t removeVertices(const std::vector<std::int64_t>& ids, Values& values);

  std::int32_t addResource(const graft_resource_type& type, std::int64_t id,
                           std::vector<std::string> tokens, std::shared_ptr<const void> data);
  std::int32_t addKernel(const Kernel& kernel);
  /// Puts one kernel on all edges, or on those of one tag.
  void setKernel(const Kernel& kernel, const std::string& tag = "");
  /// Takes the kernels off all edges, or off those of one tag.
  void clearKernels(const std::string& tag = "");
  /// Puts an edge on a level: `edge` counts in edgeBlocks()[block].
  void setLevel(std::size_t block, std::size_t edge, std::int32_t level);
  void setFixed(VertexRef v, bool fixed);

  /// The vertex with an id; type -1 if there is none.
  VertexRef find(std::int64_t id) const;
  std::int64_t id(VertexRef v) const { return block(v).ids[std::size_t(v.index)]; }
  bool isFixed(VertexRef v) const { return block(v).fixed[std::size_t(v.index)] != 0; }
  const VertexBlock& block(VertexRef v) const { return vertex_blocks_[std::size_t(v.type)]; }
  const graft_vertex_type& type(VertexRef v) const { return *block(v).type; }

  const std::vector<VertexBlock>& vertexBlocks() const { return vertex_blocks_; }
  const std::vector<EdgeBlock>& edgeBlocks() const { return edge_blocks_; }
  const std::vector<Resource>& resources() const { return resources_; }
  const std::vector<Kernel>& kernels() const { return kernels_; }
  std::int32_t findResource(std::int64_t id) const;
  std::size_t vertexCount() const { return by_id_.size(); }
  std::size_t edgeCount() const;
  /// All vertices by rising id: the order of everything that must not depend on
  /// the order of insertion.
  std::vector<VertexRef> verticesById() const;

 private:
  int vertexBlockOf(const graft_vertex_type& type, Values& values);
  EdgeBlock& edgeBlockOf(const graft_edge_type& type);
  void checkEdge(EdgeSpec& spec, int& error_dim) const;

  std::vector<VertexBlock> vertex_blocks_;
  std::vector<EdgeBlock> edge_blocks_;
  std::vector<Resource> resources_;
  std::vector<Kernel> kernels_;
  std::unordered_map<std::int64_t, VertexRef> by_id_;
  std::unordered_map<std::int64_t, std::int32_t> resource_by_id_;
  EdgeId next_edge_ = 0;
};

/// Number of entries of the upper triangle of an n x n matrix.
constexpr std::int64_t triangleSize(std::int64_t n) { return n * (n + 1) / 2; }

}  // namespace graft
