// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/axes.hpp"

#include <algorithm>
#include <cmath>

namespace graft::report {

namespace {

constexpr double kLegendLine = 20;
constexpr double kCharacter = 6.1;  ///< about the width of one at 12 pixels

/// Powers of ten beyond four digits by their exponent.
std::string powerLabel(double value) {
  if (value >= 1e-3 && value < 1e4) return shortNumber(value, 9);
  const int power = int(std::floor(std::log10(value) + 1e-9));
  return shortNumber(value / std::pow(10.0, power)) + "e" + std::to_string(power);
}

}  // namespace

void Range::include(double value) {
  if (!std::isfinite(value)) return;
  if (empty()) {
    low = high = value;
  } else {
    low = std::min(low, value);
    high = std::max(high, value);
  }
}

Range Range::padded(double share, double least) const {
  if (empty()) return {-0.5 * least, 0.5 * least};
  const double grow = std::max(share * size(), 0.5 * (least - size()));
  return grow > 0 ? Range(low - grow, high + grow) : *this;
}

std::vector<double> niceTicks(const Range& range, int wanted) {
  std::vector<double> ticks;
  if (range.empty() || !(range.size() > 0) || wanted < 1) return ticks;
  const double rough = range.size() / wanted;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double share = rough / power;
  const double step = power * (share <= 1.5 ? 1 : share <= 3.5 ? 2 : share <= 7.5 ? 5 : 10);
  const double slack = 1e-9 * range.size();
  const double first = std::ceil((range.low - slack) / step);
  for (double k = first; k * step <= range.high + slack; ++k) ticks.push_back(k * step);
  return ticks;
}

std::vector<double> logTicks(const Range& range) {
  const int first = int(std::floor(std::log10(range.low)));
  const int last = int(std::ceil(std::log10(range.high)));
  const bool few = last - first <= 2;
  std::vector<double> ticks;
  for (int e = first; e <= last; ++e) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double tick = digit * std::pow(10.0, e);
      if ((digit > 1 && !few) || tick < range.low || tick > range.high) continue;
      ticks.push_back(tick);
    }
  }
  if (ticks.size() < 3) return niceTicks(range, 4);
  // More than eight powers: every second, third, ...
  std::vector<double> some;
  const std::size_t stride = 1 + ticks.size() / 9;
  for (std::size_t i = 0; i < ticks.size(); i += stride) some.push_back(ticks[i]);
  return some;
}

std::vector<std::string> tickLabels(const std::vector<double>& ticks) {
  double smallest = 0;
  for (std::size_t i = 1; i < ticks.size(); ++i) {
    const double step = std::abs(ticks[i] - ticks[i - 1]);
    smallest = i == 1 ? step : std::min(smallest, step);
  }
  const int decimals = smallest > 0 ? std::max(0, int(std::ceil(-std::log10(smallest) - 1e-9))) : 2;
  std::vector<std::string> labels;
  labels.reserve(ticks.size());
  for (const double tick : ticks) {
    labels.push_back(fixedNumber(tick, std::min(decimals, 12)));
  }
  return labels;
}

Axes::Axes(const Box& box, const Range& x, const Range& y, bool log_y)
    : box_(box), x_(x), y_(y), log_y_(log_y) {}

Axes Axes::equal(const Box& box, const Range& x, const Range& y) {
  const double metre = std::min(box.width / x.size(), box.height / y.size());
  return Axes(box, x.padded(0, box.width / metre), y.padded(0, box.height / metre));
}

Point Axes::at(double x, double y) const {
  const double u = (x - x_.low) / x_.size();
  const double v =
      log_y_ ? std::log(y / y_.low) / std::log(y_.high / y_.low) : (y - y_.low) / y_.size();
  return {box_.x + u * box_.width, box_.y + (1 - v) * box_.height};
}

void Axes::draw(Svg& svg, const std::string& x_name, const std::string& y_name, int x_ticks,
                int y_ticks) const {
  const std::vector<double> columns = niceTicks(x_, x_ticks);
  const std::vector<std::string> column_labels = tickLabels(columns);
  const double bottom = box_.y + box_.height;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double x = at(columns[i], y_.low).x;
    svg.line({x, box_.y}, {x, bottom}, "s-grid w1 crisp");
    svg.text({x, bottom + 16}, column_labels[i], "small muted", Anchor::kMiddle);
  }
  const std::vector<double> rows = log_y_ ? logTicks(y_) : niceTicks(y_, y_ticks);
  std::vector<std::string> row_labels = tickLabels(rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (log_y_) row_labels[i] = powerLabel(rows[i]);
    const double y = at(x_.low, rows[i]).y;
    svg.line({box_.x, y}, {box_.x + box_.width, y}, "s-grid w1 crisp");
    svg.text({box_.x - 7, y + 3.5}, row_labels[i], "small muted", Anchor::kEnd);
  }
  if (!x_name.empty()) {
    svg.text({box_.x + box_.width / 2, bottom + 32}, x_name, "small muted", Anchor::kMiddle);
  }
  if (!y_name.empty()) {
    svg.text({box_.x - 42, box_.y + box_.height / 2}, y_name, "small muted", Anchor::kMiddle, true);
  }
}

void drawMark(Svg& svg, Point at, Mark mark, const std::string& classes) {
  PathData data;
  switch (mark) {
    case Mark::kDot:
      data.dot(at);
      break;
    case Mark::kRing:
      svg.circle(at, 5, classes);
      return;
    case Mark::kCross:
      data.cross(at, 3);
      break;
    case Mark::kLine:
      data.polyline({{at.x - 8, at.y}, {at.x + 8, at.y}});
      break;
    case Mark::kBox:
    case Mark::kOutline:
      data.box({at.x - 6, at.y - 5}, 12, 10);
      break;
    case Mark::kDiamond:
      data.polyline({{at.x, at.y - 5}, {at.x + 5, at.y}, {at.x, at.y + 5}, {at.x - 5, at.y}}, true);
      break;
  }
  svg.path(data, classes);
}

double drawLegend(Svg* svg, Point corner, double width, const std::vector<LegendEntry>& entries) {
  double x = 0;
  double y = 0.5 * kLegendLine;
  for (const LegendEntry& entry : entries) {
    const double needed = 24 + kCharacter * double(entry.text.size()) + 16;
    if (x > 0 && x + needed - 16 > width) {
      x = 0;
      y += kLegendLine;
    }
    if (svg != nullptr) {
      drawMark(*svg, {corner.x + x + 9, corner.y + y}, entry.mark, entry.classes);
      svg->text({corner.x + x + 23, corner.y + y + 4}, entry.text, "label");
    }
    x += needed;
  }
  return entries.empty() ? 0 : y + 0.5 * kLegendLine;
}

}  // namespace graft::report
