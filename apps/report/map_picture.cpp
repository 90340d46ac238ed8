// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "apps/report/axes.hpp"
#include "apps/report/pictures.hpp"

namespace graft::report {

namespace {

using Estimates = std::vector<lfd::DemonstrationEstimate>;

constexpr double kMargin = 0.7;  ///< m around all bases and grippers
constexpr double kWidth = 480;
constexpr double kLongest = 560;  ///< pixels of a panel's height at most

/// What the pictures of one result share.
struct Section {
  Range x;
  Range y;
  Box box;
};

Section sectionOf(const std::vector<const Estimates*>& all) {
  Section section;
  for (const Estimates* estimates : all) {
    for (const lfd::DemonstrationEstimate& demo : *estimates) {
      for (const Pose2& base : demo.base) {
        section.x.include(base.x);
        section.y.include(base.y);
      }
      for (const Pose& gripper : demo.gripper) {
        section.x.include(gripper.translation[0]);
        section.y.include(gripper.translation[1]);
      }
    }
  }
  section.x = section.x.padded(0, section.x.empty() ? 2 : section.x.size() + 2 * kMargin);
  section.y = section.y.padded(0, section.y.empty() ? 2 : section.y.size() + 2 * kMargin);
  const double width = kWidth - 62;
  const double height =
      std::clamp(width * section.y.size() / section.x.size(), 0.5 * width, kLongest);
  section.box = {52, 34, width, height};
  return section;
}

/// Cells of one kind as boxes, each run along a row as one.
PathData cellRuns(const lfd::OccupancyMap& map, const Axes& axes, lfd::Cell kind) {
  // A map may be huge; the section is small: rows and columns around it only.
  Range columns;
  Range rows;
  for (const double x : {axes.x().low, axes.x().high}) {
    for (const double y : {axes.y().low, axes.y().high}) {
      const auto cell = map.toGrid(x, y);
      columns.include(cell.x());
      rows.include(cell.y());
    }
  }
  const auto clamped = [](double v, int high) {
    return int(std::clamp(std::floor(v), 0.0, double(high)));
  };
  const int first_column = clamped(columns.low, map.width());
  const int end_column = clamped(columns.high + 1, map.width());
  const double size = map.resolution();
  PathData path;
  const auto corner = [&](int column, int row) {
    const Vec<double, 2> p =
        map.origin() * Vec<double, 2>(double(column) * size, double(row) * size);
    return axes.at(p[0], p[1]);
  };
  for (int row = clamped(rows.low, map.height()); row < clamped(rows.high + 1, map.height());
       ++row) {
    for (int column = first_column; column < end_column; ++column) {
      if (map.cell(column, row) != kind) continue;
      const int begin = column;
      while (column < end_column && map.cell(column, row) == kind) ++column;
      path.polyline({corner(begin, row), corner(column, row), corner(column, row + 1),
                     corner(begin, row + 1)},
                    true);
    }
  }
  return path;
}

struct Counts {
  std::size_t tuples = 0;
  std::size_t unreachable = 0;
  std::size_t colliding = 0;
};

class Drawer {
 public:
  Drawer(const lfd::TaskScene& scene, const Axes& axes, Svg& svg)
      : scene_(scene), axes_(axes), svg_(svg) {}

  void drawMap() const {
    if (scene_.map == nullptr) return;
    svg_.path(cellRuns(*scene_.map, axes_, lfd::Cell::kUnknown), "f-unknown crisp");
    svg_.path(cellRuns(*scene_.map, axes_, lfd::Cell::kOccupied), "f-wall crisp");
  }

