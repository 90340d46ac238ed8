// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/problem.hpp"

#include <algorithm>
#include <cstring>
#include <functional>
#include <numeric>

#include "core/base/disjoint_sets.hpp"
#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/solve/information.hpp"

namespace graft {

namespace {

/// Orders doubles by their bits: any total order does, and this one also tells
/// -0 from 0.
int compareBits(const double* a, const double* b, std::size_t count) {
  return count == 0 ? 0 : std::memcmp(a, b, count * sizeof(double));
}

/// Canonical order of the edges of one block.
class EdgeOrder {
 public:
  EdgeOrder(const Graph& graph, const EdgeBlock& block) : graph_(graph), block_(block) {
    ids_.reserve(block.vertices.size());
    for (const VertexRef v : block.vertices) ids_.push_back(graph.id(v));
  }

  bool operator()(std::size_t a, std::size_t b) const {
    const int arity = block_.arity(a);
    if (arity != block_.arity(b)) return arity < block_.arity(b);
    const auto ids_a = ids_.begin() + block_.vertex_begin[a];
    const auto ids_b = ids_.begin() + block_.vertex_begin[b];
    for (int k = 0; k < arity; ++k) {
      if (ids_a[k] != ids_b[k]) return ids_a[k] < ids_b[k];
    }
    const int content = compareContent(a, b);
    return content != 0 ? content < 0 : block_.lines[a] < block_.lines[b];
  }

 private:
  int compareContent(std::size_t a, std::size_t b) const {
    int order = compareBits(block_.measurements.data() + block_.measurement_begin[a],
                            block_.measurements.data() + block_.measurement_begin[b],
                            std::size_t(block_.measurementDim(a)));
    if (order != 0) return order;
    order = compareBits(block_.information.data() + block_.information_begin[a],
                        block_.information.data() + block_.information_begin[b],
                        std::size_t(block_.information_begin[a + 1] - block_.information_begin[a]));
    if (order != 0) return order;
    const auto count = std::size_t(block_.type->resource_count);
    for (std::size_t k = 0; k < count; ++k) {
      const std::int64_t ra = resourceId(a * count + k);
      const std::int64_t rb = resourceId(b * count + k);
      if (ra != rb) return ra < rb ? -1 : 1;
    }
    return compareKernels(block_.kernels[a], block_.kernels[b]);
  }

  std::int64_t resourceId(std::size_t index) const {
    return graph_.resources()[std::size_t(block_.resources[index])].id;
  }

  int compareKernels(std::int32_t a, std::int32_t b) const {
    if (a == b) return 0;
    if (a < 0 || b < 0) return a < 0 ? -1 : 1;
    const Kernel& ka = graph_.kernels()[std::size_t(a)];
    const Kernel& kb = graph_.kernels()[std::size_t(b)];
    const int order = std::strcmp(ka.type->name, kb.type->name);
    if (order != 0) return order;
    return ka.width < kb.width ? -1 : (kb.width < ka.width ? 1 : 0);
  }

  const Graph& graph_;
  const EdgeBlock& block_;
  std::vector<std::int64_t> ids_;
};

RootShape shapeOf(const double* root, int dim) {
  bool identity = true;
  for (int c = 0; c < dim; ++c) {
    for (int r = 0; r < dim; ++r) {
      const double entry = root[c * dim + r];
      if (r != c && entry != 0) return RootShape::kDense;
      if (r == c && entry != 1) identity = false;
    }
  }
  return identity ? RootShape::kIdentity : RootShape::kDiagonal;
}

}  // namespace

std::string EdgeGroup::describe(const Graph& graph, std::int64_t edge) const {
  std::string text = type->tag;
  for (int k = 0; k < arity; ++k) {
    if (k == 8) {
      text += " ... (" + std::to_string(arity) + " vertices)";
      break;
    }
    text += " " + std::to_string(graph.id(vertices[std::size_t(edge * arity + k)]));
  }
  const std::int64_t line = lines[std::size_t(edge)];
  if (line > 0) text += " (line " + std::to_string(line) + ")";
  return text;
}

Problem::Problem(const Graph& graph, InformationPolicy policy, std::int32_t level)
    : graph_(&graph) {
  compileEdges(policy, level);
  chooseGauge();
  numberVertices();
  if (projected_ > 0) {
    notes_.push_back(std::to_string(projected_) +
                     " information matrices were projected to positive semidefinite ones");
  }
}

std::string Problem::describeVertex(VertexRef v) const {
  return std::string(graph_->type(v).tag) + " " + std::to_string(graph_->id(v));
}

void Problem::compileEdges(InformationPolicy policy, std::int32_t level) {
  const std::vector<EdgeBlock>& blocks = graph_->edgeBlocks();
  std::vector<std::size_t> order(blocks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&blocks](std::size_t a, std::size_t b) {
    return std::strcmp(blocks[a].type->tag, blocks[b].type->tag) < 0;
  });
  for (const std::size_t index : order) compileBlock(index, policy, level);
}

