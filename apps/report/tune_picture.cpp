// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "apps/report/axes.hpp"
#include "apps/report/pictures.hpp"

namespace graft::report {

namespace {

constexpr double kTop = 34;
constexpr double kWidth = 400;
constexpr double kHeight = 280;
constexpr double kCentimetres = 100;

/// One chart over the distance from gripper to grasp. `value` gives y.
template <class Value>
void drawChart(Svg& svg, double left, const std::vector<lfd::TuneTrial>& trials,
               const std::string& name, const Range& least, Value value) {
  Range x(0, 0.1);
  Range y = least;
  for (const lfd::TuneTrial& trial : trials) {
    x.include(kCentimetres * trial.table.gripper_grasp_m);
    y.include(value(trial));
  }
  const Axes axes({left, kTop, kWidth, kHeight}, x.padded(0.05, 0.1), y.padded(0.08, 0.2));
  axes.draw(svg, "gripper to grasp, cm", name);
  PathData others;
  PathData best;
  PathData given;
  for (const lfd::TuneTrial& trial : trials) {
    const Point p = axes.at(kCentimetres * trial.table.gripper_grasp_m, value(trial));
    (trial.best ? best : others).dot(p);
    if (trial.grasp_quality == 1 && trial.reachability == 1) {
      svg.circle(p, 8, "s-offset w2");
    }
  }
  svg.path(others, "s-muted w5 soft");
  svg.path(best, "s-after w6");
}

}  // namespace

Picture tunePicture(const std::vector<lfd::TuneTrial>& trials) {
  Svg svg(960, kTop + kHeight + 80);
  svg.text({60, 18}, "Like the person", "title");
  drawChart(svg, 60, trials, "gripper to hand, cm", Range(), [](const lfd::TuneTrial& trial) {
    return kCentimetres * trial.table.gripper_hand_m.value_or(0);
  });
  svg.text({540, 18}, "In the arm's reach", "title");
  drawChart(svg, 540, trials, "bases in reach, %", Range(),
            [](const lfd::TuneTrial& trial) { return 100 * trial.table.kinematically_achievable; });
  drawLegend(&svg, {60, kTop + kHeight + 46}, 840,
             {{Mark::kDot, "s-after w6", "no other is better in all three"},
              {Mark::kDot, "s-muted w5 soft", "others"},
              {Mark::kRing, "s-offset w2", "the task's weights"}});
  return {"tune", "Weights",
          "Each dot is one pair of weights of E6 and E9, optimized without the last step. Down and "
          "to the left (up, in the right chart) is better.",
          svg};
}

}  // namespace graft::report
