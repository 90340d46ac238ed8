// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "apps/report/svg.hpp"

namespace graft::report {

/// An interval of data; empty until something is included.
struct Range {
  double low = 1;
  double high = -1;

  Range() = default;
  Range(double low_, double high_) : low(low_), high(high_) {}
  bool empty() const { return low > high; }
  double size() const { return high - low; }
  /// Numbers that are not finite are ignored.
  void include(double value);
  /// Wider by `share` of its size on both sides, and at least `least` wide.
  Range padded(double share, double least) const;
};

/// Multiples of 1, 2 or 5 times a power of ten within the range, about `wanted`.
std::vector<double> niceTicks(const Range& range, int wanted);
/// Powers of ten (and 2, 5 times them, where there are few) within the range.
std::vector<double> logTicks(const Range& range);
/// Labels with as many decimals as the ticks need to differ.
std::vector<std::string> tickLabels(const std::vector<double>& ticks);

/// A box of a picture in pixels.
struct Box {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;
};

/// A coordinate system in a box of a picture, y upwards.
class Axes {
 public:
  Axes(const Box& box, const Range& x, const Range& y, bool log_y = false);
  /// One metre is as long in x as in y; ranges grow where the box has room.
  static Axes equal(const Box& box, const Range& x, const Range& y);

  Point at(double x, double y) const;
  const Box& box() const { return box_; }
  const Range& x() const { return x_; }
  const Range& y() const { return y_; }

  /// Grid lines, tick labels and names of the axes.
  void draw(Svg& svg, const std::string& x_name, const std::string& y_name, int x_ticks = 6,
            int y_ticks = 5) const;

 private:
  Box box_;
  Range x_;
  Range y_;
  bool log_y_;
};

/// How an entry of a legend is shown.
enum class Mark { kDot, kRing, kCross, kLine, kBox, kOutline, kDiamond };

struct LegendEntry {
  Mark mark;
  std::string classes;
  std::string text;
};

/// A mark of about 10 pixels around a point.
void drawMark(Svg& svg, Point at, Mark mark, const std::string& classes);

/// Entries from left to right, in lines no wider than `width`; returns the
/// height used (svg null: only measures).
double drawLegend(Svg* svg, Point corner, double width, const std::vector<LegendEntry>& entries);

}  // namespace graft::report