void Problem::compileBlock(std::size_t index, InformationPolicy policy, std::int32_t level) {
  const EdgeBlock& block = graph_->edgeBlocks()[index];
  std::vector<std::size_t> order;
  order.reserve(block.size());
  for (std::size_t e = 0; e < block.size(); ++e) {
    if (level == kAllLevels || block.levels[e] == level) order.push_back(e);
  }
  const EdgeOrder before(*graph_, block);
  std::sort(order.begin(), order.end(), std::cref(before));
  bool first = true;
  for (const std::size_t e : order) {
    const int arity = block.arity(e);
    const VertexRef* vertices = &block.vertices[std::size_t(block.vertex_begin[e])];
    if (first || groups_.back().arity != arity) {
      first = false;
      EdgeGroup group;
      group.type = block.type;
      group.block = index;
      group.arity = arity;
      group.error_dim = block.error_dims[e];
      group.measurement_dim = block.measurementDim(e);
      for (int k = 0; k < arity; ++k) {
        group.slot_offsets.push_back(group.tangent_dim);
        group.slot_dims.push_back(graph_->type(vertices[k]).tangent_dim);
        group.tangent_dim += group.slot_dims.back();
      }
      groups_.push_back(std::move(group));
    }
    EdgeGroup& group = groups_.back();
    group.vertices.insert(group.vertices.end(), vertices, vertices + arity);
    group.measurements.push_back(block.measurements.data() + block.measurement_begin[e]);
    group.kernels.push_back(block.kernels[e]);
    group.lines.push_back(block.lines[e]);
    group.edges.push_back(std::int64_t(e));
    for (int k = 0; k < block.type->resource_count; ++k) {
      const std::size_t resource = e * std::size_t(block.type->resource_count) + std::size_t(k);
      group.resources.push_back(
          graph_->resources()[std::size_t(block.resources[resource])].data.get());
    }
    ++group.count;
    appendInformation(group, block.information.data() + block.information_begin[e], policy);
  }
}

void Problem::appendInformation(EdgeGroup& group, const double* upper, InformationPolicy policy) {
  const int dim = group.error_dim;
  const std::size_t size = std::size_t(dim) * std::size_t(dim);
  group.roots.resize(group.roots.size() + size);
  double* root = group.roots.data() + group.roots.size() - size;
  const InformationFactor factor = factorInformation(upper, dim, root);
  group.root_shapes.push_back(shapeOf(root, dim));
  if (!factor.semidefinite) {
    if (policy == InformationPolicy::kError) {
      throw Error(ExitCode::kInput, {"", group.lines.back(), 0},
                  "the information matrix of edge " + group.describe(*graph_, group.count - 1) +
                      " is not positive semidefinite: its smallest eigenvalue is " +
                      formatDouble(factor.smallest_eigenvalue));
    }
    ++projected_;
  }
  if (group.type->associate == nullptr) return;
  group.information.resize(group.information.size() + size);
  double* full = group.information.data() + group.information.size() - size;
  for (int r = 0; r < dim; ++r) {
    for (int c = r; c < dim; ++c) full[r * dim + c] = full[c * dim + r] = *upper++;
  }
}

