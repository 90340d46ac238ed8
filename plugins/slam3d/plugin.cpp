// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/slam3d/edges.hpp"

GRAFT_PLUGIN(slam3d, registry) {
  registry.addVertex<graft::SE3>();
  registry.addResource<graft::Se3Offset>();
  registry.add<graft::EdgeSe3>();
  registry.add<graft::EdgeSe3Prior>();
}
