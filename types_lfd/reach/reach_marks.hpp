// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "types_lfd/reach/reach_grid.hpp"

namespace graft::lfd {

/// What samples found: voxels of half a node's distance for every node in
/// elevation, roll and psi, as columns of bits along z, since a torso marks a
/// whole interval at once; and the best quality per cell. Marking is a logical
/// or, and a maximum, so that threads may come in any order and the result is
/// the same.
class ReachMarks {
 public:
  explicit ReachMarks(const ReachGrid& grid)
      : grid_(grid),
        words_((2 * grid.nz + 63) / 64),
        columns_(size(grid.ringCount()) * size(grid.rolls) * size(grid.psiCount()) * size(ny()) *
                 size(nx()) * size(words_)),
        qualities_(grid.cellCount()) {}

  int nx() const { return 2 * grid_.nx; }
  int ny() const { return 2 * grid_.ny; }
  int nz() const { return 2 * grid_.nz; }
  /// 64-bit words per column.
  int words() const { return words_; }
  double voxel() const { return 0.5 * grid_.resolution; }
  const ReachGrid& grid() const { return grid_; }

  /// Voxels z_first .. z_last of a column.
  void mark(int ring, int roll, int psi, int y, int x, int z_first, int z_last) {
    std::atomic<std::uint64_t>* column = columns_.data() + index(ring, roll, psi, y, x);
    for (int w = z_first / 64; w <= z_last / 64; ++w) {
      const int low = z_first > 64 * w ? z_first - 64 * w : 0;
      const int high = z_last < 64 * w + 63 ? z_last - 64 * w : 63;
      const std::uint64_t bits = (~std::uint64_t{0} >> (63 - high)) & (~std::uint64_t{0} << low);
      if ((column[w].load(std::memory_order_relaxed) & bits) != bits) {
        column[w].fetch_or(bits, std::memory_order_relaxed);
      }
    }
  }

  void raise(std::size_t cell, std::uint8_t quality) {
    std::atomic<std::uint8_t>& place = qualities_[cell];
    std::uint8_t old = place.load(std::memory_order_relaxed);
    while (old < quality && !place.compare_exchange_weak(old, quality, std::memory_order_relaxed)) {
    }
  }

  /// The columns of one (elevation, roll, psi): y, then x, stride() words apart.
  const std::atomic<std::uint64_t>* slice(int ring, int roll, int psi) const {
    return columns_.data() + index(ring, roll, psi, 0, 0);
  }
  std::size_t stride() const { return size(grid_.rolls) * size(words_); }
  std::uint8_t quality(std::size_t cell) const {
    return qualities_[cell].load(std::memory_order_relaxed);
  }

  std::uint64_t count() const {
    std::uint64_t n = 0;
    for (const auto& word : columns_) {
      n += static_cast<std::uint64_t>(__builtin_popcountll(word.load(std::memory_order_relaxed)));
    }
    return n;
  }

 private:
  static std::size_t size(int n) { return static_cast<std::size_t>(n); }
  std::size_t index(int ring, int roll, int psi, int y, int x) const {
    const std::size_t level = size(ring) * size(grid_.psiCount()) + size(psi);
    return (((level * size(ny()) + size(y)) * size(nx()) + size(x)) * size(grid_.rolls) +
            size(roll)) *
           size(words_);
  }

  ReachGrid grid_;
  int words_;
  std::vector<std::atomic<std::uint64_t>> columns_;
  std::vector<std::atomic<std::uint8_t>> qualities_;
};

}  // namespace graft::lfd