void Problem::chooseGauge() {
  const std::vector<VertexRef> by_id = graph_->verticesById();
  std::vector<std::vector<std::size_t>> rank(graph_->vertexBlocks().size());
  for (std::size_t t = 0; t < rank.size(); ++t) {
    rank[t].resize(graph_->vertexBlocks()[t].ids.size());
  }
  const auto rankOf = [&](VertexRef v) -> std::size_t& {
    return rank[std::size_t(v.type)][std::size_t(v.index)];
  };
  for (std::size_t i = 0; i < by_id.size(); ++i) rankOf(by_id[i]) = i;
  DisjointSets components(by_id.size());
  std::vector<char> touched(by_id.size(), 0);
  std::vector<char> anchored(by_id.size(), 0);
  for (const EdgeGroup& group : groups_) {
    const bool anchors = group.arity == 1 && (group.type->flags & GRAFT_EDGE_RELATIVE) == 0;
    for (std::int64_t e = 0; e < group.count; ++e) {
      const VertexRef* vertices = &group.vertices[std::size_t(e * group.arity)];
      for (int k = 0; k < group.arity; ++k) {
        components.merge(rankOf(vertices[0]), rankOf(vertices[k]));
        touched[rankOf(vertices[k])] = 1;
      }
      if (anchors) anchored[rankOf(vertices[0])] = 1;
    }
  }
  struct Choice {
    std::size_t size = 0;
    bool fixed = false;
    bool anchored = false;
    VertexRef best;
  };
  std::vector<Choice> choices(by_id.size());
  for (std::size_t i = 0; i < by_id.size(); ++i) {
    if (!touched[i]) continue;
    Choice& choice = choices[components.find(i)];
    ++choice.size;
    choice.fixed = choice.fixed || graph_->isFixed(by_id[i]);
    choice.anchored = choice.anchored || anchored[i];
    if (choice.best.type < 0 ||
        graph_->type(by_id[i]).tangent_dim > graph_->type(choice.best).tangent_dim) {
      choice.best = by_id[i];
    }
  }
  for (std::size_t i = 0; i < by_id.size(); ++i) {
    if (!touched[i]) continue;
    const Choice& choice = choices[components.find(i)];
    if (choice.fixed ? graph_->isFixed(by_id[i])
                     : (choice.anchored ? anchored[i] != 0 : by_id[i] == choice.best)) {
      roots_.push_back(by_id[i]);
      if (choice.fixed || choice.anchored) continue;
      held_.push_back(by_id[i]);
      notes_.push_back(describeVertex(by_id[i]) + " is held where it is: nothing fixes its " +
                       "component of " + std::to_string(choice.size) + " vertices");
    }
  }
  blocks_.resize(rank.size());
  for (std::size_t t = 0; t < rank.size(); ++t) {
    blocks_[t].assign(rank[t].size(), -1);
    for (std::size_t i = 0; i < rank[t].size(); ++i) {
      if (touched[rank[t][i]] && graph_->vertexBlocks()[t].fixed[i] == 0) blocks_[t][i] = 0;
    }
  }
  for (const VertexRef v : held_) blocks_[std::size_t(v.type)][std::size_t(v.index)] = -1;
}

void Problem::numberVertices() {
  offsets_.push_back(0);
  for (const VertexRef v : graph_->verticesById()) {
    std::int32_t& block = blocks_[std::size_t(v.type)][std::size_t(v.index)];
    if (block < 0) continue;
    block = std::int32_t(free_.size());
    free_.push_back(v);
    dims_.push_back(graph_->type(v).tangent_dim);
    offsets_.push_back(offsets_.back() + dims_.back());
  }
  for (EdgeGroup& group : groups_) {
    group.blocks.reserve(group.vertices.size());
    for (const VertexRef v : group.vertices) group.blocks.push_back(blockOf(v));
  }
}

}  // namespace graft
