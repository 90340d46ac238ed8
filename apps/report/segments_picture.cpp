// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/axes.hpp"
#include "apps/report/pictures.hpp"

namespace graft::report {

namespace {

constexpr double kWidth = 960;
constexpr double kLeft = 120;
constexpr double kRight = 60;
constexpr double kTop = 34;
constexpr double kRow = 64;

struct Track {
  const char* name;
  const char* stroke;
  const lfd::MatchedTrack* track;
};

/// One tick per tuple, long and coloured where the pose was measured.
void drawTicks(Svg& svg, const Axes& axes, const std::vector<double>& times, const Track& track,
               double y) {
  PathData measured;
  PathData interpolated;
  for (std::size_t i = 0; i < track.track->measured.size() && i < times.size(); ++i) {
    const double x = axes.at(times[i] - times.front(), 0).x;
    PathData& path = track.track->measured[i] ? measured : interpolated;
    path.moveTo({x, track.track->measured[i] ? y : y + 2.5});
    path.lineTo({x, y + (track.track->measured[i] ? 6 : 3.5)});
  }
  svg.path(interpolated, "s-muted w1 soft");
  svg.path(measured, std::string(track.stroke) + " w1");
  svg.text({kLeft - 8, y + 6.5}, track.name, "small muted", Anchor::kEnd);
}

void drawDemonstration(Svg& svg, const Axes& axes, const lfd::PreparedDemonstration& demo,
                       double y) {
  const std::vector<double>& times = demo.matched.times;
  if (times.empty()) return;
  const auto x = [&](std::size_t i) { return axes.at(times[i] - times.front(), 0).x; };
  const std::size_t last = times.size() - 1;
  const double grasp = x(std::min(demo.segments.grasp, last));
  const double release = x(std::min(demo.segments.release, last));
  svg.text({kLeft - 8, y + 13}, demo.matched.name, "label", Anchor::kEnd);
  svg.rect({x(0), y + 2}, grasp - x(0), 16, "f-reaching");
  svg.rect({grasp, y + 2}, release - grasp, 16, "f-manipulation");
  svg.rect({release, y + 2}, x(last) - release, 16, "f-retreat");
  for (const double boundary : {grasp, release}) {
    svg.line({boundary, y}, {boundary, y + 54}, "s-ink w1 crisp");
  }
  svg.text({x(last) + 6, y + 14}, std::to_string(times.size()), "small muted");
  const Track tracks[] = {{"hand", "s-hand", &demo.matched.hand},
                          {"object", "s-object", &demo.matched.object},
                          {"torso", "s-torso", &demo.matched.torso}};
  double row = y + 22;
  for (const Track& track : tracks) {
    drawTicks(svg, axes, times, track, row);
    row += 11.5;
  }
}

std::string share(std::size_t part, std::size_t all) {
  return all == 0 ? "none" : fixedNumber(100.0 * double(part) / double(all), 0) + " %";
}

}  // namespace

Picture segmentsPicture(const lfd::LearnResult& result) {
  const auto& demos = result.task.demonstrations;
  Range span(0, 1e-3);
  std::size_t tuples = 0;
  std::size_t hand = 0;
  std::size_t object = 0;
  std::size_t torso = 0;
  for (const lfd::PreparedDemonstration& demo : demos) {
    if (demo.size() > 0) span.include(demo.matched.times.back() - demo.matched.times.front());
    tuples += demo.size();
    hand += demo.matched.hand.measuredCount();
    object += demo.matched.object.measuredCount();
    torso += demo.matched.torso.measuredCount();
  }
  const double height = kRow * double(demos.size());
  Svg svg(kWidth, kTop + height + 40);
  drawLegend(&svg, {kLeft, 2}, kWidth - kLeft,
             {{Mark::kBox, "f-reaching", "reaching"},
              {Mark::kBox, "f-manipulation", "manipulation"},
              {Mark::kBox, "f-retreat", "retreat"},
              {Mark::kLine, "s-hand w3", "measured (coloured tick)"},
              {Mark::kLine, "s-muted w1", "interpolated (short grey tick)"}});
  const Axes axes({kLeft, kTop, kWidth - kLeft - kRight, height}, span, {0, 1});
  axes.draw(svg, "time since the demonstration began, s", "", 10, 0);
  double y = kTop + 4;
  for (const lfd::PreparedDemonstration& demo : demos) {
    drawDemonstration(svg, axes, demo, y);
    y += kRow;
  }
  const std::string caption =
      "The manipulation begins when the hand takes the object and ends when it lets go; the rule "
      "between is the grasp. Every tick is a tuple (their number stands at the right). Measured: " +
      share(hand, tuples) + " of the hand's poses, " + share(object, tuples) +
      " of the object's, " + share(torso, tuples) +
      " of the torso's; gaps were interpolated and carry no observation.";
  return {"segments", "Segments of the demonstrations", caption, svg};
}

}  // namespace graft::report
