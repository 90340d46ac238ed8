// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "apps/report/axes.hpp"
#include "apps/report/pictures.hpp"

namespace graft::report {

namespace {

constexpr double kWidth = 960;
constexpr double kTop = 34;
constexpr double kRow = 22;

struct EdgeTitle {
  const char* tag;
  const char* name;
};

constexpr EdgeTitle kEdgeTitles[] = {
    {"LFD_OBSERVATION", "E1 observation"},
    {"LFD_RELATIVE_MOTION", "E2 relative motion"},
    {"LFD_STEADY_MOTION", "steady motion (prior)"},
    {"LFD_GRIPPER_SMOOTH", "E3 gripper smoothness"},
    {"LFD_BASE_SMOOTH", "E3 base smoothness"},
    {"LFD_HUMAN_GRASP", "E4 human grasp"},
    {"LFD_ROBOT_GRASP", "E5 robot grasp"},
    {"LFD_GRASP_QUALITY", "E6 grasp quality"},
    {"LFD_HAND_GRIPPER", "E7 hand to gripper"},
    {"LFD_RESEMBLANCE", "E8 resemblance"},
    {"LFD_REACHABILITY", "E9 reachability"},
    {"LFD_GRASP_AGREEMENT", "E10 grasp agreement"},
    {"LFD_BASE_PRIOR", "base position (prior)"},
    {"LFD_HUMAN_GRASP_TURNED", "E4 human grasp, hand turned"},
    {"LFD_RESEMBLANCE_TURNED", "E8 resemblance, hand turned"},
};

void drawIterations(Svg& svg, const Summary& summary, double height) {
  Range steps(0, 1);
  Range chi2;
  for (const IterationRecord& record : summary.iterations) {
    steps.include(record.iteration);
    if (record.chi2 > 0) chi2.include(record.chi2);
  }
  svg.text({60, 18}, "\u03C7\u00B2 after each iteration (log scale)", "title");
  if (chi2.empty()) {
    svg.text({60, kTop + 20}, "no iterations were recorded", "muted");
    return;
  }
  const double factor = std::max(1.1, std::pow(chi2.high / chi2.low, 0.06));
  const Axes axes({60, kTop, 380, height}, steps.padded(0.02, 1),
                  {chi2.low / factor, chi2.high * factor}, true);
  // No ticks between two iterations.
  const int ticks = std::clamp(int(steps.size()), 1, 6);
  axes.draw(svg, "iteration", "", ticks);
  PathData line;
  PathData accepted;
  PathData refused;
  for (const IterationRecord& record : summary.iterations) {
    if (!(record.chi2 > 0)) continue;
    const Point p = axes.at(record.iteration, record.chi2);
    line.lineTo(p);
    if (record.accepted) {
      accepted.dot(p);
    } else {
      refused.cross(p, 4);
    }
  }
  svg.path(line, "s-after w1 soft");
  svg.path(accepted, "s-after w5");
  svg.path(refused, "s-bad w2");
  std::vector<LegendEntry> legend{{Mark::kDot, "s-after w5", "accepted step"}};
  if (!refused.empty()) legend.push_back({Mark::kCross, "s-bad w2", "refused step"});
  drawLegend(&svg, {60, kTop + height + 40}, 380, legend);
}

void drawEdges(Svg& svg, const std::vector<std::pair<std::string, double>>& edges) {
  constexpr double kLeft = 660;
  constexpr double kBars = 200;
  svg.text({500, 18}, "\u03C7\u00B2 that remains, by type of edge", "title");
  const double largest = edges.empty() ? 1 : std::max(1e-300, edges.front().second);
  double y = kTop;
  for (const auto& [name, chi2] : edges) {
    svg.text({kLeft - 10, y + 14}, name, "label", Anchor::kEnd);
    svg.rect({kLeft, y + 4}, std::max(1.0, kBars * chi2 / largest), 13, "f-after", 1.5);
    const double end = kLeft + kBars * chi2 / largest;
    svg.text({end + 7, y + 14.5}, roughNumber(chi2), "small");
    y += kRow;
  }
}

}  // namespace

std::string edgeName(const std::string& tag) {
  for (const EdgeTitle& title : kEdgeTitles) {
    if (tag == title.tag) return title.name;
  }
  return tag;
}

Picture convergencePicture(const Summary& summary) {
  std::vector<std::pair<std::string, double>> edges;
  for (const auto& [tag, chi2] : summary.chi2_by_tag) edges.push_back({edgeName(tag), chi2});
  std::stable_sort(edges.begin(), edges.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  const double height = std::max(220.0, kRow * double(edges.size()) - 20);
  Svg svg(kWidth, kTop + height + 70);
  drawIterations(svg, summary, height);
  drawEdges(svg, edges);
  const auto refused =
      std::count_if(summary.iterations.begin(), summary.iterations.end(),
                    [](const IterationRecord& record) { return !record.accepted; });
  std::string caption = "The sum of weighted squared errors should fall steeply, then level off. ";
  caption += refused == 0 ? "No step was refused."
                          : std::to_string(refused) + " refused step" + (refused == 1 ? "" : "s") +
                                " (crosses) left the estimates as they were.";
  if (!edges.empty()) {
    caption += " What remains at the end is mostly " + edges.front().first + ".";
  }
  return {"convergence", "Convergence", caption, svg};
}

}  // namespace graft::report
