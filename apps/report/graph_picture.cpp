// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <map>

#include "apps/report/axes.hpp"
#include "apps/report/pictures.hpp"
#include "core/base/text.hpp"

namespace graft::report {

namespace {

constexpr double kWidth = 960;
constexpr double kCenter = 480;
constexpr double kNode = 15;
constexpr int kColumns = 3;

// Rows of the sketch: hand beside object (E4) and beside gripper (E7), gripper
// beside base (E9), so that edges need not cross vertices.
constexpr double kTorsoRow = 78;
constexpr double kObjectRow = 162;
constexpr double kHandRow = 246;
constexpr double kGripperRow = 330;
constexpr double kBaseRow = 414;

/// Lines by their first token, i.e. vertices and edges by tag.
std::map<std::string, std::size_t> countTags(const std::string& graph) {
  std::map<std::string, std::size_t> counts;
  LineReader reader(graph);
  std::string_view line;
  while (reader.next(line)) {
    LineTokens tokens(line);
    const std::string tag(tokens.next());
    if (!tag.empty()) ++counts[tag];
  }
  return counts;
}

void drawNode(Svg& svg, Point at, const char* role, const std::string& name, bool unary) {
  const std::string stroke = std::string("s-") + role;
  if (unary) svg.circle(at, kNode + 4, stroke + " w1");
  svg.circle(at, kNode, stroke + " w2 f-paper");
  svg.text({at.x, at.y + 4}, name, "small", Anchor::kMiddle);
}

void drawEdge(Svg& svg, Point a, Point b, const char* stroke) {
  svg.line(a, b, std::string(stroke) + " w1");
}

/// Three lines that meet in a dot.
void drawTernary(Svg& svg, Point a, Point b, Point c, Point joint, const char* stroke) {
  PathData lines;
  for (const Point& end : {a, b}) {
    lines.moveTo(joint);
    lines.lineTo(end);
  }
  // Leaves level, so that lines to a shared vertex do not run into each other.
  lines.moveTo(joint);
  lines.curveTo({0.5 * (joint.x + c.x), joint.y}, c);
  svg.path(lines, std::string(stroke) + " w1");
  PathData dot;
  dot.dot(joint);
  svg.path(dot, std::string(stroke) + " w5");
}

/// One demonstration of three tuples; `side` is -1 left and +1 right of the
/// shared vertices. Tuples stand in time order away from (right: towards) them.
class Sketch {
 public:
  Sketch(Svg& svg, int side, std::string index)
      : svg_(svg), side_(side), index_(std::move(index)) {}

  void drawEdges(Point human, Point robot) const {
    for (const double row : {kTorsoRow, kObjectRow, kHandRow, kGripperRow, kBaseRow}) {
      const char* stroke = row > kHandRow ? "s-base" : "s-muted";
      for (int i = 0; i + 1 < kColumns; ++i) drawEdge(svg_, at(i, row), at(i + 1, row), stroke);
    }
    for (int i = 0; i < kColumns; ++i) {
      drawTernary(svg_, at(i, kHandRow), at(i, kGripperRow), offset(),
                  at(i, 0.5 * (kHandRow + kGripperRow)), "s-offset");
      drawEdge(svg_, at(i, kGripperRow), at(i, kBaseRow), "s-bad");
      if (i == 0) continue;
      drawTernary(svg_, at(i, kHandRow), at(i, kObjectRow), human,
                  at(i, 0.5 * (kHandRow + kObjectRow)), "s-hand");
      Point joint = at(i, kHandRow + 14);
      joint.x -= 34 * side_;
      drawTernary(svg_, at(i, kObjectRow), at(i, kGripperRow), robot, joint, "s-gripper");
    }
  }

  void drawNodes() const {
    for (int i = 0; i < kColumns; ++i) {
      const std::string n = index_ + "," + std::to_string(i + 1);
      // One pose of the object was not seen: no observation, so no ring.
      drawNode(svg_, at(i, kTorsoRow), "torso", "t" + n, true);
      drawNode(svg_, at(i, kObjectRow), "object", "o" + n, i != 2);
      drawNode(svg_, at(i, kHandRow), "hand", "h" + n, true);
      drawNode(svg_, at(i, kGripperRow), "gripper", "g" + n, false);
      drawNode(svg_, at(i, kBaseRow), "base", "b" + n, true);
    }
    drawNode(svg_, offset(), "offset", "gh" + index_, true);
    const char* names[] = {"reaching", "grasp", "manipulation"};
    for (int i = 0; i < kColumns; ++i) {
      svg_.text({at(i, 0).x, kTorsoRow - 30}, names[i], "small muted", Anchor::kMiddle);
    }
  }

  Point graspGripper() const { return at(1, kGripperRow); }

 private:
  Point at(int column, double row) const { return {kCenter + side_ * (330 - 105.0 * column), row}; }
  Point offset() const { return {kCenter + side_ * 432, 0.5 * (kHandRow + kGripperRow)}; }

