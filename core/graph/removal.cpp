// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "core/base/error.hpp"
#include "core/graph/graph.hpp"

namespace graft {

namespace {

/// Keeps the marked runs of an array that `begin` cuts into runs, and mends `begin`.
template <class T>
void keepRuns(std::vector<T>& array, std::vector<std::int64_t>& begin,
              const std::vector<char>& keep) {
  std::size_t next = 0;
  std::size_t kept = 0;
  std::int64_t from = 0;
  for (std::size_t e = 0; e < keep.size(); ++e) {
    const std::int64_t to = begin[e + 1];
    if (keep[e] != 0) {
      for (std::int64_t i = from; i < to; ++i) array[next++] = array[std::size_t(i)];
      begin[++kept] = std::int64_t(next);
    }
    from = to;
  }
  array.resize(next);
  begin.resize(kept + 1);
}

/// Keeps the marked items of an array with `width` entries an item.
template <class T>
void keepItems(std::vector<T>& array, const std::vector<char>& keep, std::size_t width = 1) {
  std::size_t next = 0;
  for (std::size_t e = 0; e < keep.size(); ++e) {
    if (keep[e] == 0) continue;
    for (std::size_t i = 0; i < width; ++i) array[next++] = array[e * width + i];
  }
  array.resize(next);
}

std::size_t keepEdges(EdgeBlock& block, const std::vector<char>& keep) {
  const auto kept = std::size_t(std::count(keep.begin(), keep.end(), 1));
  const std::size_t removed = keep.size() - kept;
  if (removed == 0) return 0;
  keepRuns(block.vertices, block.vertex_begin, keep);
  keepRuns(block.measurements, block.measurement_begin, keep);
  keepRuns(block.information, block.information_begin, keep);
  keepItems(block.error_dims, keep);
  keepItems(block.resources, keep, std::size_t(block.type->resource_count));
  keepItems(block.kernels, keep);
  keepItems(block.levels, keep);
  keepItems(block.lines, keep);
  keepItems(block.ids, keep);
  return removed;
}

}  // namespace

void Graph::removeEdges(std::vector<EdgeId> edges) {
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<std::vector<char>> keep;
  std::size_t found = 0;
  for (const EdgeBlock& block : edge_blocks_) {
    keep.emplace_back(block.size(), 1);
    for (std::size_t e = 0; e < block.size(); ++e) {
      if (!std::binary_search(edges.begin(), edges.end(), block.ids[e])) continue;
      keep.back()[e] = 0;
      ++found;
    }
  }
  if (found != edges.size()) {
    throw Error(ExitCode::kInput, std::to_string(edges.size() - found) + " of " +
                                      std::to_string(edges.size()) +
                                      " edges to remove are not in the graph");
  }
  for (std::size_t b = 0; b < edge_blocks_.size(); ++b) keepEdges(edge_blocks_[b], keep[b]);
}

std::size_t Graph::removeVertices(const std::vector<std::int64_t>& ids, Values& values) {
  std::vector<std::vector<char>> keep;
  for (const VertexBlock& block : vertex_blocks_) keep.emplace_back(block.ids.size(), 1);
  for (const std::int64_t id : ids) {
    const VertexRef v = find(id);
    if (v.type < 0) {
      throw Error(ExitCode::kInput, "vertex " + std::to_string(id) + " is not defined");
    }
    keep[std::size_t(v.type)][std::size_t(v.index)] = 0;
  }
  std::size_t removed = 0;
  for (EdgeBlock& block : edge_blocks_) {
    std::vector<char> keep_edge(block.size(), 1);
    for (std::size_t e = 0; e < block.size(); ++e) {
      for (std::int64_t i = block.vertex_begin[e]; i < block.vertex_begin[e + 1]; ++i) {
        const VertexRef v = block.vertices[std::size_t(i)];
        if (keep[std::size_t(v.type)][std::size_t(v.index)] == 0) keep_edge[e] = 0;
      }
    }
    removed += keepEdges(block, keep_edge);
  }
  // What stays moves up; edges follow.
  for (const std::int64_t id : ids) by_id_.erase(id);
  std::vector<std::vector<std::int32_t>> places;
  for (std::size_t t = 0; t < vertex_blocks_.size(); ++t) {
    VertexBlock& block = vertex_blocks_[t];
    places.emplace_back(keep[t].size(), -1);
    std::int32_t next = 0;
    for (std::size_t i = 0; i < keep[t].size(); ++i) {
      if (keep[t][i] == 0) continue;
      by_id_[block.ids[i]].index = next;
      places[t][i] = next++;
    }
    keepItems(block.ids, keep[t]);
    keepItems(block.fixed, keep[t]);
    keepItems(block.lines, keep[t]);
    values.keep(int(t), keep[t]);
  }
  for (EdgeBlock& block : edge_blocks_) {
    for (VertexRef& v : block.vertices) v.index = places[std::size_t(v.type)][std::size_t(v.index)];
  }
  return removed;
}

}  // namespace graft
