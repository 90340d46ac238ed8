// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace graft::lfd {

namespace {

std::string hex(std::uint64_t value) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

}  // namespace

BaseFilter::~BaseFilter() = default;

int ReachMap::quality(const Pose& world_T_gripper, const Pose2& world_T_base) const {
  const GripperView view = grid_.view(world_T_gripper);
  const int z = grid_.heightBin(view.position[2]);
  if (z < 0 || z >= grid_.nz) return 0;
  const Pose2 b = baseInView(view, world_T_base);
  const double x = std::floor(b.x / grid_.resolution) - grid_.x0;
  const double y = std::floor(b.y / grid_.resolution) - grid_.y0;
  if (!(x >= 0 && x < grid_.nx && y >= 0 && y < grid_.ny)) return 0;
  const auto psi = static_cast<std::size_t>(grid_.angleBin(b.theta));
  const auto row = psi * static_cast<std::size_t>(grid_.ny) + static_cast<std::size_t>(y);
  return cells_[grid_.slice(z, view.tilt) * grid_.sliceSize() +
                row * static_cast<std::size_t>(grid_.nx) + static_cast<std::size_t>(x)];
}

void ReachMap::setMargins(double margin_t, double margin_r) {
  if (!(margin_t >= 0 && margin_t < 0.5 * grid_.resolution && margin_r >= 0 &&
        margin_r < 0.5 * grid_.step())) {
    throw Error(ExitCode::kUsage, "margins of a reachability map have to be less than half a cell");
  }
  margin_t_ = margin_t;
  margin_r_ = margin_r;
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
  filled_.assign(grid_.sliceCount(), 0);
  reachable_cells_ = 0;
  const std::size_t size = grid_.sliceSize();
  for (std::size_t s = 0; s < filled_.size(); ++s) {
    const auto* begin = cells_.data() + s * size;
    filled_[s] = static_cast<std::uint32_t>(
        std::count_if(begin, begin + size, [](std::uint8_t q) { return q != 0; }));
    reachable_cells_ += filled_[s];
  }
  margin_t_ = std::min(0.02, 0.4 * grid_.resolution);
  margin_r_ = std::min(10 * 3.14159265358979323846 / 180, grid_.step() * 2 / 9);
}

int ReachMap::nearestFilledHeight(int height_bin, int tilt) const {
  int best = -1;
  for (int z = 0; z < grid_.nz; ++z) {
    if (filled_[grid_.slice(z, tilt)] == 0) continue;
    if (best < 0 || std::abs(z - height_bin) < std::abs(best - height_bin)) best = z;
  }
  return best;
}

bool ReachMap::reachableSomewhere(const Pose& world_T_gripper) const {
  const GripperView view = grid_.view(world_T_gripper);
  const int z = grid_.heightBin(view.position[2]);
  return z >= 0 && z < grid_.nz && filled_[grid_.slice(z, view.tilt)] > 0;
}

ReachMap::Heights ReachMap::heightsOfTilts(int first, int last) const {
  Heights heights;
  for (int z = 0; z < grid_.nz; ++z) {
    for (int tilt = first; tilt <= last; ++tilt) {
      if (filled_[grid_.slice(z, tilt)] == 0) continue;
      if (heights.empty()) heights.low = (z + grid_.z0) * grid_.resolution;
      heights.high = (z + grid_.z0 + 1) * grid_.resolution;
    }
  }
  return heights;
}

ReachMap::Heights ReachMap::heights(const Pose& world_T_gripper) const {
  const int tilt = grid_.view(world_T_gripper).tilt;
  return heightsOfTilts(tilt, tilt);
}

ReachMap::Heights ReachMap::heights() const { return heightsOfTilts(0, grid_.tiltCount() - 1); }

}  // namespace graft::lfd
