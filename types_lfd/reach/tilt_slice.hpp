// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "types_lfd/reach/reach_map.hpp"

namespace graft::lfd {

/// A map at one gripper height, elevation and roll, interpolated between nodes:
/// distance over the base's pose in the gripper's view. Distances are in units
/// of a twentieth of the resolution here.
class TiltSlice {
 public:
  /// Outside of the heights of the map all is unreachable.
  TiltSlice(const ReachMap& map, double height, double elevation, double roll);

  /// Anything here is, possibly, reachable.
  bool any() const { return any_; }
  /// At a node in range (psi 0 .. psiCount()-1).
  double node(int psi, int y, int x) const {
    const std::size_t i =
        (static_cast<std::size_t>(psi) * ny_ + static_cast<std::size_t>(y)) * nx_ +
        static_cast<std::size_t>(x);
    double sum = base_;
    for (int k = 0; k < count_; ++k) sum += weight_[k] * from_[k][i];
    return sum;
  }
  /// Anywhere; psi in any turn.
  double at(const Pose2& view_T_base) const;

  /// Nodes of a row, 64 to a word, that may be reachable.
  std::uint64_t maybe(int psi, int y, int word) const {
    const std::size_t i = rowIndex(psi, y) + static_cast<std::size_t>(word);
    std::uint64_t any = 0;
    for (int k = 0; k < count_; ++k) any |= maybe_[k][i];
    return any;
  }
  /// Nodes that have the map's margin_t for sure; others may have it as well.
  std::uint64_t sure(int psi, int y, int word) const {
    const std::size_t i = rowIndex(psi, y) + static_cast<std::size_t>(word);
    // Above or below the map nothing is sure.
    std::uint64_t all = base_ == 0 ? ~std::uint64_t{0} : 0;
    for (int k = 0; k < count_; ++k) all &= sure_[k][i];
    return all;
  }

  /// Nodes of a layer (psi) that may be reachable: within these, inclusive.
  ReachMap::Extent extent(int psi) const;

 private:
  std::size_t rowIndex(int psi, int y) const {
    return (static_cast<std::size_t>(psi) * ny_ + static_cast<std::size_t>(y)) *
           static_cast<std::size_t>(words_);
  }
  void add(const ReachMap& map, int z, int ring, int roll, double weight);

  const ReachGrid& grid_;
  std::size_t nx_;
  std::size_t ny_;
  int words_;
  bool any_ = false;
  int count_ = 0;
  double base_ = 0;
  double weight_[8];
  const std::int8_t* from_[8];
  const ReachMap::Extent* extents_[8];
  const std::uint64_t* maybe_[8];
  const std::uint64_t* sure_[8];
};

}  // namespace graft::lfd