  Svg& svg_;
  int side_;
  std::string index_;
};

struct CountedEdge {
  const char* mark;  ///< stroke of the line in the sketch; null = ring, "" = none
  std::vector<const char*> tags;
  const char* text;
};

const std::vector<CountedEdge>& countedEdges() {
  static const std::vector<CountedEdge> edges{
      {nullptr, {"LFD_OBSERVATION"}, "E1 observation (ring)"},
      {"s-muted", {"LFD_RELATIVE_MOTION"}, "E2 observed motion"},
      {"s-base", {"LFD_GRIPPER_SMOOTH", "LFD_BASE_SMOOTH"}, "E3 smooth robot motion"},
      {"s-hand", {"LFD_HUMAN_GRASP", "LFD_HUMAN_GRASP_TURNED"}, "E4 human grasp"},
      {"s-gripper", {"LFD_ROBOT_GRASP"}, "E5 robot grasp"},
      {nullptr, {"LFD_GRASP_QUALITY"}, "E6 grasp quality (ring of RG)"},
      {"s-offset", {"LFD_HAND_GRIPPER"}, "E7 hand to gripper"},
      {nullptr, {"LFD_RESEMBLANCE", "LFD_RESEMBLANCE_TURNED"}, "E8 resemblance (ring of gh)"},
      {"s-bad", {"LFD_REACHABILITY"}, "E9 reachability"},
      {"s-gripper dash", {"LFD_GRASP_AGREEMENT"}, "E10 grasps agree"},
      {nullptr, {"LFD_BASE_PRIOR"}, "base position (ring of b)"},
      {"", {"LFD_STEADY_MOTION"}, "steady motion (not drawn)"},
  };
  return edges;
}

void drawCounts(Svg& svg, const lfd::LearnResult& result, double top) {
  const std::size_t tuples = result.task.tupleCount();
  const std::size_t demos = result.task.demonstrations.size();
  const std::string n = groupedNumber(tuples);
  svg.text({40, top}, "Vertices", "title");
  const std::array<std::array<std::string, 3>, 8> vertices{{
      {"torso", "t  human torso", n},
      {"object", "o  object", n},
      {"hand", "h  human hand", n},
      {"gripper", "g  robot gripper", n},
      {"base", "b  robot base", n},
      {"hand", "HG  hand on object, shared", "1"},
      {"gripper", "RG  gripper on object, shared", "1"},
      {"offset", "gh  gripper in hand, one per demonstration", groupedNumber(demos)},
  }};
  double y = top + 20;
  for (const auto& [role, text, count] : vertices) {
    svg.circle({46, y - 4}, 5, "s-" + role + " w2 f-paper");
    svg.text({60, y}, text, "label");
    svg.text({390, y}, count, "label", Anchor::kEnd);
    y += 19;
  }
  const std::map<std::string, std::size_t> counts = countTags(result.graph);
  svg.text({450, top}, "Edges", "title");
  std::size_t k = 0;
  for (const CountedEdge& edge : countedEdges()) {
    const double x = k < 6 ? 450 : 710;
    const double row = top + 20 + 19 * double(k % 6);
    if (edge.mark != nullptr && *edge.mark != '\0') {
      drawMark(svg, {x + 8, row - 4}, Mark::kLine, std::string(edge.mark) + " w2");
    } else if (edge.mark == nullptr) {
      svg.circle({x + 8, row - 4}, 3.5, "s-muted w1");
      svg.circle({x + 8, row - 4}, 6, "s-muted w1");
    }
    std::size_t count = 0;
    for (const char* tag : edge.tags) {
      const auto found = counts.find(tag);
      if (found != counts.end()) count += found->second;
    }
    svg.text({x + 24, row}, edge.text, "label");
    svg.text({x + 230, row}, groupedNumber(count), "label", Anchor::kEnd);
    ++k;
  }
}

}  // namespace

Picture graphPicture(const lfd::LearnResult& result) {
  Svg svg(kWidth, kBaseRow + 62 + 9 * 19);
  const Point human{kCenter, 0.5 * (kObjectRow + kHandRow)};
  const Point robot{kCenter, 0.5 * (kHandRow + kGripperRow) + 8};
  const Sketch left(svg, -1, "1");
  const Sketch right(svg, 1, "2");
  PathData agreement;
  agreement.moveTo(left.graspGripper());
  agreement.curveTo({kCenter, 0.5 * (kGripperRow + kBaseRow) + 45}, right.graspGripper());
  svg.path(agreement, "s-gripper w1 dash");
  for (const Sketch* sketch : {&left, &right}) sketch->drawEdges(human, robot);
  for (const Sketch* sketch : {&left, &right}) sketch->drawNodes();
  drawNode(svg, human, "hand", "HG", false);
  drawNode(svg, robot, "gripper", "RG", true);
  const auto& demos = result.task.demonstrations;
  const auto name = [&](std::size_t d) {
    return demos.size() > d ? demos[d].matched.name : std::string("another demonstration");
  };
  svg.text({kCenter - 225, 22}, name(0), "title", Anchor::kMiddle);
  svg.text({kCenter + 225, 22}, name(1), "title", Anchor::kMiddle);
  drawCounts(svg, result, kBaseRow + 62);
  return {"graph", "Structure of the hypergraph",
          "Two of " + std::to_string(demos.size()) +
              " demonstrations with three tuples each (the right one mirrored); the numbers below "
              "are those of the whole graph. Rings are edges to one vertex; three lines that meet "
              "in a dot are edges "
              "between three. The shared vertices HG and RG tie all demonstrations together. In "
              "this sketch the object was not seen at the third tuple, so its pose has no ring.",
          svg};
}

}  // namespace graft::report
