// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/slam2d_addons/lines.hpp"
#include "plugins/slam2d_addons/segments.hpp"

GRAFT_PLUGIN(slam2d_addons, registry) {
  registry.addVertex<graft::Segment2>();
  registry.addVertex<graft::Line2>();
  registry.add<graft::EdgeSe2Segment2d>();
  registry.add<graft::EdgeSe2Segment2dLine>();
  registry.add<graft::EdgeSe2Segment2dPointLine>();
  registry.add<graft::EdgeSe2Line2d>();
  registry.add<graft::EdgeLine2d>();
  registry.add<graft::EdgeLine2dPointXy>();
}