  Counts drawRobot(const Estimates& estimates) const {
    Counts counts;
    PathData footprints;
    PathData good;
    PathData bad;
    PathData grippers;
    for (const lfd::DemonstrationEstimate& demo : estimates) {
      std::vector<Point> path;
      for (std::size_t i = 0; i < demo.size(); ++i) {
        const Pose2& base = demo.base[i];
        const Point at = axes_.at(base.x, base.y);
        ++counts.tuples;
        path.push_back(axes_.at(demo.gripper[i].translation[0], demo.gripper[i].translation[1]));
        // What is not finite is neither reachable nor somewhere.
        if (!std::isfinite(at.x + at.y + path.back().x + path.back().y)) {
          ++counts.unreachable;
          continue;
        }
        if (scene_.reach != nullptr && !scene_.reach->contains(demo.gripper[i], base)) {
          bad.cross(at, 1.8);
          ++counts.unreachable;
        } else {
          good.dot(at);
        }
        if (scene_.footprint != nullptr && scene_.footprint->inCollision(base)) {
          addFootprint(base, footprints);
          ++counts.colliding;
        }
      }
      grippers.polyline(path);
    }
    svg_.path(footprints, "s-bad w1 faint");
    svg_.path(grippers, "s-gripper w1");
    svg_.path(good, "s-base w3");
    svg_.path(bad, "s-bad w1");
    return counts;
  }

 private:
  void addFootprint(const Pose2& base, PathData& path) const {
    std::vector<Point> corners;
    for (const auto& corner : scene_.footprint->polygon()) {
      const Vec<double, 2> p = base * Vec<double, 2>(corner.x(), corner.y());
      corners.push_back(axes_.at(p[0], p[1]));
    }
    path.polyline(corners, true);
  }

  const lfd::TaskScene& scene_;
  const Axes& axes_;
  Svg& svg_;
};

std::vector<LegendEntry> legendOf(const lfd::TaskScene& scene) {
  std::vector<LegendEntry> legend{
      {Mark::kDot, "s-base w5", scene.reach != nullptr ? "base, in reach" : "base"}};
  if (scene.reach != nullptr) {
    legend.push_back({Mark::kCross, "s-bad w1", "base, out of reach"});
  }
  legend.push_back({Mark::kLine, "s-gripper w1", "gripper"});
  if (scene.footprint != nullptr) {
    legend.push_back({Mark::kOutline, "s-bad w1", "footprint in collision"});
  }
  if (scene.map != nullptr) legend.push_back({Mark::kBox, "f-wall", "occupied"});
  return legend;
}

std::string percent(std::size_t part, std::size_t all) {
  return fixedNumber(100.0 * double(part) / double(std::max<std::size_t>(1, all)), 1) + " %";
}

Picture mapPicture(const lfd::LearnResult& result, const Estimates& estimates,
                   const Section& section, const std::string& name, const std::string& title) {
  const std::vector<LegendEntry> legend = legendOf(result.scene);
  const double legend_height = drawLegend(nullptr, {}, kWidth - 20, legend);
  const Box& box = section.box;
  const double below = box.y + box.height + 42;
  Svg svg(kWidth, below + legend_height + 4);
  const Axes axes = Axes::equal(box, section.x, section.y);
  svg.text({box.x, 18}, title, "title");
  axes.draw(svg, "x, m", "y, m");
  svg.beginClip({box.x, box.y}, box.width, box.height);
  const Drawer drawer(result.scene, axes, svg);
  drawer.drawMap();
  const Counts counts = drawer.drawRobot(estimates);
  svg.endClip();
  drawLegend(&svg, {10, below}, kWidth - 20, legend);
  std::string caption;
  if (result.scene.reach != nullptr) {
    caption += "Out of reach: " + percent(counts.unreachable, counts.tuples) + ". ";
  }
  if (result.scene.footprint != nullptr) {
    caption += "In collision: " + percent(counts.colliding, counts.tuples) + ".";
  }
  return {name, title, caption, svg};
}

}  // namespace

std::vector<Picture> mapPictures(const lfd::LearnResult& result) {
  std::vector<const Estimates*> all;
  for (const auto& [iteration, estimates] : result.snapshots) all.push_back(&estimates);
  if (all.empty()) all = {&result.before, &result.after};
  const Section section = sectionOf(all);
  std::vector<Picture> pictures;
  if (result.snapshots.empty()) {
    pictures.push_back(mapPicture(result, result.before, section, "map_before", "Before"));
    pictures.push_back(mapPicture(result, result.after, section, "map_after", "After"));
    return pictures;
  }
  for (const auto& [iteration, estimates] : result.snapshots) {
    const std::string n = std::to_string(iteration);
    pictures.push_back(
        mapPicture(result, estimates, section, "map_iteration_" + n, "Iteration " + n));
  }
  return pictures;
}

}  // namespace graft::report
