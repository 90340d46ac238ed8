// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/geometry/se2.hpp"
#include "core/geometry/se3.hpp"
#include "types_lfd/reach/reach_grid.hpp"
#include "types_lfd/robot/chain.hpp"

namespace graft::lfd {

/// How to build a map. What is here, except `threads`, decides the result.
struct ReachOptions {
  double resolution = 0.05;                          ///< m
  double angular_step = 3.14159265358979323846 / 4;  ///< rad; divides a quarter turn
  std::uint64_t seed = 1;
  /// Sampling ends when doubling the samples adds less than this share of
  /// voxels (half a cell in x, y, z, angle), or at max_samples.
  double new_cell_share = 0.01;
  std::uint64_t max_samples = std::uint64_t{1} << 21;
  int threads = 0;  ///< 0 = all; the result is the same for any number
};

/// Called from the building thread with a fraction 0 .. 1 that never falls.
using ReachProgress = std::function<void(double fraction)>;

/// Tells which base poses are allowed (free of collision, say).
struct BaseFilter {
  virtual ~BaseFilter();
  virtual bool isFree(const Pose2& world_T_base) const = 0;
};

/// Answer of ReachMap::nearest.
struct NearestBase {
  /// A feasible (and free) base pose exists for this gripper pose. Otherwise
  /// `base` is the nearest one ignoring the filter, at the nearest gripper
  /// height that has any for this tilt; or the query itself, with infinite
  /// cost, if there is none at all.
  bool found = false;
  /// The query itself is feasible, keeps the margins, and is free; cost is 0.
  bool inside = false;
  Pose2 base;
  /// |dxy|^2 / sigma_t^2 + dyaw^2 / sigma_r^2 between query and base.
  double cost = 0;
};

/// Where an upright base can stand so that the gripper reaches a pose: the
/// inverse reachability map of a mobile robot on a flat floor. Base poses are
/// base_link in the plane z = 0; gripper poses are in space.
///
/// The map holds, at the nodes of a ReachGrid, the signed distance of the gripper
/// (m, keeping its orientation) from the border of what the arm reaches, and in
/// between interpolates it in all six coordinates. A pose is reachable where
/// this is positive: the border runs between the nodes, not along the cells.
/// Sources: Vahrenkamp, Asfour, Dillmann, "Robot placement based on reachability
/// inversion", ICRA 2013 (oriented reachability maps); Rudorfer, "RM4D", ICRA
/// 2025 (cells that share the rotation about the vertical).
class ReachMap {
 public:
  /// Samples joint vectors within their limits. Throws Error(kUsage) for options
  /// out of range and Error(kResources) where the map would exceed 2 GiB.
  static ReachMap build(const Chain& chain, const ReachOptions& options = ReachOptions(),
                        const ReachProgress& progress = ReachProgress());

  /// Reads a map written by save(). Throws Error(kInput) with the path for a
  /// file that is not exactly that.
  static ReachMap load(const std::string& path);
  /// Writes the map (little endian, with checksum); the file appears whole.
  void save(const std::string& path) const;

  bool contains(const Pose& world_T_gripper, const Pose2& world_T_base) const {
    return distance(world_T_gripper, world_T_base) > 0;
  }
  /// Signed distance (m) from the border of what is reachable, positive inside,
  /// saturated at 6.35 times the resolution.
  double distance(const Pose& world_T_gripper, const Pose2& world_T_base) const;
  /// 0 = not reachable; 1 .. 255 = best manipulability found in the cell, 255
  /// being the arm's best (Yoshikawa's measure, 1985).
  int quality(const Pose& world_T_gripper, const Pose2& world_T_base) const;

  /// Whether any base reaches the gripper pose.
  bool reachableSomewhere(const Pose& world_T_gripper) const;
  /// Gripper heights (m) between which some base reaches: with this pose's tilt,
  /// or with any. Low above high if there is none.
  struct Heights {
    double low = 0;
    double high = -1;
    bool empty() const { return low > high; }
  };
  Heights heights(const Pose& world_T_gripper) const;
  Heights heights() const;

  /// The base pose nearest to the query that reaches the gripper pose and keeps
  /// the margins: the query itself, or else the nearest point of all boxes
  /// between neighbouring nodes (x, y, psi) in which all poses do, drawn back
  /// towards the query, by a cell at most, to where the margins begin. With a
  /// filter: the first box, nearest first, where that (or its nearest point) is
  /// free.
  NearestBase nearest(const Pose& world_T_gripper, const Pose2& world_T_base, double sigma_t,
                      double sigma_r, const BaseFilter* filter = nullptr) const;

  /// What nearest() keeps: the distance (m) from the border, also when the base
  /// turns by margin_r (rad) to either side. Less than half a cell and a node's distance. Default:
  /// a fifth of a cell, and 0.
  void setMargins(double margin_t, double margin_r);
  double marginT() const { return margin_t_; }
  double marginR() const { return margin_r_; }

  /// Throws Error(kInput) unless the map was built for this chain.
  void requireChain(const Chain& chain, const std::string& path) const;

  /// Nodes within which a layer (psi) has any that are reachable, inclusive.
  struct Extent {
    std::int16_t x_low = 32767;
    std::int16_t x_high = -1;
    std::int16_t y_low = 32767;
    std::int16_t y_high = -1;
  };

  const ReachGrid& grid() const { return grid_; }
  const std::string& robotName() const { return robot_; }
  const std::string& baseLink() const { return base_link_; }
  const std::string& tipLink() const { return tip_link_; }
  std::uint64_t chainHash() const { return chain_hash_; }
  std::uint64_t seed() const { return seed_; }
  std::uint64_t samples() const { return samples_; }
  /// Share of the map's voxels that half of the samples had found already.
  double coverage() const { return coverage_; }
  /// Nodes that are reachable.
  std::uint64_t reachableCells() const { return reachable_cells_; }
  /// Quality bytes by ReachGrid::cell.
  const std::vector<std::uint8_t>& cells() const { return cells_; }
  /// Distances in ReachGrid's order (height, elevation, roll, psi, y, x), in
  /// units of a twentieth of the resolution.
  const std::vector<std::int8_t>& distances() const { return distances_; }

 private:
  friend class ReachBuilder;
  friend class TiltSlice;
  ReachMap() = default;

  /// Fills what follows from the grid and the distances.
  void finish();
  void fillRows(int least, std::vector<std::uint64_t>& rows) const;
  bool reachableSomewhere(const GripperView& view, double height) const;

  ReachGrid grid_;
  std::vector<std::int8_t> distances_;
  std::vector<std::uint8_t> cells_;
  std::vector<std::uint32_t> filled_;  // reachable nodes per slice
  std::vector<Extent> extents_;        // per slice and psi
  // A bit per node: may be reachable in between, and keeps margin_t.
  std::vector<std::uint64_t> maybe_;
  std::vector<std::uint64_t> sure_;
  std::uint64_t reachable_cells_ = 0;
  std::string robot_;
  std::string base_link_;
  std::string tip_link_;
  std::uint64_t chain_hash_ = 0;
  std::uint64_t seed_ = 0;
  std::uint64_t samples_ = 0;
  double coverage_ = 0;
  double best_manipulability_ = 0;
  double margin_t_ = 0;
  double margin_r_ = 0;
};

}  // namespace graft::lfd
