// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/slam3d_addons/lines.hpp"
#include "plugins/slam3d_addons/planes.hpp"
#include "plugins/slam3d_addons/poses.hpp"

GRAFT_PLUGIN(slam3d_addons, registry) {
  registry.addVertex<graft::EulerPose>();
  registry.addVertex<graft::Plane3>();
  registry.addVertex<graft::Line3>();
  registry.add<graft::Edge3>();
  registry.add<graft::EdgeSe3Calib>();
  registry.add<graft::EdgePlane>();
  registry.add<graft::EdgeSe3PlaneCalib>();
  registry.add<graft::EdgeSe3Line3d>();
}
