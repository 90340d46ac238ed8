// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>

#include "apps/report/axes.hpp"
#include "apps/report/pictures.hpp"

namespace graft::report {

namespace {

constexpr double kWidth = 960;
constexpr double kPanel = 410;
constexpr double kTop = 34;
constexpr double kNear = 0.35;      ///< m: grasps farther from the chosen one are not shown
constexpr double kApproach = 0.03;  ///< m, length of a grasp's approach direction

/// The two projections: x and y, x and z of the object's frame.
constexpr std::array<int, 2> kVertical{1, 2};

constexpr const char* kTitles[] = {"Seen along z of the object", "Seen along y of the object"};

std::string verticalName(int axis) { return std::string(1, "xyz"[axis]) + " of the object, m"; }

struct Dots {
  std::vector<Vec<double, 3>> points;
  const char* classes;
};

/// Positions of `which` seen from the object over the manipulation (or at the
/// grasp tuples only).
template <class Track>
std::vector<Vec<double, 3>> seenFromObject(const std::vector<lfd::DemonstrationEstimate>& demos,
                                           Track track, bool grasp_only) {
  std::vector<Vec<double, 3>> points;
  for (const lfd::DemonstrationEstimate& demo : demos) {
    if (demo.size() == 0) continue;
    const std::size_t last =
        std::min(grasp_only ? demo.segments.grasp : demo.segments.release, demo.size() - 1);
    for (std::size_t i = demo.segments.grasp; i <= last; ++i) {
      points.push_back((demo.object[i].inverse() * track(demo)[i]).translation);
    }
  }
  return points;
}

const std::vector<Pose>& handOf(const lfd::DemonstrationEstimate& demo) { return demo.hand; }
const std::vector<Pose>& gripperOf(const lfd::DemonstrationEstimate& demo) { return demo.gripper; }

/// A grasp as a dot with a line back along its approach.
struct Sample {
  Pose object_T_gripper;
  bool valid;
};

/// All grasps of the task's file; those below the quality asked for are in the
/// file only. Where it is gone, the valid ones are all there is.
std::vector<Sample> samplesNear(const lfd::LearnResult& result, const Vec<double, 3>& center) {
  std::vector<Sample> samples;
  const auto near = [&](const lfd::Grasp& grasp) {
    return (grasp.object_T_gripper.translation - center).norm() <= kNear;
  };
  Diagnostics ignored;
  try {
    const lfd::GraspSet all = lfd::GraspSet::read(result.task.task.grasps, 0, ignored);
    for (const lfd::Grasp& grasp : all.valid()) {
      if (grasp.quality < result.task.task.min_quality && near(grasp)) {
        samples.push_back({grasp.object_T_gripper, false});
      }
    }
  } catch (const Error&) {
    samples.clear();
  }
  if (result.scene.grasps == nullptr) return samples;
  for (const lfd::Grasp& grasp : result.scene.grasps->valid()) {
    if (near(grasp)) samples.push_back({grasp.object_T_gripper, true});
  }
  return samples;
}

void drawSamples(Svg& svg, const Axes& axes, int v, const std::vector<Sample>& samples) {
  PathData valid_dots;
  PathData valid_lines;
  PathData invalid;
  for (const Sample& sample : samples) {
    const Vec<double, 3> p = sample.object_T_gripper.translation;
    if (!sample.valid) {
      invalid.cross(axes.at(p[0], p[v]), 2.5);
      continue;
    }
    const Vec<double, 3> back = sample.object_T_gripper * Vec<double, 3>(-kApproach, 0, 0);
    valid_dots.dot(axes.at(p[0], p[v]));
    valid_lines.moveTo(axes.at(back[0], back[v]));
    valid_lines.lineTo(axes.at(p[0], p[v]));
  }
  svg.path(invalid, "s-muted w1 soft");
  svg.path(valid_lines, "s-base w1 soft");
  svg.path(valid_dots, "s-base w5");
}

void drawChoice(Svg& svg, const Axes& axes, int v, const lfd::LearnResult& result) {
  const auto ring = [&](const lfd::GraspSet::Choice& choice, const char* classes, double radius) {
    const lfd::GraspSet* grasps = result.scene.grasps.get();
    if (grasps == nullptr || choice.index < 0 ||
        std::size_t(choice.index) >= grasps->valid().size()) {
      return;
    }
    const Vec<double, 3> p = grasps->pose(choice).translation;
    svg.circle(axes.at(p[0], p[v]), radius, classes);
  };
  ring(result.grasp.runner_up, "s-muted w2 dash", 9);
  ring(result.grasp.choice, "s-ink w2", 9);
}

void drawPanel(Svg& svg, const Axes& axes, int v, const std::vector<Dots>& clouds,
               const std::vector<Sample>& samples, const lfd::LearnResult& result) {
  axes.draw(svg, "x of the object, m", verticalName(v));
  svg.beginClip({axes.box().x, axes.box().y}, axes.box().width, axes.box().height);
  PathData origin;
  origin.polyline({axes.at(axes.x().low, 0), axes.at(axes.x().high, 0)});
  origin.polyline({axes.at(0, axes.y().low), axes.at(0, axes.y().high)});
  svg.path(origin, "s-muted w1 soft dash");
  drawSamples(svg, axes, v, samples);
  for (const Dots& cloud : clouds) {
    PathData dots;
    for (const auto& p : cloud.points) dots.dot(axes.at(p[0], p[v]));
    svg.path(dots, cloud.classes);
  }
  drawChoice(svg, axes, v, result);
  svg.endClip();
}

/// Two panels of the same scale and the same x.
std::array<Axes, 2> panels(const std::vector<Dots>& clouds, const std::vector<Sample>& samples) {
  std::array<Range, 3> range;
  const auto include = [&](const Vec<double, 3>& p) {
    for (int k = 0; k < 3; ++k) range[std::size_t(k)].include(p[k]);
  };
  for (const Dots& cloud : clouds) {
    for (const auto& p : cloud.points) include(p);
  }
  for (const Sample& sample : samples) include(sample.object_T_gripper.translation);
  double size = 0.06;
  for (Range& r : range) {
    r = r.padded(0.08, 0.04);
    size = std::max(size, r.size());
  }
  const auto make = [&](double x, int v) {
    return Axes::equal({x, kTop, kPanel, kPanel}, range[0].padded(0, size),
                       range[std::size_t(v)].padded(0, size));
  };
  return {make(58, kVertical[0]), make(58 + kPanel + 74, kVertical[1])};
}

}  // namespace

Picture graspPicture(const lfd::LearnResult& result) {
  const std::vector<Dots> clouds{{seenFromObject(result.before, handOf, false), "s-hand w3 faint"},
                                 {seenFromObject(result.before, handOf, true), "s-hand w5 soft"},
                                 {seenFromObject(result.after, handOf, false), "s-hand w6"},
                                 {seenFromObject(result.after, gripperOf, false), "s-gripper w6"}};
  const std::vector<Sample> samples =
      samplesNear(result, result.grasp.object_T_gripper.translation);
  bool invalid = false;
  for (const Sample& sample : samples) invalid = invalid || !sample.valid;
  std::vector<LegendEntry> legend{
      {Mark::kDot, "s-hand w5 soft", "hand as recorded (large: at the grasp)"},
      {Mark::kDot, "s-hand w6", "hand, optimized"},
      {Mark::kDot, "s-gripper w6", "gripper, optimized"},
      {Mark::kDot, "s-base w5", "valid grasp and its approach"}};
  if (invalid) legend.push_back({Mark::kCross, "s-muted w1", "grasp of too low quality"});
  legend.push_back({Mark::kRing, "s-ink w2", "chosen"});
  if (result.grasp.runner_up.index >= 0) {
    legend.push_back({Mark::kRing, "s-muted w2 dash", "runner-up"});
  }
  const double below = kTop + kPanel + 44;
  const double height = drawLegend(nullptr, {}, kWidth - 58, legend);
  Svg svg(kWidth, below + height + 6);
  const std::array<Axes, 2> axes = panels(clouds, samples);
  for (std::size_t k = 0; k < 2; ++k) {
    svg.text({axes[k].box().x, 18}, kTitles[k], "title");
    drawPanel(svg, axes[k], kVertical[k], clouds, samples, result);
  }
  drawLegend(&svg, {58, below}, kWidth - 58, legend);
  return {"grasp", "The grasp, seen from the object",
          "Hand and gripper while the object is manipulated, in the object's frame. The recorded "
          "hand scatters; the optimized gripper gathers at the chosen grasp instead of imitating "
          "the hand, whose grip would not fit the robot.",
          svg};
}

namespace {

/// A name beside a point, moved down until it covers no other.
class Labels {
 public:
  void add(Svg& svg, const Box& panel, Point at, const std::string& name) {
    constexpr double kLine = 12;
    constexpr double kCharacter = 6.6;
    const bool left = at.x > panel.x + 0.6 * panel.width;
    const double width = kCharacter * double(name.size());
    Box box{left ? at.x - 8 - width : at.x + 8, at.y - 0.5 * kLine, width, kLine};
    while (std::any_of(taken_.begin(), taken_.end(), [&](const Box& b) {
      return std::abs(b.y - box.y) < kLine && b.x < box.x + box.width && box.x < b.x + b.width;
    })) {
      box.y += 1;
    }
    taken_.push_back(box);
    if (box.y > at.y) {
      svg.line(at, {left ? at.x - 8 : at.x + 8, box.y + 0.5 * kLine}, "s-muted w1 soft");
    }
    svg.text({left ? at.x - 8 : at.x + 8, box.y + 0.5 * kLine + 4}, name, "small",
             left ? Anchor::kEnd : Anchor::kStart);
  }
  /// Dots keep names off, too.
  void addDot(Point at) { taken_.push_back({at.x - 4, at.y - 6, 8, 12}); }

