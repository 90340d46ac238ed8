// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/slam2d/edges.hpp"

GRAFT_PLUGIN(slam2d, registry) {
  registry.addVertex<graft::SE2>();
  registry.addVertex<graft::Point2>();
  registry.add<graft::EdgeSe2>();
  registry.add<graft::EdgeSe2Xy>();
  registry.add<graft::EdgePriorSe2>();
}
