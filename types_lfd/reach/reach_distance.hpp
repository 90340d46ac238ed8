// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "types_lfd/reach/reach_marks.hpp"

namespace graft::lfd {

/// Turns the voxels of one orientation into signed distances: how far the
/// gripper, keeping its orientation, is from the border of what it reaches;
/// positive inside. In units of `resolution` / kDistanceUnits, saturated at 127.
/// Holes of one or two voxels, which are samples that did not come, are closed.
///
/// Exact Euclidean distances between voxels within the saturation. Source:
/// Felzenszwalb, Huttenlocher, "Distance transforms of sampled functions", 2012
/// (one axis after the other).
class ReachDistance {
 public:
  static constexpr int kDistanceUnits = 20;

  /// `reach_out`, in units: added to all distances.
  ReachDistance(const ReachMarks& marks, int reach_out);

  /// Distances at the nodes of the grid, z, then y, then x fastest; valid until
  /// the next call.
  const std::vector<std::int8_t>& compute(int ring, int roll, int psi);

 private:
  bool loadVoxels(int ring, int roll, int psi);
  void closeHoles();
  /// Squared distances, in voxels, at the nodes to the nearest voxel that is
  /// `set`.
  void squaredDistances(bool set, std::vector<std::uint16_t>& result);

  const ReachMarks& marks_;
  std::vector<std::uint64_t> bits_;
  std::vector<std::uint64_t> closed_;
  std::vector<std::uint16_t> along_z_;
  std::vector<std::uint16_t> row_;
  std::vector<std::uint16_t> outside_;
  std::vector<std::uint16_t> inside_;
  std::vector<std::int8_t> result_;
  std::vector<std::int8_t> of_square_[2];  // squared distance -> value, per side
};

}  // namespace graft::lfd
