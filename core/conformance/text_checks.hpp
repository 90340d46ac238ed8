// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/conformance/edge_samples.hpp"

namespace graft::conformance {

/// Vertices as a graph file: what is written, read and written again must be
/// the same text, and no number may lose a bit. Throws Defect.
void requireVertexText(const Context& context, const graft_vertex_type& type);

/// The same for edges, with their vertices and resources.
void requireEdgeText(const Context& context, const EdgeSamples& samples);

}  // namespace graft::conformance
