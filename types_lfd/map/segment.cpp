// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "types_lfd/map/occupancy_map.hpp"
#include "types_lfd/map/polygon.hpp"

namespace graft::lfd {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// One axis of the traversal: the next boundary's parameter and cell step.
struct Axis {
  int cell = 0;
  int last = 0;
  int step = 0;
  double start = 0;
  double delta = 0;

  Axis(double from, double to, int limit) : start(from), delta(to - from) {
    const int top = limit - 1;
    cell = std::clamp(static_cast<int>(std::floor(from)), 0, top);
    last = std::clamp(static_cast<int>(std::floor(to)), 0, top);
    step = last > cell ? 1 : last < cell ? -1 : 0;
  }
  /// Parameter at which the segment leaves the present cell; computed afresh
  /// from the boundary so that no rounding piles up.
  double crossing() const {
    if (cell == last) return kNever;
    const int boundary = step > 0 ? cell + 1 : cell;
    return (boundary - start) / delta;
  }
};

}  // namespace

bool OccupancyMap::segmentFree(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
  if (occupied_count_ == 0) return true;
  Eigen::Vector2d p = toGrid(a.x(), a.y());
  Eigen::Vector2d q = toGrid(b.x(), b.y());
  if (!clipToBox(p, q, {0.0, 0.0}, {static_cast<double>(width_), static_cast<double>(height_)})) {
    return true;
  }
  Axis x(p.x(), q.x(), width_);
  Axis y(p.y(), q.y(), height_);
  while (true) {
    if (cell(x.cell, y.cell) == Cell::kOccupied) return false;
    const double tx = x.crossing();
    const double ty = y.crossing();
    if (tx == kNever && ty == kNever) return true;
    if (tx == ty && (cell(x.cell + x.step, y.cell) == Cell::kOccupied ||
                     cell(x.cell, y.cell + y.step) == Cell::kOccupied)) {
      return false;
    }
    if (tx <= ty) x.cell += x.step;
    if (ty <= tx) y.cell += y.step;
  }
}

}  // namespace graft::lfd
