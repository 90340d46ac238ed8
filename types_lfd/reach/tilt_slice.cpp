// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/tilt_slice.hpp"

#include <algorithm>
#include <cmath>

namespace graft::lfd {

namespace {

constexpr double kOutside = -127;

/// Where a value lies between nodes: the lower one, and the share of the upper.
struct Place {
  Place(double value, double limit) {
    // What is not a number is as far away as can be.
    const double v = value >= -limit ? std::min(value, limit) : -limit;
    low = static_cast<int>(std::floor(v));
    share = v - low;
  }
  int low;
  double share;
};

int wrapIndex(int i, int count) { return ((i % count) + count) % count; }

}  // namespace

TiltSlice::TiltSlice(const ReachMap& map, double height, double elevation, double roll)
    : grid_(map.grid_),
      nx_(static_cast<std::size_t>(grid_.nx)),
      ny_(static_cast<std::size_t>(grid_.ny)),
      words_(grid_.rowWords()) {
  if (!std::isfinite(height + elevation + roll)) {
    base_ = kOutside;
    return;
  }
  const Place z(height / grid_.resolution - grid_.z0, 1e6);
  const int last = grid_.ringCount() - 1;
  Place ring(std::clamp(elevation / grid_.nodeStep() + grid_.level(), 0.0, double(last)), last);
  const Place turn(grid_.rolls > 1 ? roll / grid_.rollStep() : 0, 1e6);
  for (int i = 0; i < 8; ++i) {
    const double weight = ((i & 1) != 0 ? z.share : 1 - z.share) *
                          ((i & 2) != 0 ? ring.share : 1 - ring.share) *
                          ((i & 4) != 0 ? turn.share : 1 - turn.share);
    if (weight == 0) continue;
    add(map, z.low + (i & 1), ring.low + (i >> 1 & 1),
        wrapIndex(turn.low + (i >> 2 & 1), grid_.rolls), weight);
  }
}

void TiltSlice::add(const ReachMap& map, int z, int ring, int roll, double weight) {
  const bool inside = z >= 0 && z < grid_.nz;
  const std::size_t slice = inside ? grid_.slice(z, ring, roll) : 0;
  if (!inside) {
    base_ += weight * kOutside;
    return;
  }
  any_ = any_ || map.filled_[slice] > 0;
  weight_[count_] = weight;
  from_[count_] = map.distances_.data() + slice * grid_.sliceSize();
  extents_[count_] = map.extents_.data() + slice * static_cast<std::size_t>(grid_.psiCount());
  const std::size_t rows =
      slice * static_cast<std::size_t>(grid_.psiCount()) * ny_ * static_cast<std::size_t>(words_);
  maybe_[count_] = map.maybe_.data() + rows;
  sure_[count_] = map.sure_.data() + rows;
  ++count_;
}

double TiltSlice::at(const Pose2& b) const {
  const Place x(b.x / grid_.resolution - grid_.x0, 1e6);
  const Place y(b.y / grid_.resolution - grid_.y0, 1e6);
  const Place psi(b.theta / grid_.nodeStep(), 1e6);
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const double weight = ((i & 1) != 0 ? x.share : 1 - x.share) *
                          ((i & 2) != 0 ? y.share : 1 - y.share) *
                          ((i & 4) != 0 ? psi.share : 1 - psi.share);
    const int xi = x.low + (i & 1);
    const int yi = y.low + (i >> 1 & 1);
    const bool inside = xi >= 0 && yi >= 0 && xi < grid_.nx && yi < grid_.ny;
    const int p = wrapIndex(psi.low + (i >> 2 & 1), grid_.psiCount());
    if (weight != 0) sum += weight * (inside ? node(p, yi, xi) : kOutside);
  }
  return sum;
}

ReachMap::Extent TiltSlice::extent(int psi) const {
  ReachMap::Extent all;
  for (int k = 0; k < count_; ++k) {
    const ReachMap::Extent& e = extents_[k][psi];
    all.x_low = std::min(all.x_low, e.x_low);
    all.x_high = std::max(all.x_high, e.x_high);
    all.y_low = std::min(all.y_low, e.y_low);
    all.y_high = std::max(all.y_high, e.y_high);
  }
  return all;
}

}  // namespace graft::lfd
