// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/map/occupancy_map.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "core/base/file.hpp"
#include "core/base/text.hpp"
#include "types_lfd/map/distance_transform.hpp"
#include "types_lfd/map/grey_image.hpp"
#include "types_lfd/map/map_yaml.hpp"

namespace graft::lfd {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kHalfDiagonal = 0.70710678118654752440;

double square(double x) { return x * x; }

Cell classify(const MapYaml& yaml, double value) {
  const double p = yaml.negate ? value : 1.0 - value;
  if (p > yaml.occupied_thresh) return Cell::kOccupied;
  return p < yaml.free_thresh ? Cell::kFree : Cell::kUnknown;
}

/// The picture as cells from the bottom row up, with a count of what is odd.
std::vector<Cell> toCells(const GreyImage& image, const MapYaml& yaml, const std::string& path,
                          Diagnostics& diagnostics) {
  std::vector<Cell> cells(image.values.size());
  std::size_t transparent = 0;
  for (int row = 0; row < image.height; ++row) {
    const std::size_t from = static_cast<std::size_t>(image.height - 1 - row) * image.width;
    const std::size_t to = static_cast<std::size_t>(row) * image.width;
    for (int column = 0; column < image.width; ++column) {
      const bool clear = !image.transparent.empty() && image.transparent[from + column];
      transparent += clear;
      cells[to + column] = clear ? Cell::kUnknown : classify(yaml, image.values[from + column]);
    }
  }
  if (transparent > 0) {
    diagnostics.note({path, 0, 0}, std::to_string(transparent) +
                                       " pixels are not opaque; their cells are unknown");
  }
  const auto all = [&cells](Cell kind) {
    return std::all_of(cells.begin(), cells.end(), [kind](Cell c) { return c == kind; });
  };
  if (all(Cell::kOccupied)) diagnostics.warning({path, 0, 0}, "every cell of the map is occupied");
  if (all(Cell::kUnknown)) diagnostics.warning({path, 0, 0}, "every cell of the map is unknown");
  return cells;
}

}  // namespace

OccupancyMap::OccupancyMap(int width, int height, double resolution, const Pose2& origin,
                           std::vector<Cell> cells)
    : width_(width),
      height_(height),
      resolution_(resolution),
      origin_(origin),
      cells_(std::move(cells)) {
  const bool right_size = width >= 1 && height >= 1 && width <= kMaxImageSide &&
                          height <= kMaxImageSide &&
                          cells_.size() == static_cast<std::size_t>(width) * height;
  if (!right_size || !(resolution > 0) || !std::isfinite(resolution)) {
    throw Error(ExitCode::kInput, "a map needs width * height cells of positive size");
  }
  prepare();
}

void OccupancyMap::prepare() {
  cells_per_metre_ = 1.0 / resolution_;
  cosine_ = std::cos(origin_.theta);
  sine_ = std::sin(origin_.theta);
  std::vector<bool> marked(cells_.size());
  next_.resize(cells_.size());
  previous_.resize(cells_.size());
  for (int row = 0; row < height_; ++row) {
    int last = -1;
    for (int column = 0; column < width_; ++column) {
      const std::size_t i = index(column, row);
      marked[i] = cells_[i] == Cell::kOccupied;
      occupied_count_ += marked[i];
      if (marked[i]) last = column;
      previous_[i] = last;
    }
    last = width_;
    for (int column = width_ - 1; column >= 0; --column) {
      const std::size_t i = index(column, row);
      if (marked[i]) last = column;
      next_[i] = last;
    }
  }
  squared_ = squaredDistances(marked, width_, height_);
}

OccupancyMap OccupancyMap::read(const std::string& yaml_path, Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.errorCount();
  const MapYaml yaml = parseMapYaml(readFile(yaml_path), yaml_path, diagnostics);
  if (diagnostics.errorCount() > errors) return {};
  const std::filesystem::path beside = std::filesystem::path(yaml_path).parent_path();
  const std::string image_path = (beside / yaml.image).string();
  GreyImage image;
  try {
    image = readGreyImage(image_path, diagnostics);
  } catch (const Error& error) {
    diagnostics.error({yaml_path, yaml.image_line, 0},
                      "the image cannot be read: " + error.formatted());
  }
  if (diagnostics.errorCount() > errors) return {};
  return OccupancyMap(image.width, image.height, yaml.resolution, yaml.origin,
                      toCells(image, yaml, yaml_path, diagnostics));
}

