// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/conformance/function_checks.hpp"
#include "core/conformance/sampler.hpp"

namespace graft::conformance {

/// Edges of one type and shape with valid inputs: those of the example graph
/// first, then random ones. Arrays over edges are contiguous.
struct EdgeSamples {
  const graft_edge_type* type = nullptr;
  int arity = 0;
  int error_dim = 0;
  int measurement_dim = 0;
  int tangent_dim = 0;  ///< of all slots together
  std::vector<const graft_vertex_type*> slots;
  std::vector<ResourceSample> resources;  ///< the same for all edges
  std::int64_t count = 0;
  std::vector<std::vector<double>> vertices;  ///< per slot
  std::vector<double> measurements;
  std::vector<double> associations;  ///< as associate() chose them
};

/// A batch over arrays of numbers, as the engine hands it to a plugin.
class Batch {
 public:
  /// `vertices`: per slot; `measurements`, `associations`: null if there are none.
  Batch(const EdgeSamples& samples, std::int64_t count, const std::vector<const double*>& vertices,
        const double* measurements, const double* associations);
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;
  const graft_edge_batch* get() const { return &batch_; }

 private:
  std::vector<const double*> vertices_;
  std::vector<const double*> measurements_;
  std::vector<const double*> associations_;
  std::vector<double> identity_;
  std::vector<const double*> information_;
  std::vector<const void*> edge_resources_;
  std::vector<const void* const*> resources_;
  graft_edge_batch batch_ = {};
};

/// Samples of a type. Types of dynamic arity: `larger` chooses the second arity
/// that shape() accepts instead of the first. Throws Skip where no valid input
/// can be made, and Defect where shape() or associate() are wrong.
EdgeSamples sampleEdges(const Context& context, const graft_edge_type& type, bool larger);

/// The same edges with all vertices at their identity.
EdgeSamples atIdentity(EdgeSamples samples);

/// evaluate() as a function of the vertices, the measurement and the association.
Function evaluateFunction(const EdgeSamples& samples, bool jacobians);

/// associate() with `first` set, as a function of vertices and measurement.
Function associateFunction(const EdgeSamples& samples);

}  // namespace graft::conformance
