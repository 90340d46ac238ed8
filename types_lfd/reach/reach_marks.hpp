// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <vector>

#include "types_lfd/reach/reach_grid.hpp"

namespace graft::lfd {

/// The cells of a map while it is built, with height fastest, then roll, since
/// one sample marks ranges of both. Marking takes the maximum, so that threads
/// may come in any order and the result is the same.
class ReachMarks {
 public:
  explicit ReachMarks(const ReachGrid& grid)
      : grid_(grid),
        cells_(static_cast<std::size_t>(grid.ringCount() + 2) * grid.sliceSize() *
               static_cast<std::size_t>(grid.turn) * static_cast<std::size_t>(grid.nz)) {}

  /// First cell (roll 0, lowest height) of a column; `ring` is -turn/4 .. turn/4,
  /// the ends being the caps, which use roll 0 only.
  std::size_t column(int ring, int psi, int y, int x) const {
    const std::size_t level =
        index(index(static_cast<std::size_t>(ring + grid_.turn / 4), grid_.turn, psi), grid_.ny, y);
    return index(index(level, grid_.nx, x), grid_.turn, 0) * static_cast<std::size_t>(grid_.nz);
  }

  void raise(std::size_t column, int roll, int z_first, int z_last, std::uint8_t quality) {
    std::atomic<std::uint8_t>* cell =
        cells_.data() + column + index(static_cast<std::size_t>(roll), grid_.nz, 0);
    for (int z = z_first; z <= z_last; ++z) {
      std::uint8_t old = cell[z].load(std::memory_order_relaxed);
      while (old < quality &&
             !cell[z].compare_exchange_weak(old, quality, std::memory_order_relaxed)) {
      }
    }
  }

  std::uint64_t count() const {
    return static_cast<std::uint64_t>(
        std::count_if(cells_.begin(), cells_.end(),
                      [](const auto& cell) { return cell.load(std::memory_order_relaxed) != 0; }));
  }

  /// use(ring, psi, y, x, roll, z, quality) for every marked cell.
  template <class Use>
  void forEach(const Use& use) const {
    std::size_t i = 0;
    for (int ring = -grid_.turn / 4; ring <= grid_.turn / 4; ++ring) {
      for (int psi = 0; psi < grid_.turn; ++psi) {
        for (int y = 0; y < grid_.ny; ++y) {
          for (int x = 0; x < grid_.nx; ++x) {
            for (int roll = 0; roll < grid_.turn; ++roll) {
              for (int z = 0; z < grid_.nz; ++z, ++i) {
                const std::uint8_t quality = cells_[i].load(std::memory_order_relaxed);
                if (quality != 0) use(ring, psi, y, x, roll, z, quality);
              }
            }
          }
        }
      }
    }
  }

 private:
  static std::size_t index(std::size_t outer, int size, int inner) {
    return outer * static_cast<std::size_t>(size) + static_cast<std::size_t>(inner);
  }

  ReachGrid grid_;
  std::vector<std::atomic<std::uint8_t>> cells_;
};

}  // namespace graft::lfd
