// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <vector>

#include "types_lfd/map/occupancy_map.hpp"

namespace graft::lfd::testing {

inline double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// A map of random size and turned origin with about `share` of its cells
/// occupied and some unknown.
inline OccupancyMap randomMap(std::mt19937_64& random, double share, int side) {
  const int width = 1 + static_cast<int>(random() % side);
  const int height = 1 + static_cast<int>(random() % side);
  std::vector<Cell> cells(static_cast<std::size_t>(width) * height);
  for (Cell& cell : cells) {
    const double u = uniform(random, 0, 1);
    cell = u < share ? Cell::kOccupied : u > 0.9 ? Cell::kUnknown : Cell::kFree;
  }
  const Pose2 origin(uniform(random, -3, 3), uniform(random, -3, 3), uniform(random, -4, 4));
  return OccupancyMap(width, height, uniform(random, 0.02, 0.2), origin, cells);
}

}  // namespace graft::lfd::testing
