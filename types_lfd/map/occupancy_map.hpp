// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/geometry/se2.hpp"

namespace graft::lfd {

/// What a cell is known to be.
enum class Cell : std::uint8_t { kFree, kOccupied, kUnknown };

/// A plane map of square cells, as ROS map_server writes them.
///
/// Frames: points are metres in the map's world frame. Cell (column, row) is
/// the closed square [column, column + 1] x [row, row + 1] times resolution in
/// the grid frame; row 0 is the BOTTOM row (the last of the picture), and
/// origin = world_T_grid may be turned. A point belongs to the cell of its
/// floored grid coordinates. Unknown cells and the outside count as free.
class OccupancyMap {
 public:
  /// A map without cells: everything is outside and free.
  OccupancyMap() = default;
  /// `cells` holds width * height entries, row by row from the bottom. Throws
  /// Error(kInput) unless sizes agree and resolution is positive.
  OccupancyMap(int width, int height, double resolution, const Pose2& origin,
               std::vector<Cell> cells);

  /// Reads a map_server yaml and its PGM or PNG (path relative to the yaml).
  /// With p = (255 - v) / 255, or v / 255 under negate: occupied if
  /// p > occupied_thresh, free if p < free_thresh, else unknown; a pixel that
  /// is not fully opaque is unknown. Defects go to `diagnostics`, the map is
  /// then empty; a map that is all occupied or all unknown is a warning.
  static OccupancyMap read(const std::string& yaml_path, Diagnostics& diagnostics);

  int width() const { return width_; }
  int height() const { return height_; }
  double resolution() const { return resolution_; }
  /// world_T_grid: pose of the lower left corner of cell (0, 0).
  const Pose2& origin() const { return origin_; }
  std::size_t occupiedCount() const { return occupied_count_; }

  bool inside(double x, double y) const;
  bool occupied(double x, double y) const { return cellAt(x, y) == Cell::kOccupied; }
  /// True in a cell marked unknown; false outside.
  bool unknown(double x, double y) const { return cellAt(x, y) == Cell::kUnknown; }

  /// Exact Euclidean distance (m) from the point (x, y), not from its cell, to
  /// the nearest occupied SQUARE: 0 within or on one, infinity if there is
  /// none. Valid outside the map, too. Takes time linear in the distance.
  double clearance(double x, double y) const;
  /// Bounds of clearance() in constant time, from the exact distance transform
  /// (Felzenszwalb and Huttenlocher 2012): low <= clearance <= high, and
  /// high - low < 2.7 cells for points on the map.
  struct Bounds {
    double low;
    double high;
  };
  Bounds clearanceBounds(double x, double y) const;

  /// True if the closed segment a-b passes no occupied cell. A segment that
  /// goes exactly through a corner passes all cells around it; one that runs
  /// exactly along a grid line passes the cells that own its points.
  /// Source: Amanatides and Woo, "A fast voxel traversal algorithm", 1987.
  bool segmentFree(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const;

  /// A yaml that, with formatPgm() as `image`, reads back as this map.
  std::string formatYaml(const std::string& image) const;
  /// P5 with 0 = occupied, 254 = free, 205 = unknown.
  std::string formatPgm() const;

  // Access by cell, for those who walk over the grid.

  /// World point to grid coordinates, in cells.
  Eigen::Vector2d toGrid(double x, double y) const {
    const double dx = x - origin_.x;
    const double dy = y - origin_.y;
    return {(cosine_ * dx + sine_ * dy) * cells_per_metre_,
            (cosine_ * dy - sine_ * dx) * cells_per_metre_};
  }
  Cell cell(int column, int row) const { return cells_[index(column, row)]; }
  bool contains(int column, int row) const {
    return column >= 0 && column < width_ && row >= 0 && row < height_;
  }
  /// Smallest occupied column >= `column` of a row, or width().
  int nextOccupied(int column, int row) const { return next_[index(column, row)]; }
  /// Centre of a cell in the world.
  Eigen::Vector2d cellCenter(int column, int row) const;

 private:
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(column);
  }
  Cell cellAt(double x, double y) const;
  void prepare();
  double squaredClearanceInRow(const Eigen::Vector2d& grid_point, int column, int row) const;

  int width_ = 0;
  int height_ = 0;
  double resolution_ = 1;
  double cells_per_metre_ = 1;
  Pose2 origin_;
  double cosine_ = 1;
  double sine_ = 0;
  std::size_t occupied_count_ = 0;
  std::vector<Cell> cells_;
  std::vector<std::int32_t> next_;      ///< nearest occupied column to the right, or width
  std::vector<std::int32_t> previous_;  ///< nearest occupied column to the left, or -1
  std::vector<std::int32_t> squared_;   ///< squared distance transform, cells
};

}  // namespace graft::lfd
