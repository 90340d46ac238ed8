// SPDX-License-Identifier: BSD-3-Clause
// Every edge of slam3d and slam3d_addons against formulas in long double.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/plugins/edge_case.hpp"

namespace graft::testing {
namespace {

using All = std::vector<Numbers>;

Numbers chartOf(const SpacePose& measured, const SpacePose& predicted) {
  return quaternionChart(inverse(measured) * predicted);
}
/// The quaternion's w not near 0, where the chart jumps.
bool chartIsSmooth(const Numbers& e) { return e[3] * e[3] + e[4] * e[4] + e[5] * e[5] < 0.95L; }
/// [x/z y/z z] of K * p.
Numbers projected(const Numbers& camera, const Numbers& pose, const Numbers& point) {
  const SpacePose at = spacePose(pose) * spacePose(camera);
  const Numbers p = transformed(inverse(at), point);
  return {(camera[7] * p[0] + camera[9] * p[2]) / p[2],
          (camera[8] * p[1] + camera[10] * p[2]) / p[2], p[2]};
}
Real dot(const Numbers& a, const Numbers& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Numbers cross(const Numbers& a, const Numbers& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Numbers unit(const Numbers& a) {
  const Real length = std::sqrt(dot(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}

Numbers planeError(const All& x, const Numbers& z) {
  const SpacePose sensor = spacePose(x[0]) * spacePose(x[2]);
  const SpacePose inv = inverse(sensor);
  SpacePose turn = inv;
  for (Real& t : turn.t) t = 0;
  const Numbers n = transformed(turn, unit(x[1]));
  const Real d =
      x[1][3] / std::sqrt(dot(x[1], x[1])) - inv.t[0] * n[0] - inv.t[1] * n[1] - inv.t[2] * n[2];
  // The measured normal by turning n to the x axis: first about z, then about y.
  const Real azimuth = std::atan2(n[1], n[0]);
  const Real elevation = std::atan2(n[2], std::hypot(n[0], n[1]));
  const Numbers m = unit(z);
  const Real m1 = std::cos(azimuth) * m[0] + std::sin(azimuth) * m[1];
  const Real m2 = -std::sin(azimuth) * m[0] + std::cos(azimuth) * m[1];
  const Real m3 = std::cos(elevation) * m1 + std::sin(elevation) * m[2];
  const Real m4 = -std::sin(elevation) * m1 + std::cos(elevation) * m[2];
  return {std::atan2(m2, m3), std::atan2(m4, std::hypot(m3, m2)), -d + z[3] / std::sqrt(dot(z, z))};
}

Numbers lineError(const All& x, const Numbers& z) {
  // Two points of the line, seen from the pose, make the line anew.
  const Numbers d = unit({x[1][3], x[1][4], x[1][5]});
  const Numbers p = cross(d, {x[1][0], x[1][1], x[1][2]});
  const SpacePose inv = inverse(spacePose(x[0]));
  const Numbers a = transformed(inv, p);
  const Numbers b = transformed(inv, {p[0] + d[0], p[1] + d[1], p[2] + d[2]});
  const Numbers seen_d = minus(b, a);
  const Numbers seen_w = cross(a, seen_d);
  const auto axes = [](const Numbers& w, const Numbers& direction) {
    return All{unit(w), unit(direction), unit(cross(w, direction))};
  };
  const Numbers mw = {z[0], z[1], z[2]}, md = {z[3], z[4], z[5]};
  const All u = axes(seen_w, seen_d), v = axes(mw, md);
  Real r[3][3];
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) r[i][j] = dot(u[i], v[j]);
  }
  Numbers q = quaternionOf(r);
  const Real norm = std::sqrt(dot(q, q) + q[3] * q[3]);
  for (Real& part : q) part /= norm;
  return {q[0], q[1], q[2],
          std::atan2(std::sqrt(dot(md, md)), std::sqrt(dot(mw, mw))) -
              std::atan2(Real(1), std::sqrt(dot(seen_w, seen_w)))};
}

/// Roll, pitch, yaw of [x y z w], which need not be a unit quaternion: through its
/// rotation matrix and back, as g2o does.
Numbers eulerThroughMatrix(const Numbers& q) {
  const Real x = q[0], y = q[1], z = q[2], w = q[3];
  const Real r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                        {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                        {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  const Numbers b = quaternionOf(r);
  return {std::atan2(2 * (b[3] * b[0] + b[1] * b[2]), 1 - 2 * (b[0] * b[0] + b[1] * b[1])),
          std::asin(2 * (b[3] * b[1] - b[2] * b[0])),
          std::atan2(2 * (b[3] * b[2] + b[0] * b[1]), 1 - 2 * (b[1] * b[1] + b[2] * b[2]))};
}

/// g2o's EDGE3: e'(J' Omega J)e with J by central differences of 1e-6.
Numbers eulerEdgeError(const All& x, const Numbers& z) {
  const SpacePose measured = eulerPose(z);
  const Numbers e = chartOf(measured, inverse(eulerPose(x[0])) * eulerPose(x[1]));
  const Numbers q = quaternionOf(measured.r);
  Numbers result = {e[0], e[1], e[2], 0, 0, 0};
  for (std::size_t c = 0; c < 3; ++c) {
    constexpr Real kStep = 1e-6L;
    Numbers low = q, high = q;
    low[c] -= kStep;
    high[c] += kStep;
    const Numbers change = minus(eulerThroughMatrix(high), eulerThroughMatrix(low));
    for (std::size_t i = 0; i < 3; ++i) result[3 + i] += change[i] / (2 * kStep) * e[3 + c];
  }
  return result;
}

const std::vector<EdgeCase>& cases() {
  static const std::vector<EdgeCase> all = {
      {"EDGE_SE3:QUAT",
       {"VERTEX_SE3:QUAT", "VERTEX_SE3:QUAT"},
       {},
       "xxxqqqq",
       [](const All& x, const All&, const Numbers& z) {
         return chartOf(spacePose(z), inverse(spacePose(x[0])) * spacePose(x[1]));
       },
       chartIsSmooth},
      {"EDGE_SE3_OFFSET",
       {"VERTEX_SE3:QUAT", "VERTEX_SE3:QUAT"},
       {"PARAMS_SE3OFFSET", "PARAMS_SE3OFFSET"},
       "xxxqqqq",
       [](const All& x, const All& r, const Numbers& z) {
         const SpacePose a = spacePose(x[0]) * spacePose(r[0]);
         return chartOf(spacePose(z), inverse(a) * (spacePose(x[1]) * spacePose(r[1])));
       },
       chartIsSmooth},
      {"EDGE_SE3_PRIOR",
       {"VERTEX_SE3:QUAT"},
       {"PARAMS_SE3OFFSET"},
       "xxxqqqq",
       [](const All& x, const All& r, const Numbers& z) {
         return chartOf(spacePose(z), spacePose(x[0]) * spacePose(r[0]));
       },
       chartIsSmooth},
      {"EDGE_SE3_XYZ_PRIOR",
       {"VERTEX_SE3:QUAT"},
       {"PARAMS_SE3OFFSET"},
       "xxx",
       [](const All& x, const All&, const Numbers& z) {
         return Numbers{x[0][0] - z[0], x[0][1] - z[1], x[0][2] - z[2]};
       }},
      {"EDGE_SE3_TRACKXYZ",
       {"VERTEX_SE3:QUAT", "VERTEX_TRACKXYZ"},
       {"PARAMS_SE3OFFSET"},
       "xxx",
       [](const All& x, const All& r, const Numbers& z) {
         return minus(transformed(inverse(spacePose(x[0]) * spacePose(r[0])), x[1]), z);
       }},
      {"EDGE_PROJECT_DEPTH",
       {"VERTEX_SE3:QUAT", "VERTEX_TRACKXYZ"},
       {"PARAMS_CAMERACALIB"},
       "xxx",
       [](const All& x, const All& r, const Numbers& z) {
         return minus(projected(r[0], x[0], x[1]), z);
       },
       // Depth is measured: an error below this means a depth well away from 0.
       [](const Numbers& e) { return std::abs(e[0]) < 8 && std::abs(e[1]) < 8; }},
      {"EDGE_PROJECT_DISPARITY",
       {"VERTEX_SE3:QUAT", "VERTEX_TRACKXYZ"},
       {"PARAMS_CAMERACALIB"},
       "xxx",
       [](const All& x, const All& r, const Numbers& z) {
         const Numbers p = projected(r[0], x[0], x[1]);
         return minus({p[0], p[1], 1 / p[2]}, z);
       },
       [](const Numbers& e) {
         return std::abs(e[0]) < 8 && std::abs(e[1]) < 8 && std::abs(e[2]) < 4;
       }},
      {"EDGE_POINTXYZ",
       {"VERTEX_TRACKXYZ", "VERTEX_TRACKXYZ"},
       {},
       "xxx",
       [](const All& x, const All&, const Numbers& z) { return minus(minus(x[1], x[0]), z); }},
      {"EDGE_POINTXYZ_PRIOR",
       {"VERTEX_TRACKXYZ"},
       {},
       "xxx",
       [](const All& x, const All&, const Numbers& z) { return minus(x[0], z); }},
      {"EDGE_SE3_LOTSOF_XYZ",
       {"VERTEX_SE3:QUAT", "VERTEX_TRACKXYZ", "VERTEX_TRACKXYZ"},
       {},
       "2xxxxxx",
       [](const All& x, const All&, const Numbers& z) {
         Numbers e = transformed(inverse(spacePose(x[0])), x[1]);
         const Numbers second = transformed(inverse(spacePose(x[0])), x[2]);
         e.insert(e.end(), second.begin(), second.end());
         return minus(e, Numbers(z.begin() + 1, z.end()));
       }},
      {"EDGE3",
       {"VERTEX3", "VERTEX3"},
       {},
       "xxxapa",
       [](const All& x, const All&, const Numbers& z) { return eulerEdgeError(x, z); },
       chartIsSmooth,
       // The same without J.
       [](const All& x, const All&, const Numbers& z) {
         return chartOf(eulerPose(z), inverse(eulerPose(x[0])) * eulerPose(x[1]));
       }},
      {"EDGE_SE3_CALIB",
       {"VERTEX_SE3:QUAT", "VERTEX_SE3:QUAT", "VERTEX_SE3:QUAT"},
       {},
       "xxxqqqq",
       [](const All& x, const All&, const Numbers& z) {
         const SpacePose c = spacePose(x[2]);
         return chartOf(spacePose(z), inverse(c) * inverse(spacePose(x[0])) * spacePose(x[1]) * c);
       },
       chartIsSmooth},
      {"EDGE_PLANE",
       {"VERTEX_PLANE", "VERTEX_PLANE"},
       {},
       "xxxx",
       [](const All& x, const All&, const Numbers& z) {
         return minus(
             minus({x[1][0], x[1][1], x[1][2], x[1][3]}, {x[0][0], x[0][1], x[0][2], x[0][3]}), z);
       }},
      {"EDGE_SE3_PLANE_CALIB",
       {"VERTEX_SE3:QUAT", "VERTEX_PLANE", "VERTEX_SE3:QUAT"},
       {},
       "nnnxccc",
       [](const All& x, const All&, const Numbers& z) { return planeError(x, z); },
       [](const Numbers& e) { return std::abs(e[0]) < 2.6L && std::abs(e[1]) < 1.2L; }},
      {"EDGE_SE3_LINE3D",
       {"VERTEX_SE3:QUAT", "VERTEX_LINE3D"},
       {"PARAMS_SE3OFFSET"},
       "xxxnnn",
       [](const All& x, const All&, const Numbers& z) {
         // graft takes out what the moment has along the direction.
         Numbers m = z;
         const Real along = z[0] * z[3] + z[1] * z[4] + z[2] * z[5];
         for (std::size_t i = 0; i < 3; ++i) m[i] -= along * z[3 + i];
         return lineError(x, m);
       },
       [](const Numbers& e) { return e[0] * e[0] + e[1] * e[1] + e[2] * e[2] < 0.6L; }},
  };
  return all;
}

TEST(SpatialTypes, EdgesAreWhatTheFormulasSay) {
  unsigned seed = 200;
  for (const EdgeCase& one : cases()) checkEdgeCase(one, ++seed);
}

TEST(SpatialTypes, BadLinesSayWhatIsWrong) {
  const std::string unit6 = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";
  const std::string head =
      "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_TRACKXYZ 1 1 2 3\nPARAMS_SE3OFFSET 5 1 2 3 0 0 0 1\n"
      "PARAMS_CAMERACALIB 6 0 0 0 0 0 0 1 500 500 320 240\n"
      "PARAMS_STEREOCAMERACALIB 7 0 0 0 0 0 0 1 500 500 320 240 0.1\n";
  const std::pair<std::string, const char*> table[] = {
      {"EDGE_SE3_TRACKXYZ 0 1 5 1 2 3 1 0 0 1 0 1", "loaded"},
      {"EDGE_PROJECT_DEPTH 0 1 6 1 2 3 1 0 0 1 0 1", "loaded"},
      {"PARAMS_CAMERACALIB 8 0 0 0 0 0 0 1 500 500 320",
       ":6: error: PARAMS_CAMERACALIB 8: expected 11 numbers (x y z qx qy qz qw fx fy cx cy), got"},
      {"PARAMS_CAMERACALIB 8 0 0 0 0 0 0 1 0 500 320 240", "a focal length is zero"},
      {"PARAMS_CAMERACALIB 8 0 0 0 0 0 0 5 1 500 320 240", "the length of the quaternion"},
      {"PARAMS_STEREOCAMERACALIB 8 0 0 0 0 0 0 1 1 500 320 240", "expected 12 numbers"},
      {"EDGE_SE3_TRACKXYZ 0 1 6 1 2 3 1 0 0 1 0 1",
       "needs a PARAMS_SE3OFFSET, resource 6 is PARAMS_CAMERACALIB"},
      {"EDGE_PROJECT_DEPTH 0 1 7 1 2 3 1 0 0 1 0 1",
       "needs a PARAMS_CAMERACALIB, resource 7 is PARAMS_STEREOCAMERACALIB"},
      {"EDGE_PROJECT_DISPARITY 0 1 1 2 3 1 0 0 1 0 1", "EDGE_PROJECT_DISPARITY: expected"},
      {"EDGE_SE3_LOTSOF_XYZ 0 1 || 1.5 1 2 3 1 0 0 1 0 1", "the number after || must be 1"},
      {"VERTEX_PLANE 9 0 0 0 1 1 1 1", "the normal of the plane is zero"},
      {"VERTEX_PLANE 9 0 0 1 1", "VERTEX_PLANE: expected 8 fields, got 5"},
      {"VERTEX_LINE3D 9 1 0 0 0 0 0", "the direction of the line is zero"},
      {"VERTEX3 9 1 2 3 0 0 0\nEDGE3 9 0 1 2 3 0 0 0" + unit6,
       "slot 2 needs VERTEX3, vertex 0 is VERTEX_SE3:QUAT"},
  };
  for (const auto& [line, message] : table) {
    const std::string said = messagesOf(head + line + "\n");
    EXPECT_NE(said.find(message), std::string::npos) << line << "\n" << said;
  }
}

}  // namespace
}  // namespace graft::testing
