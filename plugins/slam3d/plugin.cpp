// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/slam3d/edges.hpp"
#include "plugins/slam3d/landmarks.hpp"

GRAFT_PLUGIN(slam3d, registry) {
  registry.addVertex<graft::SE3>();
  registry.addVertex<graft::Point3>();
  registry.addResource<graft::Se3Offset>();
  registry.addResource<graft::Camera>();
  registry.addResource<graft::StereoCamera>();
  registry.add<graft::EdgeSe3>();
  registry.add<graft::EdgeSe3Offset>();
  registry.add<graft::EdgeSe3Prior>();
  registry.add<graft::EdgeSe3XyzPrior>();
  registry.add<graft::EdgeSe3TrackXyz>();
  registry.add<graft::EdgeProjectDepth>();
  registry.add<graft::EdgeProjectDisparity>();
  registry.add<graft::EdgePointXyz>();
  registry.add<graft::EdgePointXyzPrior>();
  registry.add<graft::EdgeSe3LotsOfXyz>();
}
