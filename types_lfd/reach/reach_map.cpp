// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "types_lfd/reach/reach_distance.hpp"
#include "types_lfd/reach/tilt_slice.hpp"

namespace graft::lfd {

namespace {

std::string hex(std::uint64_t value) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

}  // namespace

BaseFilter::~BaseFilter() = default;

double ReachMap::distance(const Pose& world_T_gripper, const Pose2& world_T_base) const {
  const GripperView view = ReachGrid::view(world_T_gripper);
  const TiltSlice slice(*this, view.position[2], view.elevation, view.roll);
  return slice.at(baseInView(view, world_T_base)) * grid_.resolution /
         ReachDistance::kDistanceUnits;
}

int ReachMap::quality(const Pose& world_T_gripper, const Pose2& world_T_base) const {
  if (!contains(world_T_gripper, world_T_base)) return 0;
  const GripperView view = ReachGrid::view(world_T_gripper);
  const Pose2 b = baseInView(view, world_T_base);
  const auto nearest = [](double value, int first, int count) {
    return std::clamp(static_cast<int>(std::lround(value)) - first, 0, count - 1);
  };
  const double cell = grid_.fine * grid_.nodeStep();
  const int ring = nearest(view.elevation / cell, -grid_.turn / 4, grid_.cellRings());
  const int psi = static_cast<int>(std::lround(b.theta / cell));
  const int quality = cells_[grid_.cell(
      nearest(view.position[2] / grid_.resolution, grid_.z0, grid_.nz), ring,
      (psi + grid_.turn) % grid_.turn, nearest(b.y / grid_.resolution, grid_.y0, grid_.ny),
      nearest(b.x / grid_.resolution, grid_.x0, grid_.nx))];
  // A cell may be reachable only away from its centre, where quality is taken.
  return std::max(1, quality);
}

void ReachMap::setMargins(double margin_t, double margin_r) {
  if (!(margin_t >= 0 && margin_t < 0.5 * grid_.resolution && margin_r >= 0 &&
        margin_r < grid_.nodeStep())) {
    throw Error(
        ExitCode::kUsage,
        "margins of a reachability map have to be less than half a cell, and a node's distance");
  }
  margin_t_ = margin_t;
  margin_r_ = margin_r;
  const double units = margin_t / grid_.resolution * ReachDistance::kDistanceUnits;
  fillRows(1 + static_cast<int>(std::floor(units)), sure_);
}

void ReachMap::requireChain(const Chain& chain, const std::string& path) const {
  if (chain_hash_ == chain.hash()) return;
  throw Error(ExitCode::kInput, {path, 0, 0},
              "the map was built for robot " + quoted(robot_) + ", chain " + quoted(base_link_) +
                  " to " + quoted(tip_link_) + " (" + hex(chain_hash_) + "), not for " +
                  quoted(chain.robotName()) + ", " + quoted(chain.baseLink()) + " to " +
                  quoted(chain.tipLink()) + " (" + hex(chain.hash()) + ")");
}

void ReachMap::finish() {
  const auto layers = grid_.sliceCount() * static_cast<std::size_t>(grid_.psiCount());
  filled_.assign(grid_.sliceCount(), 0);
  extents_.assign(layers, Extent());
  reachable_cells_ = 0;
  const std::int8_t* node = distances_.data();
  for (std::size_t layer = 0; layer < layers; ++layer) {
    Extent& extent = extents_[layer];
    std::uint32_t count = 0;
    for (int y = 0; y < grid_.ny; ++y) {
      for (int x = 0; x < grid_.nx; ++x, ++node) {
        if (*node <= 0) continue;
        ++count;
        extent.x_low = std::min(extent.x_low, static_cast<std::int16_t>(x));
        extent.x_high = std::max(extent.x_high, static_cast<std::int16_t>(x));
        extent.y_low = std::min(extent.y_low, static_cast<std::int16_t>(y));
        extent.y_high = std::max(extent.y_high, static_cast<std::int16_t>(y));
      }
    }
    filled_[layer / static_cast<std::size_t>(grid_.psiCount())] += count;
    reachable_cells_ += count;
  }
  fillRows(1, maybe_);
  setMargins(0.2 * grid_.resolution, 0);
}

void ReachMap::fillRows(int least, std::vector<std::uint64_t>& rows) const {
  const auto words = static_cast<std::size_t>(grid_.rowWords());
  const auto nx = static_cast<std::size_t>(grid_.nx);
  const std::size_t count = distances_.size() / nx;
  rows.assign(count * words, 0);
  for (std::size_t row = 0; row < count; ++row) {
    const std::int8_t* node = distances_.data() + row * nx;
    for (std::size_t x = 0; x < nx; ++x) {
      if (node[x] >= least) rows[row * words + x / 64] |= std::uint64_t{1} << (x % 64);
    }
  }
}

bool ReachMap::reachableSomewhere(const GripperView& view, double height) const {
  const TiltSlice slice(*this, height, view.elevation, view.roll);
  if (!slice.any()) return false;
  // Interpolated in x, y and psi: the largest distance is at a node.
  for (int psi = 0; psi < grid_.psiCount(); ++psi) {
    for (int y = 0; y < grid_.ny; ++y) {
      for (int word = 0; word < grid_.rowWords(); ++word) {
        for (std::uint64_t bits = slice.maybe(psi, y, word); bits != 0; bits &= bits - 1) {
          if (slice.node(psi, y, 64 * word + __builtin_ctzll(bits)) > 0) return true;
        }
      }
    }
  }
  return false;
}

bool ReachMap::reachableSomewhere(const Pose& world_T_gripper) const {
  const GripperView view = ReachGrid::view(world_T_gripper);
  return std::isfinite(view.position[2] + view.elevation + view.roll) &&
         reachableSomewhere(view, view.position[2]);
}

ReachMap::Heights ReachMap::heights(const Pose& world_T_gripper) const {
  const GripperView view = ReachGrid::view(world_T_gripper);
  const auto reached = [&](double height) { return reachableSomewhere(view, height); };
  // Linear between nodes: what lies between two that are not reached is not, too.
  const auto border = [&](double out, double in) {
    for (int i = 0; i < 20; ++i) {
      const double middle = 0.5 * (out + in);
      (reached(middle) ? in : out) = middle;
    }
    return in;
  };
  Heights heights;
  for (int z = 0; z < grid_.nz; ++z) {
    const double height = (z + grid_.z0) * grid_.resolution;
    if (!reached(height)) continue;
    if (heights.empty()) heights.low = border(height - grid_.resolution, height);
    heights.high = height;
  }
  if (!heights.empty()) heights.high = border(heights.high + grid_.resolution, heights.high);
  return heights;
}

ReachMap::Heights ReachMap::heights() const {
  Heights heights;
  const std::size_t tilts = grid_.sliceCount() / static_cast<std::size_t>(grid_.nz);
  for (int z = 0; z < grid_.nz; ++z) {
    const auto first = filled_.begin() + static_cast<std::ptrdiff_t>(tilts) * z;
    if (std::all_of(first, first + static_cast<std::ptrdiff_t>(tilts),
                    [](std::uint32_t count) { return count == 0; })) {
      continue;
    }
    // Up to the next node, where nothing is reached any more.
    if (heights.empty()) heights.low = (z - 1 + grid_.z0) * grid_.resolution;
    heights.high = (z + 1 + grid_.z0) * grid_.resolution;
  }
  return heights;
}

}  // namespace graft::lfd
