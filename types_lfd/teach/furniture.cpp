// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/furniture.hpp"

#include <cmath>

namespace graft::lfd {

Pose Furniture::handle(double opening, double press) const {
  if (kind == Kind::kSlider) {
    return Pose(Eigen::Vector3d(-standoff, 0, height) + opening * travel * direction,
                Eigen::Quaterniond::Identity());
  }
  const Pose swing(Eigen::Vector3d::Zero(),
                   expSO3<double>(Eigen::Vector3d(0, 0, opening * travel)));
  const Pose root(Eigen::Vector3d(-standoff, radius + lever_arm, height),
                  expSO3<double>(Eigen::Vector3d(press * lever_press, 0, 0)));
  const Pose along(Eigen::Vector3d(0, -lever_arm, 0), Eigen::Quaterniond::Identity());
  return swing * root * along;
}

}  // namespace graft::lfd
