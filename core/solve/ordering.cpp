// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/ordering.hpp"

#include <amd.h>
#include <metis.h>

#include <algorithm>
#include <numeric>

#include "core/base/error.hpp"

namespace graft {

namespace {

/// Below this a factorisation is cheaper than what nested dissection takes.
constexpr double kFlopsWorthDissection = 3e7;

std::vector<std::int32_t> inverseOf(const std::vector<std::int32_t>& order) {
  std::vector<std::int32_t> position(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    position[std::size_t(order[i])] = std::int32_t(i);
  }
  return position;
}

std::vector<std::int32_t> orderByAmd(const BlockGraph& graph) {
  std::vector<std::int32_t> order(std::size_t(graph.size()));
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

double predictFlops(const BlockGraph& graph, const std::vector<std::int32_t>& order) {
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
  double flops = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (int c = 0; c < graph.dims[std::size_t(order[i])]; ++c) {
      const double length = below[i] + (graph.dims[std::size_t(order[i])] - c);
      flops += length * length;
    }
  }
  return flops;
}

Ordering keepOrdering(const BlockGraph& graph, std::vector<std::int32_t> order) {
  Ordering kept;
  kept.name = "kept";
  kept.flops = predictFlops(graph, order);
  kept.order = std::move(order);
  return kept;
}

Ordering chooseOrdering(const BlockGraph& graph) {
  Ordering best;
  if (graph.neighbours.empty()) {
    best.name = "natural";
    best.order.resize(std::size_t(graph.size()));
    std::iota(best.order.begin(), best.order.end(), 0);
    best.flops = predictFlops(graph, best.order);
    return best;
  }
  best.name = "amd";
  best.order = orderByAmd(graph);
  best.flops = predictFlops(graph, best.order);
  if (best.flops < kFlopsWorthDissection) return best;
  Ordering dissection;
  dissection.name = "metis";
  dissection.order = orderByMetis(graph);
  if (dissection.order.empty()) return best;
  dissection.flops = predictFlops(graph, dissection.order);
  return dissection.flops < best.flops ? dissection : best;
}

}  // namespace graft