Cell OccupancyMap::cellAt(double x, double y) const {
  const Eigen::Vector2d p = toGrid(x, y);
  // Comparison before the cast: far points and NaN must not overflow an int.
  if (!(p.x() >= 0 && p.x() < width_ && p.y() >= 0 && p.y() < height_)) return Cell::kFree;
  return cell(static_cast<int>(p.x()), static_cast<int>(p.y()));
}

bool OccupancyMap::inside(double x, double y) const {
  const Eigen::Vector2d p = toGrid(x, y);
  return p.x() >= 0 && p.x() < width_ && p.y() >= 0 && p.y() < height_;
}

Eigen::Vector2d OccupancyMap::cellCenter(int column, int row) const {
  return origin_ * Eigen::Vector2d((column + 0.5) * resolution_, (row + 0.5) * resolution_);
}

double OccupancyMap::squaredClearanceInRow(const Eigen::Vector2d& p, int column, int row) const {
  const double up = std::max({row - p.y(), p.y() - (row + 1), 0.0});
  double along = kInfinity;
  const std::size_t i = index(column, row);
  if (next_[i] < width_) along = std::max(0.0, next_[i] - p.x());
  if (previous_[i] >= 0) along = std::min(along, std::max(0.0, p.x() - (previous_[i] + 1)));
  // Left of the map the column is clamped; its own cell may then lie apart.
  if (next_[i] == column) along = std::max({column - p.x(), p.x() - (column + 1), 0.0});
  return square(up) + square(along);
}

double OccupancyMap::clearance(double x, double y) const {
  if (occupied_count_ == 0) return kInfinity;
  const Eigen::Vector2d p = toGrid(x, y);
  const int column = static_cast<int>(std::clamp(p.x(), 0.0, width_ - 1.0));
  const int start = static_cast<int>(std::clamp(p.y(), 0.0, height_ - 1.0));
  double best = squaredClearanceInRow(p, column, start);
  // Rows further away cannot be nearer than their own distance.
  for (int row = start + 1; row < height_; ++row) {
    if (square(std::max(0.0, row - p.y())) >= best) break;
    best = std::min(best, squaredClearanceInRow(p, column, row));
  }
  for (int row = start - 1; row >= 0; --row) {
    if (square(std::max(0.0, p.y() - (row + 1))) >= best) break;
    best = std::min(best, squaredClearanceInRow(p, column, row));
  }
  return std::sqrt(best) * resolution_;
}

OccupancyMap::Bounds OccupancyMap::clearanceBounds(double x, double y) const {
  if (occupied_count_ == 0) return {kInfinity, kInfinity};
  const Eigen::Vector2d p = toGrid(x, y);
  // The nearest point of the grid's rectangle is not farther from any cell
  // than p is, so its lower bound serves p.
  const Eigen::Vector2d q(std::clamp(p.x(), 0.0, static_cast<double>(width_)),
                          std::clamp(p.y(), 0.0, static_cast<double>(height_)));
  const int column = std::min(static_cast<int>(q.x()), width_ - 1);
  const int row = std::min(static_cast<int>(q.y()), height_ - 1);
  const double distance = std::sqrt(static_cast<double>(squared_[index(column, row)]));
  const double off = std::hypot(q.x() - (column + 0.5), q.y() - (row + 0.5));
  const double apart = std::hypot(p.x() - q.x(), p.y() - q.y());
  // A square holds the disc of radius 1/2 and lies in that of radius
  // sqrt(1/2) about its centre.
  const double low = std::max(0.0, distance - off - kHalfDiagonal);
  const double high = std::max(0.0, distance + off - 0.5) + apart;
  return {low * resolution_, high * resolution_};
}

std::string OccupancyMap::formatYaml(const std::string& image) const {
  return "image: " + image + "\nresolution: " + formatDouble(resolution_) + "\norigin: [" +
         formatDouble(origin_.x) + ", " + formatDouble(origin_.y) + ", " +
         formatDouble(origin_.theta) + "]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
}

std::string OccupancyMap::formatPgm() const {
  std::string out = "P5\n" + std::to_string(width_) + ' ' + std::to_string(height_) + "\n255\n";
  out.reserve(out.size() + cells_.size());
  constexpr unsigned char kGrey[] = {254, 0, 205};
  for (int row = height_ - 1; row >= 0; --row) {
    for (int column = 0; column < width_; ++column) {
      out += static_cast<char>(kGrey[static_cast<int>(cell(column, row))]);
    }
  }
  return out;
}

}  // namespace graft::lfd
