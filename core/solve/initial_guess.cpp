// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/initial_guess.hpp"

#include <cmath>

#include "core/solve/edge_batch.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

/// One edge, by group and place in it.
struct EdgeRef {
  std::int32_t group;
  std::int32_t edge;
};

class Spreading {
 public:
  Spreading(const Problem& problem, const State& state) : problem_(problem), state_(state) {
    const Graph& graph = problem.graph();
    for (const VertexBlock& block : graph.vertexBlocks()) {
      placed_.emplace_back(block.ids.size(), 0);
      edges_.emplace_back(block.ids.size());
    }
    const auto& groups = problem.groups();
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (groups[g].type->propagate == nullptr) continue;
      some_without_weight_ = some_without_weight_ || !groups[g].weights.empty();
      for (std::int64_t e = 0; e < groups[g].count; ++e) {
        for (int k = 0; k < groups[g].arity; ++k) {
          const VertexRef v = groups[g].vertices[std::size_t(e * groups[g].arity + k)];
          edges_[std::size_t(v.type)][std::size_t(v.index)].push_back(
              {std::int32_t(g), std::int32_t(e)});
        }
      }
    }
  }

  SpreadResult run(const std::vector<VertexRef>& placed) {
    for (const VertexRef v : placed) place(v);
    placeRoots();
    follow();
    if (some_without_weight_) {
      // What the edges that count could not reach is placed by the others.
      every_edge_ = true;
      follow();
    }
    SpreadResult result;
    result.placed = placed_count_;
    for (const VertexRef v : problem_.freeVertices()) result.unplaced += isPlaced(v) ? 0 : 1;
    result.values = std::move(state_.values);
    return result;
  }

 private:
  char& isPlaced(VertexRef v) { return placed_[std::size_t(v.type)][std::size_t(v.index)]; }

  void place(VertexRef v) {
    isPlaced(v) = 1;
    queue_.push_back(v);
  }

  void placeRoots() {
    // What is not to be moved is known from the start.
    for (const EdgeGroup& group : problem_.groups()) {
      for (const VertexRef v : group.vertices) {
        if (problem_.blockOf(v) < 0) isPlaced(v) = 2;
      }
    }
    for (const VertexRef v : problem_.roots()) {
      if (isPlaced(v) == 0) {
        for (const EdgeRef& edge : edges_[std::size_t(v.type)][std::size_t(v.index)]) {
          if (problem_.groups()[std::size_t(edge.group)].arity == 1) reach(edge);
        }
      }
      if (isPlaced(v) != 1) place(v);
    }
  }

  void follow() {
    for (std::size_t next = 0; next < queue_.size(); ++next) {
      const VertexRef v = queue_[next];
      for (const EdgeRef& edge : edges_[std::size_t(v.type)][std::size_t(v.index)]) reach(edge);
    }
  }

  /// Places the vertices of an edge that are not placed yet, if it can.
  void reach(const EdgeRef& edge) {
    const EdgeGroup& group = problem_.groups()[std::size_t(edge.group)];
    if (!every_edge_ && group.weight(edge.edge) == 0) return;
    const VertexRef* vertices = &group.vertices[std::size_t(edge.edge) * std::size_t(group.arity)];
    int open = 0;
    for (int k = 0; k < group.arity; ++k) open += isPlaced(vertices[k]) == 0 ? 1 : 0;
    const bool each =
        (group.type->flags & GRAFT_EDGE_FIRST_PLACES) != 0 && isPlaced(vertices[0]) != 0;
    if (open == 0 || (open > 1 && !each)) return;
    for (int k = 0; k < group.arity; ++k) {
      if (isPlaced(vertices[k]) == 0) placeBy(edge, k);
    }
  }

  /// Places the vertex in one slot of an edge, if the edge can.
  void placeBy(const EdgeRef& edge, int open) {
    const EdgeGroup& group = problem_.groups()[std::size_t(edge.group)];
    const VertexRef* vertices = &group.vertices[std::size_t(edge.edge) * std::size_t(group.arity)];
    const EdgeBatch batch(group, std::size_t(edge.group), state_, edge.edge, edge.edge + 1);
    const VertexRef v = vertices[open];
    const graft_vertex_type& type = problem_.graph().type(v);
    std::vector<double> estimate(state_.values.at(v), state_.values.at(v) + type.ambient_dim);
    graft_message message = {};
    const auto propagate = [&] {
      return group.type->propagate(&batch.view(), open, estimate.data());
    };
    if (callPlugin(Callback::kPropagate, group.type->tag, propagate) != GRAFT_OK) return;
    const auto normalize = [&] { return type.normalize(estimate.data(), &message); };
    if (callPlugin(Callback::kNormalize, type.tag, message, normalize) != GRAFT_OK) return;
    for (const double number : estimate) {
      if (!std::isfinite(number)) return;
    }
    std::copy(estimate.begin(), estimate.end(), state_.values.at(v));
    ++placed_count_;
    place(v);
  }

  const Problem& problem_;
  State state_;
  std::vector<std::vector<char>> placed_;  ///< 1 = placed and queued, 2 = never moved
  std::vector<std::vector<std::vector<EdgeRef>>> edges_;
  std::vector<VertexRef> queue_;
  std::int64_t placed_count_ = 0;
  bool some_without_weight_ = false;
  bool every_edge_ = false;  ///< else only those of weight above 0
};

}  // namespace

SpreadResult spreadEstimates(const Problem& problem, const State& state,
                             const std::vector<VertexRef>& placed) {
  return Spreading(problem, state).run(placed);
}

}  // namespace graft
