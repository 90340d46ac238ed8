// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include "core/io/graph_loader.hpp"

namespace graft {

/// A graph as text of another format.
struct Converted {
  std::string text;
  std::map<std::string, std::size_t> left_out;  ///< tags that the format has not, and how often
};

/// Poses (in space, or in the plane with z = 0) by rising id, one a line.
/// TUM: id x y z qx qy qz qw, the id in the place of the time stamp.
Converted formatTumPoses(const LoadedGraph& loaded);
/// KITTI: the upper three rows of the 4 x 4 matrix, row by row.
Converted formatKittiPoses(const LoadedGraph& loaded);

/// TORO: VERTEX2/EDGE2 and VERTEX3/EDGE3, see plugins/toro. What was read from a
/// planar TORO file comes back bit by bit; in space to rounding.
Converted formatToro(const LoadedGraph& loaded);

}  // namespace graft
