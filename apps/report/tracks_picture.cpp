// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/axes.hpp"
#include "apps/report/pictures.hpp"

namespace graft::report {

namespace {

constexpr double kWidth = 960;
constexpr double kPanel = 170;
constexpr double kLeft = 64;
constexpr double kTop = 34;

/// Input poses (dots where measured) and estimates (a line) of one thing.
struct Curve {
  const std::vector<Pose>* input;  ///< null if there is none
  const std::vector<char>* measured;
  const std::vector<Pose>* estimate;
  const char* stroke;
};

void drawPanel(Svg& svg, const lfd::DemonstrationEstimate& demo, const std::vector<Curve>& curves,
               int axis, double top, bool last) {
  const double start = demo.times.front();
  Range values;
  for (const Curve& curve : curves) {
    for (const auto* poses : {curve.input, curve.estimate}) {
      if (poses == nullptr) continue;
      for (const Pose& pose : *poses) values.include(pose.translation[axis]);
    }
  }
  const Axes axes({kLeft, top, kWidth - kLeft - 20, kPanel}, {0, demo.times.back() - start},
                  values.padded(0.06, 0.05));
  const auto x = [&](std::size_t i) { return axes.at(demo.times[i] - start, values.low).x; };
  const std::size_t end = demo.size() - 1;
  const double grasp = x(std::min(demo.segments.grasp, end));
  const double release = x(std::min(demo.segments.release, end));
  svg.rect({grasp, top}, release - grasp, kPanel, "f-manipulation soft");
  const std::string name(1, "xyz"[axis]);
  axes.draw(svg, last ? "time since the demonstration began, s" : "", name + ", m", 10, 4);
  for (const Curve& curve : curves) {
    if (curve.input == nullptr) continue;
    PathData dots;
    for (std::size_t i = 0; i < curve.input->size() && i < demo.size(); ++i) {
      if (!(*curve.measured)[i]) continue;
      dots.dot(axes.at(demo.times[i] - start, (*curve.input)[i].translation[axis]));
    }
    svg.path(dots, std::string(curve.stroke) + " w3 soft");
  }
  for (const Curve& curve : curves) {
    std::vector<Point> points;
    for (std::size_t i = 0; i < curve.estimate->size() && i < demo.size(); ++i) {
      points.push_back(axes.at(demo.times[i] - start, (*curve.estimate)[i].translation[axis]));
    }
    PathData line;
    line.polyline(points);
    svg.path(line, std::string(curve.stroke) + " w2");
  }
}

}  // namespace

Picture tracksPicture(const lfd::LearnResult& result) {
  const std::string title = "One demonstration over time";
  if (result.after.empty() || result.after.front().size() < 2) {
    return {"tracks", title, "There is no demonstration to show.", Svg(kWidth, 40)};
  }
  const lfd::DemonstrationEstimate& demo = result.after.front();
  std::vector<Curve> curves{{nullptr, nullptr, &demo.gripper, "s-gripper"}};
  if (!result.task.demonstrations.empty()) {
    const lfd::MatchedDemonstration& input = result.task.demonstrations.front().matched;
    curves.push_back({&input.object.poses, &input.object.measured, &demo.object, "s-object"});
    curves.push_back({&input.hand.poses, &input.hand.measured, &demo.hand, "s-hand"});
  }
  Svg svg(kWidth, kTop + 3 * (kPanel + 26) + 30);
  drawLegend(&svg, {kLeft, 2}, kWidth - kLeft,
             {{Mark::kDot, "s-hand w5 soft", "measured (hand, object)"},
              {Mark::kLine, "s-hand w2", "hand"},
              {Mark::kLine, "s-object w2", "object"},
              {Mark::kLine, "s-gripper w2", "gripper"},
              {Mark::kBox, "f-manipulation", "manipulation"}});
  for (int axis = 0; axis < 3; ++axis) {
    drawPanel(svg, demo, curves, axis, kTop + axis * (kPanel + 26), axis == 2);
  }
  return {"tracks", title,
          "Positions in " + demo.name +
              ": lines are the optimized hand, object and gripper, dots what the trackers "
              "measured. Lines should run through the dots without their jitter, and while the "
              "object is manipulated hand and gripper should keep a constant distance to it.",
          svg};
}

}  // namespace graft::report
