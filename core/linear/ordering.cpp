// SPDX-License-Identifier: BSD-3-Clause
#include "core/linear/ordering.hpp"

#include <amd.h>
#include <metis.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/base/error.hpp"
#include "core/base/memory.hpp"
#include "core/linear/schur_pattern.hpp"

namespace graft {

namespace {

/// Below this a factorisation is cheaper than what nested dissection takes.
constexpr double kFlopsWorthDissection = 3e7;

/// The share of blocks that an independent set must have to be eliminated first. In pose
/// graphs it has up to half of them, and minimum degree finds those by itself.
constexpr double kIndependentShare = 0.67;

/// With fewer flops than this per neighbour, minimum degree on all blocks takes longer
/// than the quarter of some ten factorisations that it may save after such a start: it
/// took 0.6 to 1.6 microseconds a neighbour on points seen by cameras.
constexpr double kFlopsWorthAmd = 5000;

/// Neighbours that become neighbours of each other, at most, counted with repetition.
constexpr double kJoinsWorthFinding = 1e9;

/// Of the graph, twice for AMD's or METIS' own copy, and where the blocks go: roughly.
constexpr double kBytesPerBlock = 100;

/// Dissection finds nothing in a graph that has more than this share of all edges.
constexpr double kDenseShare = 0.5;

std::vector<std::int32_t> inverseOf(const std::vector<std::int32_t>& order) {
  std::vector<std::int32_t> position(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    position[std::size_t(order[i])] = std::int32_t(i);
  }
  return position;
}

std::vector<std::int32_t> orderByAmd(const BlockGraph& graph) {
  std::vector<std::int32_t> order(std::size_t(graph.size()));
  std::iota(order.begin(), order.end(), 0);
  if (graph.neighbours.empty()) return order;
  const int status = amd_order(graph.size(), graph.begin.data(), graph.neighbours.data(),
                               order.data(), nullptr, nullptr);
  if (status == AMD_OUT_OF_MEMORY) {
    throw Error(ExitCode::kResources, "not enough memory to order the equations");
  }
  if (status != AMD_OK && status != AMD_OK_BUT_JUMBLED) {
    throw Error(ExitCode::kInternal, "AMD refuses the pattern of the equations");
  }
  return order;
}

/// Empty where METIS fails.
std::vector<std::int32_t> orderByMetis(const BlockGraph& graph) {
  idx_t count = graph.size();
  std::vector<idx_t> begin(graph.begin.begin(), graph.begin.end());
  std::vector<idx_t> neighbours(graph.neighbours.begin(), graph.neighbours.end());
  std::vector<idx_t> weights(graph.dims.begin(), graph.dims.end());
  std::vector<idx_t> order(std::size_t(count), 0);
  std::vector<idx_t> position(std::size_t(count), 0);
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = 1;
  const bool uniform = std::all_of(weights.begin(), weights.end(),
                                   [&](idx_t weight) { return weight == weights.front(); });
  const int status =
      METIS_NodeND(&count, begin.data(), neighbours.data(), uniform ? nullptr : weights.data(),
                   options, order.data(), position.data());
  if (status != METIS_OK) return {};
  return std::vector<std::int32_t>(order.begin(), order.end());
}

}  // namespace

BlockGraph::BlockGraph(const graft_block_pattern& pattern)
    : dims(pattern.dims, pattern.dims + pattern.block_count),
      begin(std::size_t(pattern.block_count) + 1, 0) {
  const std::int64_t blocks = pattern.block_count == 0 ? 0 : pattern.columns[pattern.block_count];
  const std::int64_t rows = std::accumulate(dims.begin(), dims.end(), std::int64_t{0});
  constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  if (2 * blocks > kMost || rows > kMost) {
    throw Error(ExitCode::kNoResult, "the normal equations have " + std::to_string(rows) +
                                         " unknowns in " + std::to_string(blocks) +
                                         " blocks: too many for indices of 32 bits");
  }
  requireMemory(kBytesPerBlock * double(blocks), "ordering the normal equations");
  const auto forEach = [&](auto&& visit) {
    for (std::int32_t j = 0; j < pattern.block_count; ++j) {
      for (std::int64_t b = pattern.columns[j]; b < pattern.columns[j + 1]; ++b) {
        if (pattern.rows[b] != j) visit(pattern.rows[b], j);
      }
    }
  };
  forEach([&](std::int32_t i, std::int32_t j) {
    ++begin[std::size_t(i) + 1];
    ++begin[std::size_t(j) + 1];
  });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  neighbours.resize(std::size_t(begin.back()));
  std::vector<std::int32_t> next(begin.begin(), begin.end() - 1);
  // By columns, so that first the smaller, then the larger neighbours come, each rising.
  forEach(
      [&](std::int32_t i, std::int32_t j) { neighbours[std::size_t(next[std::size_t(i)]++)] = j; });
  forEach(
      [&](std::int32_t i, std::int32_t j) { neighbours[std::size_t(next[std::size_t(j)]++)] = i; });
}

std::vector<std::int32_t> eliminationTree(const BlockGraph& graph,
                                          const std::vector<std::int32_t>& order) {
  const std::vector<std::int32_t> position = inverseOf(order);
  std::vector<std::int32_t> parent(order.size(), -1);
  std::vector<std::int32_t> ancestor(order.size(), -1);
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    const auto block = std::size_t(order[std::size_t(i)]);
    for (std::int32_t n = graph.begin[block]; n < graph.begin[block + 1]; ++n) {
      std::int32_t k = position[std::size_t(graph.neighbours[std::size_t(n)])];
      while (k >= 0 && k < i) {
        const std::int32_t next = ancestor[std::size_t(k)];
        ancestor[std::size_t(k)] = i;
        if (next < 0) parent[std::size_t(k)] = i;
        k = next;
      }
    }
  }
  return parent;
}

