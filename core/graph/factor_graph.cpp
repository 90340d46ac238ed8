// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/factor_graph.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

[[noreturn]] void reject(const std::string& text) { throw Error(ExitCode::kInput, text); }

template <class Type>
const Type& require(const Type* type, Registry& registry, const Provided& wanted) {
  if (type == nullptr) {
    reject(std::string("unknown ") + kindName(wanted.kind) + " " + graft::quoted(wanted.name) +
           registry.advice(wanted));
  }
  return *type;
}

void requireCount(const std::string& what, std::size_t wanted, std::size_t got) {
  if (wanted != got) {
    reject(what + " needs " + std::to_string(wanted) + " numbers, got " + std::to_string(got));
  }
}

}  // namespace

VertexRef FactorGraph::at(std::int64_t id) const {
  const VertexRef v = graph_.find(id);
  if (v.type < 0) reject("vertex " + std::to_string(id) + " is not defined");
  return v;
}

void FactorGraph::addVertex(const std::string& tag, std::int64_t id, std::vector<double> estimate) {
  const graft_vertex_type& type = require(registry_.vertex(tag), registry_, {Kind::kVertex, tag});
  if (!estimate.empty()) {
    requireCount(tag + " " + std::to_string(id), std::size_t(type.ambient_dim), estimate.size());
  }
  graph_.addVertex(type, id, estimate.empty() ? nullptr : estimate.data(), values_);
}

EdgeId FactorGraph::addEdge(const std::string& tag, const std::vector<std::int64_t>& vertices,
                            std::vector<double> measurement, std::vector<double> information,
                            const std::vector<std::int64_t>& resources) {
  Graph::EdgeSpec spec;
  spec.type = &require(registry_.edge(tag), registry_, {Kind::kEdge, tag});
  for (const std::int64_t id : vertices) spec.vertices.push_back(at(id));
  for (const std::int64_t id : resources) {
    const std::int32_t index = graph_.findResource(id);
    if (index < 0) reject("resource " + std::to_string(id) + " is not defined");
    spec.resources.push_back(index);
  }
  spec.measurement = std::move(measurement);
  spec.information = std::move(information);
  return graph_.addEdge(std::move(spec));
}

void FactorGraph::addResource(const std::string& tag, std::int64_t id,
                              std::vector<std::string> tokens, const std::string& directory) {
  const graft_resource_type& type =
      require(registry_.resource(tag), registry_, {Kind::kResource, tag});
  graft_message message = {};
  std::shared_ptr<const void> data = loadResource(type, directory, tokens, message);
  if (data == nullptr) reject(tag + " " + std::to_string(id) + ": " + message.text);
  graph_.addResource(type, id, std::move(tokens), std::move(data));
}

void FactorGraph::fix(std::int64_t id, bool fixed) { graph_.setFixed(at(id), fixed); }

void FactorGraph::setKernel(const std::string& name, double width, const std::string& tag) {
  graph_.setKernel({&require(registry_.kernel(name), registry_, {Kind::kKernel, name}), width},
                   tag);
}

std::vector<double> FactorGraph::estimate(std::int64_t id) const {
  const VertexRef v = at(id);
  const double* numbers = values_.at(v);
  return std::vector<double>(numbers, numbers + graph_.type(v).ambient_dim);
}

void FactorGraph::setEstimate(std::int64_t id, const std::vector<double>& numbers) {
  const VertexRef v = at(id);
  const graft_vertex_type& type = graph_.type(v);
  const std::string what = std::string(type.tag) + " " + std::to_string(id);
  requireCount(what, std::size_t(type.ambient_dim), numbers.size());
  if (!std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); })) {
    reject(what + " has a number that is not finite");
  }
  std::vector<double> valid = numbers;
  graft_message message = {};
  if (callPlugin(Callback::kNormalize, type.tag, message,
                 [&] { return type.normalize(valid.data(), &message); }) != GRAFT_OK) {
    reject(what + ": " + message.text);
  }
  std::copy(valid.begin(), valid.end(), values_.at(v));
}

}  // namespace graft
