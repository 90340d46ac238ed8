// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "types_lfd/teach/scenario.hpp"

namespace graft::lfd {

namespace {

constexpr int kSide = 240;
constexpr double kResolution = 0.05;
constexpr double kHalf = 0.5 * kSide * kResolution;

/// Marks all cells whose centre lies in the box.
void fill(std::vector<Cell>& cells, const FloorBox& box, Cell kind) {
  for (int row = 0; row < kSide; ++row) {
    const double y = (row + 0.5) * kResolution - kHalf;
    if (y < box.y_low || y > box.y_high) continue;
    for (int column = 0; column < kSide; ++column) {
      const double x = (column + 0.5) * kResolution - kHalf;
      if (x >= box.x_low && x <= box.x_high) cells[row * kSide + column] = kind;
    }
  }
}

}  // namespace

OccupancyMap drawMap(const Scenario& scenario) {
  std::vector<Cell> cells(static_cast<std::size_t>(kSide) * kSide, Cell::kUnknown);
  for (const FloorBox& box : scenario.free) fill(cells, box, Cell::kFree);
  for (const FloorBox& box : scenario.occupied) fill(cells, box, Cell::kOccupied);
  const Vec<double, 3> turn = logSO3(scenario.world_T_scene.rotation);
  const Pose2 world_T_scene(scenario.world_T_scene.translation.x(),
                            scenario.world_T_scene.translation.y(), turn.z());
  return OccupancyMap(kSide, kSide, kResolution, world_T_scene * Pose2(-kHalf, -kHalf, 0),
                      std::move(cells));
}

}  // namespace graft::lfd