FactorCost predictCost(const BlockGraph& graph, const std::vector<std::int32_t>& order) {
  const std::vector<std::int32_t> position = inverseOf(order);
  const std::vector<std::int32_t> parent = eliminationTree(graph, order);
  // Row i of the factor is the part of the tree between its neighbours and i.
  std::vector<double> below(order.size(), 0);
  std::vector<std::int32_t> mark(order.size(), -1);
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    const auto block = std::size_t(order[std::size_t(i)]);
    for (std::int32_t n = graph.begin[block]; n < graph.begin[block + 1]; ++n) {
      std::int32_t k = position[std::size_t(graph.neighbours[std::size_t(n)])];
      for (; k < i && mark[std::size_t(k)] != i; k = parent[std::size_t(k)]) {
        mark[std::size_t(k)] = i;
        below[std::size_t(k)] += graph.dims[block];
      }
    }
  }
  FactorCost cost;
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (int c = 0; c < graph.dims[std::size_t(order[i])]; ++c) {
      const double length = below[i] + (graph.dims[std::size_t(order[i])] - c);
      cost.flops += length * length;
      cost.entries += length;
    }
  }
  return cost;
}

namespace {

Ordering evaluated(const BlockGraph& graph, std::string name, std::vector<std::int32_t> order) {
  const FactorCost cost = predictCost(graph, order);
  return {std::move(name), std::move(order), cost.flops, cost.entries};
}

void keepBetter(Ordering& best, Ordering other) {
  if (other.flops < best.flops) best = std::move(other);
}

/// Eliminates independent blocks first, then the rest by the better of two orders. Has no
/// order if they are too few, or would join so many others that finding this out costs
/// more than it can save.
Ordering orderBySchur(const BlockGraph& graph) {
  const std::vector<std::int32_t> set = independentSet(graph);
  if (double(set.size()) < kIndependentShare * graph.size()) return {};
  double joined = 0;
  for (const std::int32_t block : set) {
    const double degree = graph.begin[std::size_t(block) + 1] - graph.begin[std::size_t(block)];
    joined += degree * degree;
  }
  if (joined > kJoinsWorthFinding) return {};
  const SchurPattern rest = eliminateBlocks(graph, set);
  const auto continued = [&](const char* name, const std::vector<std::int32_t>& order) {
    std::vector<std::int32_t> all = set;
    for (const std::int32_t i : order) all.push_back(rest.blocks[std::size_t(i)]);
    return evaluated(
        graph,
        "schur(" + std::to_string(set.size()) + " of " + std::to_string(graph.size()) + ")+" + name,
        std::move(all));
  };
  Ordering schur = continued("amd", orderByAmd(rest.graph));
  const bool dense =
      double(rest.graph.neighbours.size()) > kDenseShare * rest.graph.size() * rest.graph.size();
  if (schur.flops >= kFlopsWorthDissection && !dense) {
    const std::vector<std::int32_t> order = orderByMetis(rest.graph);
    if (!order.empty()) keepBetter(schur, continued("metis", order));
  }
  return schur;
}

}  // namespace

Ordering keepOrdering(const BlockGraph& graph, std::vector<std::int32_t> order) {
  return evaluated(graph, "kept", std::move(order));
}

Ordering chooseOrdering(const BlockGraph& graph) {
  if (graph.neighbours.empty()) {
    return evaluated(graph, "natural", orderByAmd(graph));
  }
  Ordering schur = orderBySchur(graph);
  const bool has_schur = !schur.order.empty();
  if (has_schur && schur.flops < kFlopsWorthAmd * double(graph.neighbours.size())) return schur;
  Ordering best = evaluated(graph, "amd", orderByAmd(graph));
  if (has_schur) {
    keepBetter(best, std::move(schur));
  } else if (best.flops >= kFlopsWorthDissection) {
    std::vector<std::int32_t> order = orderByMetis(graph);
    if (!order.empty()) keepBetter(best, evaluated(graph, "metis", std::move(order)));
  }
  return best;
}

}  // namespace graft
