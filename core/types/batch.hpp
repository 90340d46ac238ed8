// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/types/abi.h"

namespace graft {

/// Edge number `edge` of a batch, as a batch of one; points into the same arrays.
inline graft_edge_batch singleEdge(const graft_edge_batch& batch, std::int64_t edge) {
  graft_edge_batch one = batch;
  one.count = 1;
  one.vertices += edge * batch.arity;
  one.measurements += edge;
  if (one.associations != nullptr) one.associations += edge;
  if (one.information != nullptr) one.information += edge;
  if (one.resources != nullptr) one.resources += edge;
  return one;
}

}  // namespace graft
