// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/slam2d/edges.hpp"
#include "plugins/slam2d/landmarks.hpp"

GRAFT_PLUGIN(slam2d, registry) {
  registry.addVertex<graft::SE2>();
  registry.addVertex<graft::Point2>();
  registry.addResource<graft::Se2Offset>();
  registry.add<graft::EdgeSe2>();
  registry.add<graft::EdgeSe2Offset>();
  registry.add<graft::EdgePriorSe2>();
  registry.add<graft::EdgePriorSe2Xy>();
  registry.add<graft::EdgeSe2Xy>();
  registry.add<graft::EdgeSe2PointXyOffset>();
  registry.add<graft::EdgeSe2XyCalib>();
  registry.add<graft::EdgeBearingSe2Xy>();
  registry.add<graft::EdgePointXy>();
  registry.add<graft::EdgePriorXy>();
  registry.add<graft::EdgeSe2TwoPointsXy>();
  registry.add<graft::EdgeSe2LotsOfXy>();
}
