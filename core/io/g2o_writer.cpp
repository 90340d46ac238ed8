// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/g2o_writer.hpp"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <numeric>

#include "core/base/text.hpp"
#include "core/io/g2o_reader.hpp"

namespace graft {

namespace {

void appendNumbers(std::string& out, const double* numbers, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    out += ' ';
    appendDouble(out, numbers[i]);
  }
}

namespace fs = std::filesystem;

/// A token as it is written, see ResourceFolders.
std::string relocated(const std::string& token, const ResourceFolders& folders) {
  double number = 0;
  if (folders.graph == folders.text || fs::path(token).is_absolute() ||
      parseDouble(token, number) == NumberStatus::kOk) {
    return token;
  }
  std::error_code error;
  const fs::path file = fs::path(folders.graph) / token;
  if (!fs::is_regular_file(file, error)) return token;
  const fs::path moved = fs::relative(file, folders.text, error);
  // A blank would split the token.
  if (error || moved.empty() || moved.string().find_first_of(" \t") != std::string::npos) {
    return token;
  }
  return moved.string();
}

void writeResources(const Graph& graph, const ResourceFolders& folders, std::string& out) {
  std::vector<const Resource*> resources;
  for (const Resource& resource : graph.resources()) resources.push_back(&resource);
  std::sort(resources.begin(), resources.end(),
            [](const Resource* a, const Resource* b) { return a->id < b->id; });
  for (const Resource* resource : resources) {
    out += std::string(resource->type->tag) + ' ' + std::to_string(resource->id);
    for (const std::string& token : resource->tokens) {
      out += ' ' + relocated(token, folders);
    }
    out += '\n';
  }
}

void writeVertices(const Graph& graph, const Values& values, std::string& out) {
  for (const VertexRef v : graph.verticesById()) {
    const std::string id = std::to_string(graph.id(v));
    out += graph.type(v).tag;
    out += ' ' + id;
    appendNumbers(out, values.at(v), std::size_t(graph.type(v).ambient_dim));
    out += '\n';
    if (graph.isFixed(v)) out += "FIX " + id + '\n';
  }
}

int compareNumbers(const double* a, const double* b, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    if (a[i] < b[i]) return -1;
    if (b[i] < a[i]) return 1;
  }
  return 0;
}

/// The edges of one type in an order that depends on their content alone.
class EdgeOrder {
 public:
  EdgeOrder(const Graph& graph, const EdgeBlock& block) : graph_(graph), block_(block) {
    ids_.reserve(block.vertices.size());
    for (const VertexRef v : block.vertices) ids_.push_back(graph.id(v));
  }

  std::vector<std::size_t> sorted() const {
    std::vector<std::size_t> order(block_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [this](std::size_t a, std::size_t b) { return less(a, b); });
    return order;
  }

  const std::int64_t* ids(std::size_t e) const { return ids_.data() + block_.vertex_begin[e]; }
  const double* measurement(std::size_t e) const {
    return block_.measurements.data() + block_.measurement_begin[e];
  }
  const double* information(std::size_t e) const {
    return block_.information.data() + block_.information_begin[e];
  }
  std::size_t informationCount(std::size_t e) const {
    return std::size_t(block_.information_begin[e + 1] - block_.information_begin[e]);
  }
  std::int64_t resourceId(std::size_t e, int k) const {
    const std::size_t index = e * std::size_t(block_.type->resource_count) + std::size_t(k);
    return graph_.resources()[std::size_t(block_.resources[index])].id;
  }

 private:
  bool less(std::size_t a, std::size_t b) const {
    const int arity_a = block_.arity(a);
    const int arity_b = block_.arity(b);
    for (int k = 0; k < std::min(arity_a, arity_b); ++k) {
      if (ids(a)[k] != ids(b)[k]) return ids(a)[k] < ids(b)[k];
    }
    if (arity_a != arity_b) return arity_a < arity_b;
    for (int k = 0; k < block_.type->resource_count; ++k) {
      if (resourceId(a, k) != resourceId(b, k)) return resourceId(a, k) < resourceId(b, k);
    }
    const int order =
        compareNumbers(measurement(a), measurement(b), std::size_t(block_.measurementDim(a)));
    if (order != 0) return order < 0;
    const int weights = compareNumbers(information(a), information(b), informationCount(a));
    if (weights != 0) return weights < 0;
    if (block_.levels[a] != block_.levels[b]) return block_.levels[a] < block_.levels[b];
    return kernelLess(block_.kernels[a], block_.kernels[b]);
  }

  bool kernelLess(std::int32_t a, std::int32_t b) const {
    if (a < 0 || b < 0) return a < b;
    const Kernel& first = graph_.kernels()[std::size_t(a)];
    const Kernel& second = graph_.kernels()[std::size_t(b)];
    const int order = std::strcmp(first.type->name, second.type->name);
    return order != 0 ? order < 0 : first.width < second.width;
  }

  const Graph& graph_;
  const EdgeBlock& block_;
  std::vector<std::int64_t> ids_;
};

void writeEdges(const Graph& graph, const EdgeBlock& block, std::string& out) {
  const EdgeOrder edges(graph, block);
  for (const std::size_t e : edges.sorted()) {
    out += block.type->tag;
    for (int k = 0; k < block.arity(e); ++k) out += ' ' + std::to_string(edges.ids(e)[k]);
    if (block.type->arity == GRAFT_DYNAMIC) out += " ||";
    for (int k = 0; k < block.type->resource_count; ++k) {
      out += ' ' + std::to_string(edges.resourceId(e, k));
    }
    appendNumbers(out, edges.measurement(e), std::size_t(block.measurementDim(e)));
    appendNumbers(out, edges.information(e), edges.informationCount(e));
    out += '\n';
    if (block.kernels[e] >= 0) {
      const Kernel& kernel = graph.kernels()[std::size_t(block.kernels[e])];
      out += std::string(kKernelTag) + ' ' + kernel.type->name;
      appendNumbers(out, &kernel.width, 1);
      out += '\n';
    }
    if (block.levels[e] != 0) {
      out += std::string(kLevelTag) + ' ' + std::to_string(block.levels[e]) + '\n';
    }
  }
}

}  // namespace

std::string formatG2o(const Graph& graph, const Values& values, const ResourceFolders& folders) {
  std::string out;
  writeResources(graph, folders, out);
  writeVertices(graph, values, out);
  std::vector<const EdgeBlock*> blocks;
  for (const EdgeBlock& block : graph.edgeBlocks()) blocks.push_back(&block);
  std::sort(blocks.begin(), blocks.end(), [](const EdgeBlock* a, const EdgeBlock* b) {
    return std::strcmp(a->type->tag, b->type->tag) < 0;
  });
  for (const EdgeBlock* block : blocks) writeEdges(graph, *block, out);
  return out;
}

}  // namespace graft
