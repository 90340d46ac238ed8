// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/geometry/se2.hpp"
#include "types_lfd/build/prepare.hpp"
#include "types_lfd/build/scene.hpp"

namespace graft::lfd {

/// Where the bases of every demonstration begin, a pose per tuple: at the grasp the base
/// nearest to the torso that reaches and is free of the map; before and after it, the one
/// nearest to its neighbour's. Nearest to the torso everywhere, a path tears where the
/// person walks past the handle: bases on either side of it, which no iteration brings
/// together.
std::vector<std::vector<Pose2>> startBases(const PreparedTask& task, const TaskScene& scene);

}  // namespace graft::lfd
