// SPDX-License-Identifier: BSD-3-Clause
// Every edge of slam2d and slam2d_addons against formulas in long double.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/plugins/edge_case.hpp"

namespace graft::testing {
namespace {

using All = std::vector<Numbers>;

Numbers poseError(const PlanePose& m) { return {m.x, m.y, wrapped(m.t)}; }
Numbers seen(const Numbers& pose, const Numbers& point) {
  return transformed(inverse(planePose(pose)), point[0], point[1]);
}
Numbers twoSeen(const Numbers& pose, const Numbers& a, const Numbers& b) {
  Numbers e = seen(pose, a);
  const Numbers second = seen(pose, b);
  e.insert(e.end(), second.begin(), second.end());
  return e;
}
/// [direction of the normal, distance] of the line through two points.
Numbers lineThrough(const Numbers& ends) {
  const Real dx = ends[2] - ends[0], dy = ends[3] - ends[1];
  const Real length = std::sqrt(dx * dx + dy * dy);
  const Real nx = dy / length, ny = -dx / length;
  return {std::atan2(ny, nx), nx * ends[0] + ny * ends[1]};
}
/// No angle of the error near its jump.
bool noJump(const Numbers& e) {
  for (const Real part : e) {
    if (std::abs(std::abs(part) - 3.14159265L) < 0.15L) return false;
  }
  return true;
}

const std::vector<EdgeCase>& cases() {
  static const std::vector<EdgeCase> all = {
      {"EDGE_SE2",
       {"VERTEX_SE2", "VERTEX_SE2"},
       {},
       "xxa",
       [](const All& x, const All&, const Numbers& z) {
         return poseError(inverse(planePose(z)) * (inverse(planePose(x[0])) * planePose(x[1])));
       },
       noJump},
      {"EDGE_SE2_OFFSET",
       {"VERTEX_SE2", "VERTEX_SE2"},
       {"PARAMS_SE2OFFSET", "PARAMS_SE2OFFSET"},
       "xxa",
       [](const All& x, const All& r, const Numbers& z) {
         const PlanePose a = planePose(x[0]) * planePose(r[0]);
         const PlanePose b = planePose(x[1]) * planePose(r[1]);
         return poseError(inverse(planePose(z)) * (inverse(a) * b));
       },
       noJump},
      {"EDGE_PRIOR_SE2",
       {"VERTEX_SE2"},
       {},
       "xxa",
       [](const All& x, const All&, const Numbers& z) {
         return poseError(inverse(planePose(z)) * planePose(x[0]));
       },
       noJump},
      {"EDGE_PRIOR_SE2_XY",
       {"VERTEX_SE2"},
       {},
       "xx",
       [](const All& x, const All&, const Numbers& z) {
         return Numbers{x[0][0] - z[0], x[0][1] - z[1]};
       }},
      {"EDGE_PRIOR_XY",
       {"VERTEX_XY"},
       {},
       "xx",
       [](const All& x, const All&, const Numbers& z) { return minus(x[0], z); }},
      {"EDGE_SE2_XY",
       {"VERTEX_SE2", "VERTEX_XY"},
       {},
       "xx",
       [](const All& x, const All&, const Numbers& z) { return minus(seen(x[0], x[1]), z); }},
      {"EDGE_BEARING_SE2_XY",
       {"VERTEX_SE2", "VERTEX_XY"},
       {},
       "a",
       [](const All& x, const All&, const Numbers& z) {
         const Numbers p = seen(x[0], x[1]);
         return Numbers{wrapped(z[0] - std::atan2(p[1], p[0]))};
       },
       noJump},
      {"EDGE_SE2_XY_CALIB",
       {"VERTEX_SE2", "VERTEX_XY", "VERTEX_SE2"},
       {},
       "xx",
       [](const All& x, const All&, const Numbers& z) {
         const PlanePose sensor = planePose(x[0]) * planePose(x[2]);
         return minus(transformed(inverse(sensor), x[1][0], x[1][1]), z);
       }},
      {"EDGE_SE2_POINTXY_OFFSET",
       {"VERTEX_SE2", "VERTEX_XY"},
       {"PARAMS_SE2OFFSET"},
       "xx",
       [](const All& x, const All&, const Numbers& z) { return minus(seen(x[0], x[1]), z); }},
      {"EDGE_POINTXY",
       {"VERTEX_XY", "VERTEX_XY"},
       {},
       "xx",
       [](const All& x, const All&, const Numbers& z) { return minus(minus(x[1], x[0]), z); }},
      {"EDGE_SE2_TWOPOINTSXY",
       {"VERTEX_SE2", "VERTEX_XY", "VERTEX_XY"},
       {},
       "xxxx",
       [](const All& x, const All&, const Numbers& z) {
         return minus(twoSeen(x[0], x[1], x[2]), z);
       }},
      {"EDGE_SE2_LOTSOFXY",
       {"VERTEX_SE2", "VERTEX_XY", "VERTEX_XY", "VERTEX_XY"},
       {},
       "3xxxxxx",
       [](const All& x, const All&, const Numbers& z) {
         Numbers e = twoSeen(x[0], x[1], x[2]);
         const Numbers third = seen(x[0], x[3]);
         e.insert(e.end(), third.begin(), third.end());
         return minus(e, Numbers(z.begin() + 1, z.end()));
       }},
      {"EDGE_SE2_SEGMENT2D",
       {"VERTEX_SE2", "VERTEX_SEGMENT2D"},
       {},
       "xxxx",
       [](const All& x, const All&, const Numbers& z) {
         return minus(twoSeen(x[0], x[1], {x[1][2], x[1][3]}), z);
       }},
      {"EDGE_SE2_SEGMENT2D_LINE",
       {"VERTEX_SE2", "VERTEX_SEGMENT2D"},
       {},
       "ax",
       [](const All& x, const All&, const Numbers& z) {
         const Numbers line = lineThrough(twoSeen(x[0], x[1], {x[1][2], x[1][3]}));
         return Numbers{wrapped(line[0] - z[0]), line[1] - z[1]};
       },
       noJump},
      {"EDGE_SE2_SEGMENT2D_POINTLINE",
       {"VERTEX_SE2", "VERTEX_SEGMENT2D"},
       {},
       "exxa",
       [](const All& x, const All&, const Numbers& z) {
         const Numbers ends = twoSeen(x[0], x[1], {x[1][2], x[1][3]});
         const std::size_t end = z[0] == 0 ? 0 : 2;
         return Numbers{ends[end] - z[1], ends[end + 1] - z[2],
                        wrapped(lineThrough(ends)[0] - z[3])};
       },
       noJump},
      {"EDGE_SE2_LINE2D",
       {"VERTEX_SE2", "VERTEX_LINE2D"},
       {},
       "ax",
       [](const All& x, const All&, const Numbers& z) {
         // By a point of the line and its normal, both seen from the pose.
         const Real c = std::cos(x[1][0]), s = std::sin(x[1][0]);
         const PlanePose inv = inverse(planePose(x[0]));
         const Numbers point = transformed(inv, c * x[1][1], s * x[1][1]);
         const Real theta = x[1][0] + inv.t;
         return Numbers{wrapped(theta - z[0]),
                        std::cos(theta) * point[0] + std::sin(theta) * point[1] - z[1]};
       },
       noJump},
      {"EDGE_LINE2D",
       {"VERTEX_LINE2D", "VERTEX_LINE2D"},
       {},
       "ax",
       [](const All& x, const All&, const Numbers& z) {
         return Numbers{x[1][0] - x[0][0] - z[0], x[1][1] - x[0][1] - z[1]};
       }},
      {"EDGE_LINE2D_POINTXY",
       {"VERTEX_LINE2D", "VERTEX_XY"},
       {},
       "x",
       [](const All& x, const All&, const Numbers& z) {
         return Numbers{std::cos(x[0][0]) * x[1][0] + std::sin(x[0][0]) * x[1][1] - x[0][1] - z[0]};
       }},
  };
  return all;
}

TEST(PlanarTypes, EdgesAreWhatTheFormulasSay) {
  unsigned seed = 100;
  for (const EdgeCase& one : cases()) checkEdgeCase(one, ++seed);
}

TEST(PlanarTypes, BadLinesSayWhatIsWrong) {
  const std::string head =
      "VERTEX_SE2 0 0 0 0\nVERTEX_XY 1 1 2\nVERTEX_XY 2 2 2\nPARAMS_SE2OFFSET 5 1 2 3\n";
  const std::pair<const char*, const char*> table[] = {
      {"PARAMS_SE2OFFSET 6 1 2", ":5: error: PARAMS_SE2OFFSET 6: expected 3 numbers (x y theta)"},
      {"PARAMS_SE2OFFSET 6 1 2 x", "'x' is not a finite number"},
      {"PARAMS_SE2OFFSET 5 1 2 3", "resource 5 is already defined"},
      {"EDGE_SE2_POINTXY_OFFSET 0 1 7 1 2 1 0 1", "resource 7 is not defined"},
      {"EDGE_SE2_XY 0 0 1 2 1 0 1", "slot 2 needs VERTEX_XY, vertex 0 is VERTEX_SE2"},
      {"EDGE_BEARING_SE2_XY 0 1 1", "EDGE_BEARING_SE2_XY: expected 4 fields, got 3"},
      {"EDGE_SE2_LOTSOFXY 0 1 2 1 2 3 4", "expected"},
      {"EDGE_SE2_LOTSOFXY 0 1 || 2 1 2 1 0 1", "the number after || must be 1"},
      {"EDGE_SE2_LOTSOFXY 0 || 0", "needs at least two vertices"},
      {"EDGE_SE2_LOTSOFXY 1 2 || 1 1 2 1 0 1", "slot 1 needs VERTEX_SE2, vertex 1 is VERTEX_XY"},
      {"EDGE_SE2_LOTSOFXY 0 1 1 || 2 1 2 3 4 1 0 0 0 1 0 0 1 0 1", "names vertex 1 twice"},
      {"VERTEX_SEGMENT2D 9 1 2 3", "VERTEX_SEGMENT2D: expected 5 fields, got 4"},
      {"VERTEX_LINE2D 9 1 2 3.5 0", "p1 and p2 must be ids of points"},
      {"VERTEX_SEGMENT2D 9 0 0 1 1\nEDGE_SE2_SEGMENT2D_POINTLINE 0 9 2 1 2 3 1 0 0 1 0 1",
       "the number of the end must be 0 or 1"},
  };
  for (const auto& [line, message] : table) {
    const std::string said = messagesOf(head + line + "\n");
    EXPECT_NE(said.find(message), std::string::npos) << line << "\n" << said;
  }
}

}  // namespace
}  // namespace graft::testing
