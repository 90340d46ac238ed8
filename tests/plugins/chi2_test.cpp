// SPDX-License-Identifier: BSD-3-Clause
// The cost of whole files, against a recomputation that shares nothing with the
// library: its own reader, long double, rotation matrices.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"
#include "tests/support/graphs.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

using Real = long double;

struct RigidMotion {
  Real r[3][3];
  Real t[3];
};

RigidMotion fromQuaternion(const Real* p) {
  const Real n = std::sqrt(p[3] * p[3] + p[4] * p[4] + p[5] * p[5] + p[6] * p[6]);
  const Real x = p[3] / n, y = p[4] / n, z = p[5] / n, w = p[6] / n;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
           {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
           {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}},
          {p[0], p[1], p[2]}};
}

/// a^-1 * b.
RigidMotion between(const RigidMotion& a, const RigidMotion& b) {
  RigidMotion m{};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 3; ++j) m.r[i][j] += a.r[k][i] * b.r[k][j];
      m.t[i] += a.r[k][i] * (b.t[k] - a.t[k]);
    }
  }
  return m;
}

/// [t; vector part of the unit quaternion with w >= 0].
void quaternionChart(const RigidMotion& m, Real* e) {
  const Real trace = m.r[0][0] + m.r[1][1] + m.r[2][2];
  Real q[4];  // x y z w
  if (trace > 0) {
    q[3] = std::sqrt(1 + trace) / 2;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      q[i] = (m.r[k][j] - m.r[j][k]) / (4 * q[3]);
    }
  } else {
    int i = 0;
    for (int k = 1; k < 3; ++k) {
      if (m.r[k][k] > m.r[i][i]) i = k;
    }
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    q[i] = std::sqrt(1 + m.r[i][i] - m.r[j][j] - m.r[k][k]) / 2;
    q[j] = (m.r[i][j] + m.r[j][i]) / (4 * q[i]);
    q[k] = (m.r[i][k] + m.r[k][i]) / (4 * q[i]);
    q[3] = (m.r[k][j] - m.r[j][k]) / (4 * q[i]);
  }
  const Real sign = q[3] < 0 ? -1 : 1;
  for (int i = 0; i < 3; ++i) {
    e[i] = m.t[i];
    e[3 + i] = sign * q[i];
  }
}

void planarError(const Real* z, const Real* a, const Real* b, Real* e) {
  const Real dx = b[0] - a[0], dy = b[1] - a[1];
  const Real lx = std::cos(a[2]) * dx + std::sin(a[2]) * dy - z[0];
  const Real ly = -std::sin(a[2]) * dx + std::cos(a[2]) * dy - z[1];
  e[0] = std::cos(z[2]) * lx + std::sin(z[2]) * ly;
  e[1] = -std::sin(z[2]) * lx + std::cos(z[2]) * ly;
  const Real angle = b[2] - a[2] - z[2];
  e[2] = std::atan2(std::sin(angle), std::cos(angle));
}

void sightError(const Real* z, const Real* a, const Real* point, Real* e) {
  const Real dx = point[0] - a[0], dy = point[1] - a[1];
  e[0] = std::cos(a[2]) * dx + std::sin(a[2]) * dy - z[0];
  e[1] = -std::sin(a[2]) * dx + std::cos(a[2]) * dy - z[1];
}

Real weighted(const Real* e, const Real* upper, int n) {
  Real sum = 0;
  for (int r = 0; r < n; ++r) {
    for (int c = r; c < n; ++c) sum += (r == c ? 1 : 2) * e[r] * *upper++ * e[c];
  }
  return sum;
}

/// Numbers are read as double first, as the library must.
std::vector<Real> numbersOf(std::istringstream& line) {
  std::vector<Real> numbers;
  for (std::string token; line >> token;) numbers.push_back(std::strtod(token.c_str(), nullptr));
  return numbers;
}

Real recomputedChi2(const std::string& path) {
  std::map<long, std::vector<Real>> vertices;
  std::vector<std::pair<std::string, std::vector<Real>>> edges;
  std::istringstream text(testing::readTestFile(path));
  for (std::string line; std::getline(text, line);) {
    std::istringstream words(line);
    std::string tag;
    words >> tag;
    std::vector<Real> numbers = numbersOf(words);
    if (tag.rfind("VERTEX", 0) == 0) {
      vertices[long(numbers[0])].assign(numbers.begin() + 1, numbers.end());
    } else if (tag.rfind("EDGE", 0) == 0) {
      edges.emplace_back(tag, std::move(numbers));
    }
  }
  Real chi2 = 0;
  for (const auto& [tag, n] : edges) {
    const Real* a = vertices.at(long(n[0])).data();
    const Real* b = vertices.at(long(n[1])).data();
    Real e[6];
    if (tag == "EDGE_SE3:QUAT") {
      const RigidMotion a_T_b = between(fromQuaternion(a), fromQuaternion(b));
      quaternionChart(between(fromQuaternion(&n[2]), a_T_b), e);
      chi2 += weighted(e, &n[9], 6);
    } else if (tag == "EDGE_SE2") {
      planarError(&n[2], a, b, e);
      chi2 += weighted(e, &n[5], 3);
    } else {
      sightError(&n[2], a, b, e);
      chi2 += weighted(e, &n[4], 2);
    }
  }
  return chi2;
}

struct FileCase {
  const char* name;
  double published;  ///< g2o's initial chi2, 0 = none known
};

class InitialChi2 : public ::testing::TestWithParam<FileCase> {};

TEST_P(InitialChi2, EqualsARecomputationInLongDouble) {
  const std::string path = std::string("pose_graphs/") + GetParam().name + ".g2o";
  GRAFT_REQUIRE_DATA(path);
  Engine engine;
  const LoadedGraph loaded = testing::loadData(path, engine.registry());
  const double chi2 = evaluateChi2(loaded.graph, loaded.values);
  const auto expected = double(recomputedChi2(testing::dataPath(path)));
  EXPECT_NEAR(chi2 / expected, 1, 1e-12);
  if (GetParam().published > 0) {
    EXPECT_NEAR(chi2 / GetParam().published, 1, 1e-7);
  }
}

INSTANTIATE_TEST_SUITE_P(, InitialChi2,
                         ::testing::Values(FileCase{"sphere2500", 2547810.8488},
                                           FileCase{"parking-garage", 16720.0183},
                                           FileCase{"intel", 551.735731},
                                           FileCase{"MIT", 4414181662.5246}, FileCase{"torus3D", 0},
                                           FileCase{"smallGrid3D", 0}, FileCase{"M3500", 0},
                                           FileCase{"dlr", 0}),
                         [](const auto& info) {
                           std::string name = info.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace graft
