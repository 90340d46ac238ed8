// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/graph.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/types/plugin_call.hpp"
#include "core/types/registry.hpp"

namespace graft {

namespace {

[[noreturn]] void reject(const std::string& text) { throw Error(ExitCode::kInput, text); }

void requireFinite(const double* numbers, std::size_t count, const std::string& what) {
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(numbers[i])) reject(what + " has a number that is not finite");
  }
}

void requireLevel(std::int32_t level) {
  if (level < 0)
    reject("the level of an edge is " + std::to_string(level) + ", but must be 0 or more");
}

}  // namespace

int Graph::vertexBlockOf(const graft_vertex_type& type, Values& values) {
  for (std::size_t i = 0; i < vertex_blocks_.size(); ++i) {
    if (vertex_blocks_[i].type == &type) return int(i);
  }
  vertex_blocks_.push_back({&type, {}, {}, {}});
  values.addType(type.ambient_dim);
  return int(vertex_blocks_.size()) - 1;
}

EdgeBlock& Graph::edgeBlockOf(const graft_edge_type& type) {
  for (EdgeBlock& block : edge_blocks_) {
    if (block.type == &type) return block;
  }
  edge_blocks_.emplace_back();
  edge_blocks_.back().type = &type;
  return edge_blocks_.back();
}

std::shared_ptr<const void> loadResource(const graft_resource_type& type,
                                         const std::string& directory,
                                         const std::vector<std::string>& tokens,
                                         graft_message& message) {
  std::vector<const char*> texts;
  texts.reserve(tokens.size());
  for (const std::string& token : tokens) texts.push_back(token.c_str());
  const void* data = callPlugin(Callback::kLoadResource, type.tag, [&] {
    return type.load(directory.c_str(), std::int32_t(texts.size()), texts.data(), &message);
  });
  if (data == nullptr) return nullptr;
  return std::shared_ptr<const void>(data, [&type](const void* resource) {
    const PluginCall call(Callback::kDestroyResource, type.tag);
    type.destroy(resource);
  });
}

VertexRef Graph::addVertex(const graft_vertex_type& type, std::int64_t id, const double* estimate,
                           Values& values, std::int64_t line) {
  if (id < 0) reject("vertex id " + std::to_string(id) + " is negative");
  const VertexRef existing = find(id);
  if (existing.type >= 0) {
    const std::int64_t where = block(existing).lines[std::size_t(existing.index)];
    reject("vertex " + std::to_string(id) + " is already defined" +
           (where > 0 ? " in line " + std::to_string(where) : std::string()));
  }
  std::vector<double> numbers(std::size_t(type.ambient_dim));
  if (estimate == nullptr) {
    callPlugin(Callback::kIdentity, type.tag, [&] { type.identity(numbers.data()); });
    requireFinite(numbers.data(), numbers.size(),
                  std::string("the identity of ") + type.tag + ofPlugin(type.tag));
  } else {
    std::copy(estimate, estimate + type.ambient_dim, numbers.begin());
    requireFinite(estimate, numbers.size(), "vertex " + std::to_string(id));
    graft_message message = {};
    // Callbacks must not throw; one that does all the same refuses the numbers.
    if (callPlugin(Callback::kNormalize, type.tag, message,
                   [&] { return type.normalize(numbers.data(), &message); }) != GRAFT_OK) {
      reject(std::string(type.tag) + " " + std::to_string(id) + ": " + message.text);
    }
    requireFinite(numbers.data(), numbers.size(), "vertex " + std::to_string(id) + ", normalised,");
  }
  VertexRef v;
  v.type = vertexBlockOf(type, values);
  VertexBlock& target = vertex_blocks_[std::size_t(v.type)];
  v.index = std::int32_t(target.ids.size());
  target.ids.push_back(id);
  target.fixed.push_back(0);
  target.lines.push_back(line);
  values.append(v.type, numbers.data());
  by_id_.emplace(id, v);
  return v;
}

