// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/edge_batch.hpp"

namespace graft {

EdgeBatch::EdgeBatch(const EdgeGroup& group, const Values& values,
                     const std::vector<double>& associations, std::int64_t begin,
                     std::int64_t end) {
  const graft_edge_type& type = *group.type;
  view_.struct_size = sizeof view_;
  view_.arity = group.arity;
  view_.error_dim = group.error_dim;
  view_.measurement_dim = group.measurement_dim;
  view_.association_dim = type.association_dim;
  view_.resource_count = type.resource_count;
  view_.count = end - begin;
  const auto count = std::size_t(view_.count);
  const auto first = std::size_t(begin);
  const auto arity = std::size_t(group.arity);
  vertices_.resize(count * arity);
  for (std::size_t i = 0; i < count * arity; ++i) {
    vertices_[i] = values.at(group.vertices[first * arity + i]);
  }
  view_.vertices = vertices_.data();
  view_.measurements = group.measurements.data() + begin;
  if (type.association_dim > 0) {
    const auto dim = std::size_t(type.association_dim);
    const auto size = std::size_t(group.error_dim) * std::size_t(group.error_dim);
    associations_.resize(count);
    information_.resize(count);
    for (std::size_t e = 0; e < count; ++e) {
      associations_[e] = associations.data() + (first + e) * dim;
      information_[e] = group.information.data() + (first + e) * size;
    }
    view_.associations = associations_.data();
    view_.information = information_.data();
  }
  if (type.resource_count > 0) {
    resources_.resize(count);
    for (std::size_t e = 0; e < count; ++e) {
      resources_[e] = group.resources.data() + (first + e) * std::size_t(type.resource_count);
    }
    view_.resources = resources_.data();
  }
}

}  // namespace graft
