// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/edge_check.hpp"

#include <stdexcept>

#include "tests/support/derivatives.hpp"

namespace graft::testing {

namespace {

/// The pointers of a batch of one edge.
struct OneEdgeBatch {
  OneEdgeBatch(const EdgeUnderTest& edge, const std::vector<std::vector<double>>& vertices) {
    for (const std::vector<double>& v : vertices) pointers.push_back(v.data());
    measurement = edge.measurement.data();
    resources = edge.resources.data();
    batch.struct_size = sizeof batch;
    batch.arity = std::int32_t(edge.slots.size());
    batch.error_dim = edge.errorDim();
    batch.measurement_dim = std::int32_t(edge.measurement.size());
    batch.resource_count = edge.type->resource_count;
    batch.count = 1;
    batch.vertices = pointers.data();
    batch.measurements = &measurement;
    batch.resources = &resources;
  }
  OneEdgeBatch(const OneEdgeBatch&) = delete;
  OneEdgeBatch& operator=(const OneEdgeBatch&) = delete;

  std::vector<const double*> pointers;
  const double* measurement = nullptr;
  const void* const* resources = nullptr;
  graft_edge_batch batch = {};
};

void require(int code, const graft_message& message) {
  if (code != GRAFT_OK) throw std::runtime_error(message.text);
}

}  // namespace

std::int32_t EdgeUnderTest::errorDim() const {
  if (type->arity != GRAFT_DYNAMIC) return type->error_dim;
  std::int32_t errors = 0;
  std::int32_t measurements = 0;
  graft_message message = {};
  require(type->shape(std::int32_t(slots.size()), &errors, &measurements, &message), message);
  return errors;
}

Eigen::VectorXd EdgeUnderTest::error(const std::vector<std::vector<double>>& vertices) const {
  const OneEdgeBatch one(*this, vertices);
  Eigen::VectorXd e(errorDim());
  graft_message message = {};
  require(type->evaluate(&one.batch, e.data(), nullptr, &message), message);
  return e;
}

Eigen::MatrixXd EdgeUnderTest::jacobian(const std::vector<std::vector<double>>& vertices) const {
  const OneEdgeBatch one(*this, vertices);
  int columns = 0;
  for (const graft_vertex_type* slot : slots) columns += slot->tangent_dim;
  Eigen::VectorXd e(errorDim());
  // An entry that is not written stays visible.
  Eigen::MatrixXd j = Eigen::MatrixXd::Constant(errorDim(), columns, 1e30);
  graft_message message = {};
  require(type->evaluate(&one.batch, e.data(), j.data(), &message), message);
  return j;
}

Eigen::MatrixXd EdgeUnderTest::numericJacobian(
    const std::vector<std::vector<double>>& vertices) const {
  int columns = 0;
  for (const graft_vertex_type* slot : slots) columns += slot->tangent_dim;
  const auto moved = [&](const Eigen::VectorXd& delta) {
    std::vector<std::vector<double>> x = vertices;
    int offset = 0;
    for (std::size_t k = 0; k < slots.size(); ++k) {
      slots[k]->plus(1, vertices[k].data(), delta.data() + offset, x[k].data());
      offset += slots[k]->tangent_dim;
    }
    return error(x);
  };
  return riddersJacobian(moved, columns);
}

std::vector<double> EdgeUnderTest::propagate(const std::vector<std::vector<double>>& vertices,
                                             int to) const {
  const OneEdgeBatch one(*this, vertices);
  std::vector<double> estimate(std::size_t(slots[std::size_t(to)]->ambient_dim));
  if (type->propagate == nullptr || type->propagate(&one.batch, to, estimate.data()) != GRAFT_OK) {
    return {};
  }
  return estimate;
}

}  // namespace graft::testing
