// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/axes.hpp"
#include "apps/report/pictures.hpp"
#include "apps/report/table_rows.hpp"

namespace graft::report {

namespace {

constexpr double kWidth = 960;
constexpr double kLabels = 250;  ///< pixels left for the names of rows
constexpr double kRow = 40;
constexpr double kBar = 12;
constexpr double kValues = 70;  ///< pixels right for numbers beside bars

void drawPaper(Svg& svg, const Axes& axes, const std::optional<double>& value, double middle) {
  if (!value.has_value()) return;
  drawMark(svg, {axes.at(*value, 0).x, middle}, Mark::kDiamond, "s-ink w1 f-paper");
}

void drawBar(Svg& svg, const Axes& axes, const std::optional<double>& value, Unit unit, double y,
             const char* classes) {
  const double zero = axes.box().x;
  if (!value.has_value()) {
    svg.text({zero + 4, y + kBar - 2.5}, "undefined", "small muted");
    return;
  }
  const double end = axes.at(*value, 0).x;
  svg.rect({zero, y}, std::max(1.0, end - zero), kBar, classes, 1.5);
  svg.text({axes.box().x + axes.box().width + 10, y + kBar - 2}, formatValue(value, unit), "small");
}

/// Rows of one unit below `top`; returns where the panel ends.
double drawPanel(Svg& svg, const std::vector<TableRow>& rows, Unit unit, double top) {
  std::vector<const TableRow*> chosen;
  Range range(0, unit == Unit::kPercent ? 100 : 1e-6);
  for (const TableRow& row : rows) {
    if (row.unit != unit) continue;
    chosen.push_back(&row);
    for (const auto& value : {row.before, row.after, row.paper_before, row.paper_after}) {
      if (value.has_value()) range.include(*value);
    }
  }
  if (unit != Unit::kPercent) range.high *= 1.04;
  const double height = kRow * double(chosen.size());
  const Axes axes({kLabels, top, kWidth - kLabels - kValues - 20, height}, range, {0, 1});
  axes.draw(svg, unitName(unit), "", 8, 0);
  double y = top;
  for (const TableRow* row : chosen) {
    svg.text({kLabels - 12, y + kRow / 2 + 4}, row->label, "label", Anchor::kEnd);
    const double first = y + kRow / 2 - kBar - 1;
    drawBar(svg, axes, row->before, unit, first, "f-before");
    drawBar(svg, axes, row->after, unit, first + kBar + 2, "f-after");
    drawPaper(svg, axes, row->paper_before, first + kBar / 2);
    drawPaper(svg, axes, row->paper_after, first + 1.5 * kBar + 2);
    y += kRow;
  }
  return top + height + 52;
}

}  // namespace

Picture tablePicture(const lfd::LearnResult& result) {
  const std::string& task = result.task.task.name;
  const std::vector<TableRow> rows = tableRows(task, result.table_before, result.table_after);
  const bool paper = isTaskOfPaper(task);
  Svg svg(kWidth, 30 + kRow * double(rows.size()) + 3 * 52);
  std::vector<LegendEntry> legend{{Mark::kBox, "f-before", "before"},
                                  {Mark::kBox, "f-after", "after optimization"}};
  if (paper) legend.push_back({Mark::kDiamond, "s-ink w1 f-paper", "the paper's figure"});
  drawLegend(&svg, {kLabels, 4}, kWidth - kLabels, legend);
  double y = 34;
  for (const Unit unit : {Unit::kCentimetre, Unit::kDegree, Unit::kPercent}) {
    y = drawPanel(svg, rows, unit, y);
  }
  std::string caption =
      "Distances, angles and spreads should shrink (all but gripper to hand, which grows by what "
      "the grasp needs); shares should come close to 100 %.";
  if (paper)
    caption += " Diamonds mark what the paper reports for its own recordings of this task.";
  return {"table1", "Table I before and after optimization", caption, svg};
}

}  // namespace graft::report
