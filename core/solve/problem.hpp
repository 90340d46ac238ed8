// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/graph/graph.hpp"
#include "core/solve/options.hpp"

namespace graft {

/// How the square root of an edge's information matrix is stored.
enum class RootShape : std::uint8_t { kIdentity, kDiagonal, kDense };

/// Edges of one type and one shape, in canonical order. Arrays over edges are
/// contiguous; pointers lead into the graph, which must outlive the problem.
struct EdgeGroup {
  const graft_edge_type* type = nullptr;
  int arity = 0;
  int error_dim = 0;
  int measurement_dim = 0;
  int tangent_dim = 0;            ///< of all slots together: columns of the Jacobian
  std::vector<int> slot_dims;     ///< arity
  std::vector<int> slot_offsets;  ///< arity, first column of a slot
  std::int64_t count = 0;

  std::vector<VertexRef> vertices;          ///< count x arity
  std::vector<std::int32_t> blocks;         ///< count x arity; -1 = not free
  std::vector<const double*> measurements;  ///< count
  std::vector<double> roots;                ///< count x error_dim^2, column-major
  std::vector<RootShape> root_shapes;       ///< count
  std::vector<double> information;          ///< count x error_dim^2, if type->associate
  std::vector<const void*> resources;       ///< count x resource_count
  std::vector<std::int32_t> kernels;        ///< count; index into Graph::kernels() or -1
  std::vector<std::int64_t> lines;          ///< count
  std::size_t block = 0;                    ///< of Graph::edgeBlocks()
  std::vector<std::int64_t> edges;          ///< count; place in that block
  /// count factors of rho, or empty = 1 each. An edge of weight 0 has no part in the
  /// normal equations and in initial guesses.
  std::vector<double> weights;

  double weight(std::int64_t edge) const {
    return weights.empty() ? 1.0 : weights[std::size_t(edge)];
  }
  /// "EDGE_SE3:QUAT 3 4 (line 17)".
  std::string describe(const Graph& graph, std::int64_t edge) const;
};

/// What an iteration changes: the estimates, and what the edges of every group
/// are associated with (count x association_dim numbers each).
struct State {
  Values values;
  std::vector<std::vector<double>> associations;
};

/// A graph prepared for solving. Free vertices are numbered by rising id; edges
/// are sorted by tag, vertex ids and content, so that every sum is formed in the
/// same order however the graph was put together.
class Problem {
 public:
  /// Throws Error(kInput) for an information matrix that is not positive
  /// semidefinite, unless `policy` says to project it. Only edges of `level` take
  /// part, or all if it is kAllLevels.
  Problem(const Graph& graph, InformationPolicy policy, std::int32_t level = 0);

  const Graph& graph() const { return *graph_; }
  const std::vector<EdgeGroup>& groups() const { return groups_; }
  /// Weights for the edges of a group, 0 or more. What was made of the normal equations'
  /// pattern before holds only as long as no edge comes back from 0.
  void setWeights(std::size_t group, std::vector<double> weights) {
    groups_[group].weights = std::move(weights);
  }
  /// Takes the robust kernel off an edge.
  void dropKernel(std::size_t group, std::int64_t edge) {
    groups_[group].kernels[std::size_t(edge)] = -1;
  }
  /// Vertices to be estimated: touched by an edge, not fixed, not held.
  const std::vector<VertexRef>& freeVertices() const { return free_; }
  const std::vector<std::int32_t>& dims() const { return dims_; }
  /// First entry of a block in a tangent vector; the last is the whole length.
  const std::vector<std::int64_t>& offsets() const { return offsets_; }
  std::int64_t dim() const { return offsets_.back(); }
  std::int32_t blockOf(VertexRef v) const {
    return blocks_[std::size_t(v.type)][std::size_t(v.index)];
  }
  /// "VERTEX_SE2 17".
  std::string describeVertex(VertexRef v) const;

  /// Vertices held fixed because nothing else fixes their component.
  const std::vector<VertexRef>& held() const { return held_; }
  /// Where estimates spread from: per component the fixed vertices, else the held one,
  /// else those with an edge of arity 1.
  const std::vector<VertexRef>& roots() const { return roots_; }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  void compileEdges(InformationPolicy policy, std::int32_t level);
  void compileBlock(std::size_t index, InformationPolicy policy, std::int32_t level);
  void appendInformation(EdgeGroup& group, const double* upper, InformationPolicy policy);
  void chooseGauge();
  void numberVertices();

  const Graph* graph_;
  std::vector<EdgeGroup> groups_;
  std::vector<VertexRef> free_;
  std::vector<std::int32_t> dims_;
  std::vector<std::int64_t> offsets_;
  std::vector<std::vector<std::int32_t>> blocks_;
  std::vector<VertexRef> held_;
  std::vector<VertexRef> roots_;
  std::vector<std::string> notes_;
  std::int64_t projected_ = 0;
};

}  // namespace graft