 private:
  std::vector<Box> taken_;
};

/// Per recorded demonstration whether its way of holding was learned.
std::vector<char> learnedHolds(const lfd::LearnResult& result) {
  std::vector<char> learned(result.holds.names.size(), result.common_grasp ? 0 : 1);
  if (!result.common_grasp) return learned;
  for (const std::size_t d : result.holds.modes[result.mode].demonstrations) learned[d] = 1;
  return learned;
}

void drawHolds(Svg& svg, const Axes& axes, int v, const lfd::LearnResult& result) {
  const std::vector<char> learned = learnedHolds(result);
  PathData dots;
  PathData others;
  Labels labels;
  std::vector<Point> points;
  for (std::size_t d = 0; d < result.holds.names.size(); ++d) {
    const Pose& hold = result.holds.spread.object_T_hand[d];
    points.push_back(axes.at(hold.translation[0], hold.translation[v]));
    (learned[d] != 0 ? dots : others).dot(points.back());
    labels.addDot(points.back());
  }
  for (std::size_t d = 0; d < points.size(); ++d) {
    labels.add(svg, axes.box(), points[d], result.holds.names[d]);
  }
  svg.path(others, "s-muted w6");
  svg.path(dots, "s-hand w6");
}

}  // namespace

Picture holdsPicture(const lfd::LearnResult& result) {
  Dots dots{{}, ""};
  for (const Pose& pose : result.holds.spread.object_T_hand) {
    dots.points.push_back(pose.translation);
  }
  const std::array<Axes, 2> axes = panels({dots}, {});
  const double below = kTop + kPanel + 44;
  const std::vector<LegendEntry> legend{
      {Mark::kDot, "s-hand w6", "hand of a learned demonstration"},
      {Mark::kDot, "s-muted w6", "left out"}};
  const double height = result.common_grasp ? drawLegend(nullptr, {}, kWidth - 58, legend) + 6 : 0;
  Svg svg(kWidth, below + height);
  for (std::size_t k = 0; k < 2; ++k) {
    svg.text({axes[k].box().x, 18}, kTitles[k], "title");
    axes[k].draw(svg, "x of the object, m", verticalName(kVertical[k]));
    drawHolds(svg, axes[k], kVertical[k], result);
  }
  if (result.common_grasp) drawLegend(&svg, {58, below}, kWidth - 58, legend);
  return {"holds", "Where each demonstration holds the object",
          "Mean position of the hand in the object's frame while it is manipulated. A shared grasp "
          "needs these points, and the hand's orientation there, to agree.",
          svg};
}

}  // namespace graft::report