void Graph::checkEdge(EdgeSpec& spec, int& error_dim) const {
  const graft_edge_type& type = *spec.type;
  const auto fail = [&](const std::string& text) {
    reject(std::string("edge ") + type.tag + " " + text);
  };
  const int arity = int(spec.vertices.size());
  int measurement_dim = type.measurement_dim;
  error_dim = type.error_dim;
  if (type.arity == GRAFT_DYNAMIC) {
    graft_message message = {};
    if (!edgeShape(type, arity, error_dim, measurement_dim, message)) {
      fail("with " + std::to_string(arity) + " vertices: " + message.text);
    }
  } else if (arity != type.arity) {
    fail("needs " + std::to_string(type.arity) + " vertices, got " + std::to_string(arity));
  }
  for (int k = 0; k < arity; ++k) {
    const VertexRef v = spec.vertices[std::size_t(k)];
    const std::string wanted = slotType(type, k);
    if (wanted != this->type(v).tag) {
      fail("slot " + std::to_string(k + 1) + " needs " + wanted + ", vertex " +
           std::to_string(id(v)) + " is " + this->type(v).tag);
    }
    if ((type.flags & GRAFT_EDGE_ALLOWS_REPEATS) == 0) {
      for (int j = 0; j < k; ++j) {
        if (spec.vertices[std::size_t(j)] == v) {
          fail("names vertex " + std::to_string(id(v)) + " twice");
        }
      }
    }
  }
  if (int(spec.resources.size()) != type.resource_count) {
    fail("needs " + std::to_string(type.resource_count) + " resources, got " +
         std::to_string(spec.resources.size()));
  }
  for (std::size_t k = 0; k < spec.resources.size(); ++k) {
    const Resource& resource = resources_[std::size_t(spec.resources[k])];
    if (std::string(type.resource_types[k]) != resource.type->tag) {
      fail("needs a " + std::string(type.resource_types[k]) + ", resource " +
           std::to_string(resource.id) + " is " + resource.type->tag);
    }
  }
  if (int(spec.measurement.size()) != measurement_dim) {
    fail("needs " + std::to_string(measurement_dim) + " numbers as measurement, got " +
         std::to_string(spec.measurement.size()));
  }
  requireFinite(spec.measurement.data(), spec.measurement.size(), type.tag);
  graft_message message = {};
  const auto normalize = [&] {
    return type.normalize(measurement_dim, spec.measurement.data(), &message);
  };
  if (callPlugin(Callback::kNormalize, type.tag, message, normalize) != GRAFT_OK) {
    fail(std::string("measurement: ") + message.text);
  }
  requireFinite(spec.measurement.data(), spec.measurement.size(), type.tag);
  const std::int64_t entries = triangleSize(error_dim);
  if (spec.information.empty()) {
    for (int r = 0; r < error_dim; ++r) {
      for (int c = r; c < error_dim; ++c) spec.information.push_back(r == c ? 1.0 : 0.0);
    }
  } else if (std::int64_t(spec.information.size()) != entries) {
    fail("needs " + std::to_string(entries) + " numbers as information matrix, got " +
         std::to_string(spec.information.size()));
  }
  requireFinite(spec.information.data(), spec.information.size(), type.tag);
  requireLevel(spec.level);
}

EdgeId Graph::addEdge(EdgeSpec spec) {
  int error_dim = 0;
  checkEdge(spec, error_dim);
  EdgeBlock& block = edgeBlockOf(*spec.type);
  block.vertices.insert(block.vertices.end(), spec.vertices.begin(), spec.vertices.end());
  block.vertex_begin.push_back(std::int64_t(block.vertices.size()));
  block.measurements.insert(block.measurements.end(), spec.measurement.begin(),
                            spec.measurement.end());
  block.measurement_begin.push_back(std::int64_t(block.measurements.size()));
  block.error_dims.push_back(error_dim);
  block.information.insert(block.information.end(), spec.information.begin(),
                           spec.information.end());
  block.information_begin.push_back(std::int64_t(block.information.size()));
  block.resources.insert(block.resources.end(), spec.resources.begin(), spec.resources.end());
  block.kernels.push_back(spec.kernel);
  block.levels.push_back(spec.level);
  block.lines.push_back(spec.line);
  block.ids.push_back(next_edge_);
  return next_edge_++;
}

std::int32_t Graph::addResource(const graft_resource_type& type, std::int64_t id,
                                std::vector<std::string> tokens, std::shared_ptr<const void> data) {
  const auto index = std::int32_t(resources_.size());
  if (!resource_by_id_.emplace(id, index).second) {
    reject("resource " + std::to_string(id) + " is already defined");
  }
  resources_.push_back({&type, id, std::move(tokens), std::move(data)});
  return index;
}

std::int32_t Graph::addKernel(const Kernel& kernel) {
  if (!(std::isfinite(kernel.width) && kernel.width > 0)) {
    reject("the width of a robust kernel must be positive");
  }
  for (std::size_t i = 0; i < kernels_.size(); ++i) {
    if (kernels_[i].type == kernel.type && kernels_[i].width == kernel.width) {
      return std::int32_t(i);
    }
  }
  kernels_.push_back(kernel);
  return std::int32_t(kernels_.size()) - 1;
}

void Graph::setKernel(const Kernel& kernel, const std::string& tag) {
  const std::int32_t index = addKernel(kernel);
  for (EdgeBlock& block : edge_blocks_) {
    if (tag.empty() || tag == block.type->tag) {
      std::fill(block.kernels.begin(), block.kernels.end(), index);
    }
  }
}

void Graph::clearKernels(const std::string& tag) {
  for (EdgeBlock& block : edge_blocks_) {
    if (tag.empty() || tag == block.type->tag) {
      std::fill(block.kernels.begin(), block.kernels.end(), -1);
    }
  }
}

void Graph::setLevel(std::size_t block, std::size_t edge, std::int32_t level) {
  requireLevel(level);
  edge_blocks_[block].levels[edge] = level;
}

void Graph::setFixed(VertexRef v, bool fixed) {
  vertex_blocks_[std::size_t(v.type)].fixed[std::size_t(v.index)] = fixed ? 1 : 0;
}

VertexRef Graph::find(std::int64_t id) const {
  const auto position = by_id_.find(id);
  return position == by_id_.end() ? VertexRef{} : position->second;
}

std::int32_t Graph::findResource(std::int64_t id) const {
  const auto position = resource_by_id_.find(id);
  return position == resource_by_id_.end() ? -1 : position->second;
}

std::size_t Graph::edgeCount() const {
  std::size_t count = 0;
  for (const EdgeBlock& block : edge_blocks_) count += block.size();
  return count;
}

std::vector<VertexRef> Graph::verticesById() const {
  std::vector<std::pair<std::int64_t, VertexRef>> all(by_id_.begin(), by_id_.end());
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<VertexRef> vertices;
  vertices.reserve(all.size());
  for (const auto& entry : all) vertices.push_back(entry.second);
  return vertices;
}

}  // namespace graft
