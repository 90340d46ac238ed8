// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace graft::report {

/// A point of a picture in pixels, y downwards.
struct Point {
  double x = 0;
  double y = 0;
};

/// Text as XML and HTML content or attribute: markup characters become
/// entities, control characters and broken UTF-8 the replacement character.
std::string escapeXml(std::string_view text);

/// A number with at most / exactly so many decimals, independent of the locale.
/// Numbers that are not finite become "-".
std::string shortNumber(double value, int decimals = 2);
std::string fixedNumber(double value, int decimals);
/// A number with three significant digits: 12,801; 84.3; 0.0312; 4.1e-07.
std::string roughNumber(double value);
/// An integer in groups of three: 12,345.
std::string groupedNumber(std::size_t value);

/// The `d` of a path. Points that are not finite are left out and break the line.
class PathData {
 public:
  void moveTo(Point p);
  void lineTo(Point p);
  void curveTo(Point control, Point end);
  void close();
  /// A line of length 0: with a round cap, a dot as wide as the stroke.
  void dot(Point p);
  void cross(Point p, double half);
  void polyline(const std::vector<Point>& points, bool closed = false);
  void box(Point corner, double width, double height);

  bool empty() const { return text_.empty(); }
  const std::string& text() const { return text_; }

 private:
  void append(char command, Point p);

  std::string text_;
  bool broken_ = true;  ///< the next point starts a new line
};

enum class Anchor { kStart, kMiddle, kEnd };

/// A picture under construction. How things look is said by classes of
/// pictureStyle(): f-ROLE fills and s-ROLE strokes with a role's colour, w1 w2 w3
/// w5 w6 are widths of strokes, soft and faint are opacities, dash is a pattern;
/// texts are label, small, title, muted.
class Svg {
 public:
  Svg(double width, double height) : width_(width), height_(height) {}

  void line(Point a, Point b, std::string_view classes);
  void path(const PathData& data, std::string_view classes);
  void circle(Point center, double radius, std::string_view classes);
  void rect(Point corner, double width, double height, std::string_view classes,
            double corner_radius = 0);
  /// `turned` writes upwards.
  void text(Point at, std::string_view text, std::string_view classes,
            Anchor anchor = Anchor::kStart, bool turned = false);
  /// All that is drawn until endClip() is cut to the box.
  void beginClip(Point corner, double width, double height);
  void endClip();

  double width() const { return width_; }
  double height() const { return height_; }

  /// A file of its own, with the style inside.
  std::string standalone(const std::string& title) const;
  /// For an HTML page that holds pictureStyle().
  std::string inlined(const std::string& title) const;

 private:
  void open(const char* element);
  void attribute(const char* name, double value);
  void attribute(const char* name, std::string_view value);
  std::string head(const std::string& title, bool alone) const;

  double width_;
  double height_;
  std::string body_;
};

/// Style sheet of all pictures, for light and dark screens and for paper.
const std::string& pictureStyle();

}  // namespace graft::report
