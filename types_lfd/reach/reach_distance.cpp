// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_distance.hpp"

#include <algorithm>
#include <cmath>

namespace graft::lfd {

namespace {

constexpr int kFar = 13;  // voxels; beyond the saturation of 127 units
constexpr int kFarSquare = kFar * kFar;

bool bitAt(const std::uint64_t* column, int z) { return (column[z / 64] >> (z % 64) & 1) != 0; }

}  // namespace

ReachDistance::ReachDistance(const ReachMarks& marks, int reach_out) : marks_(marks) {
  const auto columns = static_cast<std::size_t>(marks.nx()) * static_cast<std::size_t>(marks.ny());
  const ReachGrid& grid = marks.grid();
  bits_.resize(columns * static_cast<std::size_t>(marks.words()));
  closed_.resize(bits_.size());
  along_z_.resize(columns * static_cast<std::size_t>(grid.nz));
  row_.resize(static_cast<std::size_t>(marks.nx()) + 2 * kFar);
  result_.resize(grid.layerSize() * static_cast<std::size_t>(grid.nz));
  outside_.resize(result_.size());
  inside_.resize(result_.size());
  for (int side = 0; side < 2; ++side) {
    for (int square = 0; square <= kFarSquare; ++square) {
      // The border runs half way between a voxel that is set and one that is not.
      const double voxels = std::sqrt(square) - 0.5;
      const double units = (side == 0 ? -voxels : voxels) * kDistanceUnits / 2.0 + reach_out;
      of_square_[side].push_back(
          static_cast<std::int8_t>(std::clamp(std::round(units), -127.0, 127.0)));
    }
  }
}

bool ReachDistance::loadVoxels(int ring, int roll, int psi) {
  const auto* slice = marks_.slice(ring, roll, psi);
  std::uint64_t any = 0;
  const auto words = static_cast<std::size_t>(marks_.words());
  for (std::size_t i = 0; i < bits_.size(); i += words, slice += marks_.stride()) {
    for (std::size_t w = 0; w < words; ++w) {
      bits_[i + w] = slice[w].load(std::memory_order_relaxed);
      any |= bits_[i + w];
    }
  }
  return any != 0;
}

/// A voxel between two that are set on opposite sides is set, too.
void ReachDistance::closeHoles() {
  const int nx = marks_.nx();
  const int ny = marks_.ny();
  const int words = marks_.words();
  const auto at = [&](int y, int x) {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(nx) +
            static_cast<std::size_t>(x)) *
           static_cast<std::size_t>(words);
  };
  closed_ = bits_;
  for (int y = 1; y + 1 < ny; ++y) {
    for (int x = 1; x + 1 < nx; ++x) {
      const std::size_t i = at(y, x);
      for (int w = 0; w < words; ++w) {
        const auto k = static_cast<std::size_t>(w);
        const std::uint64_t here = bits_[i + k];
        const std::uint64_t below = here << 1 | (w > 0 ? bits_[i + k - 1] >> 63 : 0);
        const std::uint64_t above = here >> 1 | (w + 1 < words ? bits_[i + k + 1] << 63 : 0);
        const std::uint64_t x_pair = bits_[at(y, x - 1) + k] & bits_[at(y, x + 1) + k];
        const std::uint64_t y_pair = bits_[at(y - 1, x) + k] & bits_[at(y + 1, x) + k];
        closed_[i + k] = here | (below & above) | x_pair | y_pair;
      }
    }
  }
  bits_.swap(closed_);
}

void ReachDistance::squaredDistances(bool set, std::vector<std::uint16_t>& result) {
  const int nx = marks_.nx();
  const int ny = marks_.ny();
  const int nz = marks_.nz();
  const ReachGrid& grid = marks_.grid();
  const auto row_size = static_cast<std::size_t>(nx);
  const std::size_t layer = row_size * static_cast<std::size_t>(ny);
  const auto words = static_cast<std::size_t>(marks_.words());
  for (std::size_t c = 0; c < layer; ++c) {
    const std::uint64_t* column = bits_.data() + c * words;
    const bool empty =
        std::all_of(column, column + words, [](std::uint64_t word) { return word == 0; });
    std::uint16_t* to = along_z_.data() + c;
    if (empty) {
      for (int k = 0; k < grid.nz; ++k, to += layer) *to = set ? kFarSquare : 0;
      continue;
    }
    int distance = kFar;
    for (int z = 0; z < nz; ++z) {
      distance = bitAt(column, z) == set ? 0 : std::min(distance + 1, kFar);
      if (z % 2 == 0)
        to[static_cast<std::size_t>(z / 2) * layer] = static_cast<std::uint16_t>(distance);
    }
    distance = kFar;
    for (int z = nz - 1; z >= 0; --z) {
      distance = bitAt(column, z) == set ? 0 : std::min(distance + 1, kFar);
      if (z % 2 != 0) continue;
      std::uint16_t& d = to[static_cast<std::size_t>(z / 2) * layer];
      d = static_cast<std::uint16_t>(std::min<int>(d, distance));
      d = static_cast<std::uint16_t>(d * d);
    }
  }
  std::size_t out = 0;
  for (int k = 0; k < grid.nz; ++k) {
    for (int y = 0; y < ny; y += 2) {
      std::fill(row_.begin(), row_.end(), static_cast<std::uint16_t>(kFarSquare));
      std::uint16_t* row = row_.data() + kFar;
      for (int d = -kFar; d <= kFar; ++d) {
        if (y + d < 0 || y + d >= ny) continue;
        const std::uint16_t* from = along_z_.data() + static_cast<std::size_t>(k) * layer +
                                    static_cast<std::size_t>(y + d) * row_size;
        const auto square = static_cast<std::uint16_t>(d * d);
        for (int x = 0; x < nx; ++x) {
          row[x] = std::min(row[x], static_cast<std::uint16_t>(from[x] + square));
        }
      }
      for (int x = 0; x < nx; x += 2) {
        int best = kFarSquare;
        for (int d = -kFar; d <= kFar; ++d) best = std::min(best, row[x + d] + d * d);
        result[out++] = static_cast<std::uint16_t>(best);
      }
    }
  }
}

const std::vector<std::int8_t>& ReachDistance::compute(int ring, int roll, int psi) {
  if (!loadVoxels(ring, roll, psi)) {
    std::fill(result_.begin(), result_.end(), static_cast<std::int8_t>(-127));
    return result_;
  }
  closeHoles();
  closeHoles();
  squaredDistances(true, outside_);
  squaredDistances(false, inside_);
  for (std::size_t i = 0; i < result_.size(); ++i) {
    result_[i] = inside_[i] > 0 ? of_square_[1][inside_[i]] : of_square_[0][outside_[i]];
  }
  return result_;
}

}  // namespace graft::lfd
