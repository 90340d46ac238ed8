// SPDX-License-Identifier: BSD-3-Clause
#include "tests/plugins/edge_case.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/io/g2o_writer.hpp"
#include "core/io/graph_loader.hpp"
#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"
#include "tests/support/edge_check.hpp"
#include "tests/support/graphs.hpp"
#include "tests/support/test_data.hpp"

namespace graft::testing {

PlanePose planePose(const Numbers& n) { return {n[0], n[1], n[2]}; }
PlanePose operator*(const PlanePose& a, const PlanePose& b) {
  const Numbers t = transformed(a, b.x, b.y);
  return {t[0], t[1], a.t + b.t};
}
PlanePose inverse(const PlanePose& a) {
  return {-std::cos(a.t) * a.x - std::sin(a.t) * a.y, std::sin(a.t) * a.x - std::cos(a.t) * a.y,
          -a.t};
}
Numbers transformed(const PlanePose& a, Real x, Real y) {
  return {a.x + std::cos(a.t) * x - std::sin(a.t) * y, a.y + std::sin(a.t) * x + std::cos(a.t) * y};
}
Real wrapped(Real angle) { return std::atan2(std::sin(angle), std::cos(angle)); }

SpacePose spacePose(const Numbers& n) {
  const Real norm = std::sqrt(n[3] * n[3] + n[4] * n[4] + n[5] * n[5] + n[6] * n[6]);
  const Real x = n[3] / norm, y = n[4] / norm, z = n[5] / norm, w = n[6] / norm;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
           {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
           {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}},
          {n[0], n[1], n[2]}};
}

SpacePose eulerPose(const Numbers& n) {
  const Real cr = std::cos(n[3]), sr = std::sin(n[3]), cp = std::cos(n[4]), sp = std::sin(n[4]);
  const Real cy = std::cos(n[5]), sy = std::sin(n[5]);
  return {{{cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr},
           {sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr},
           {-sp, cp * sr, cp * cr}},
          {n[0], n[1], n[2]}};
}

SpacePose operator*(const SpacePose& a, const SpacePose& b) {
  SpacePose m{};
  const Numbers t = transformed(a, {b.t[0], b.t[1], b.t[2]});
  for (int i = 0; i < 3; ++i) {
    m.t[i] = t[std::size_t(i)];
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 3; ++j) m.r[i][j] += a.r[i][k] * b.r[k][j];
    }
  }
  return m;
}

SpacePose inverse(const SpacePose& a) {
  SpacePose m{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      m.r[i][j] = a.r[j][i];
      m.t[i] -= a.r[j][i] * a.t[j];
    }
  }
  return m;
}

Numbers transformed(const SpacePose& a, const Numbers& p) {
  Numbers q(3);
  for (std::size_t i = 0; i < 3; ++i) {
    q[i] = a.t[i] + a.r[i][0] * p[0] + a.r[i][1] * p[1] + a.r[i][2] * p[2];
  }
  return q;
}

Numbers quaternionOf(const Real r[3][3]) {
  Numbers q(4);
  const Real trace = r[0][0] + r[1][1] + r[2][2];
  if (trace > 0) {
    q[3] = std::sqrt(1 + trace) / 2;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      q[std::size_t(i)] = (r[k][j] - r[j][k]) / (4 * q[3]);
    }
    return q;
  }
  int i = r[1][1] > r[0][0] ? 1 : 0;
  if (r[2][2] > r[i][i]) i = 2;
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  const Real largest = std::sqrt(1 + r[i][i] - r[j][j] - r[k][k]) / 2;
  q[std::size_t(i)] = largest;
  q[std::size_t(j)] = (r[i][j] + r[j][i]) / (4 * largest);
  q[std::size_t(k)] = (r[i][k] + r[k][i]) / (4 * largest);
  q[3] = (r[k][j] - r[j][k]) / (4 * largest);
  return q;
}

Numbers quaternionChart(const SpacePose& m) {
  const Numbers q = quaternionOf(m.r);
  const Real sign = q[3] < 0 ? -1 : 1;
  return {m.t[0], m.t[1], m.t[2], sign * q[0], sign * q[1], sign * q[2]};
}

Numbers minus(const Numbers& a, const Numbers& b) {
  Numbers d(a);
  for (std::size_t i = 0; i < d.size(); ++i) d[i] -= b[i];
  return d;
}

namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Numbers by letter: x a coordinate, a an angle, p a pitch, e 0 or 1, i an id, c a
/// colour, f a focal length, q the next of a unit quaternion, n of a unit normal.
std::vector<double> randomNumbers(const std::string& letters, Random& random) {
  std::vector<double> numbers;
  std::vector<double> unit;
  for (const char letter : letters) {
    if (letter == 'q' || letter == 'n') {
      if (unit.empty()) {
        double sum = 0;
        std::normal_distribution<double> normal;
        for (int i = 0; i < (letter == 'q' ? 4 : 3); ++i) {
          unit.push_back(normal(random));
          sum += unit.back() * unit.back();
        }
        for (double& part : unit) part /= std::sqrt(sum);
      }
      numbers.push_back(unit.front());
      unit.erase(unit.begin());
    } else if (letter == 'e') {
      numbers.push_back(double(random() % 2));
    } else if (letter == 'i') {
      numbers.push_back(double(random() % 50) - 1);
    } else if (letter >= '0' && letter <= '9') {
      numbers.push_back(letter - '0');
    } else {
      const double extent = letter == 'a'   ? 3.1
                            : letter == 'p' ? 1.4
                            : letter == 'c' ? 1
                            : letter == 'f' ? 2
                                            : 3;
      numbers.push_back(letter == 'f' ? uniform(random, 0.5, extent)
                                      : uniform(random, -extent, extent));
    }
  }
  return numbers;
}

std::string lettersOf(const std::string& tag) {
  if (tag == "VERTEX_SE2" || tag == "PARAMS_SE2OFFSET") return "xxa";
  if (tag == "VERTEX_XY") return "xx";
  if (tag == "VERTEX_TRACKXYZ") return "xxx";
  if (tag == "VERTEX_SE3:QUAT" || tag == "PARAMS_SE3OFFSET") return "xxxqqqq";
  if (tag == "PARAMS_CAMERACALIB") return "xxxqqqqffxx";
  if (tag == "VERTEX3") return "xxxapa";
  if (tag == "VERTEX_SEGMENT2D") return "xxxx";
  if (tag == "VERTEX_LINE2D") return "axii";
  if (tag == "VERTEX_PLANE") return "nnnxccc";
  if (tag == "VERTEX_LINE3D") return "xxxnnn";
  throw std::runtime_error("no numbers known for " + tag);
}

std::string lineOf(const std::string& tag, const std::string& ids,
                   const std::vector<double>& numbers) {
  std::string line = tag + ids;
  for (const double number : numbers) line += ' ' + formatDouble(number);
  return line + '\n';
}

LoadedGraph loadText(const std::string& text, Engine& engine) {
  Diagnostics diagnostics;
  return testing::loadText(text, engine.registry(), diagnostics);
}

Numbers wide(const std::vector<double>& numbers) { return {numbers.begin(), numbers.end()}; }

struct Sample {
  std::string text;
  std::vector<std::vector<double>> vertices;
  std::vector<std::vector<double>> resources;
  std::vector<double> measurement;
  std::vector<double> upper;
};

Sample makeSample(const EdgeCase& one, std::size_t error_dim, Random& random) {
  Sample sample;
  std::string ids;
  for (std::size_t k = 0; k < one.slots.size(); ++k) {
    sample.vertices.push_back(randomNumbers(lettersOf(one.slots[k]), random));
    if (one.slots[k] == "VERTEX_LINE3D") {
      std::vector<double>& x = sample.vertices.back();
      const double along = x[0] * x[3] + x[1] * x[4] + x[2] * x[5];
      for (std::size_t i = 0; i < 3; ++i) x[i] -= along * x[3 + i];
    }
    sample.text += lineOf(one.slots[k], ' ' + std::to_string(k + 10), sample.vertices.back());
    ids += ' ' + std::to_string(k + 10);
  }
  if (one.tag.find("LOTSOF") != std::string::npos) ids += " ||";
  for (std::size_t k = 0; k < one.resources.size(); ++k) {
    sample.resources.push_back(randomNumbers(lettersOf(one.resources[k]), random));
    // After the vertices, and the edge before both: order does not matter.
    sample.text += lineOf(one.resources[k], ' ' + std::to_string(k + 3), sample.resources.back());
    ids += ' ' + std::to_string(k + 3);
  }
  sample.measurement = randomNumbers(one.measurement, random);
  Eigen::MatrixXd root(error_dim, error_dim);
  for (Eigen::Index i = 0; i < root.size(); ++i) root.data()[i] = uniform(random, -1, 1);
  const Eigen::MatrixXd omega = root.transpose() * root;
  for (Eigen::Index r = 0; r < omega.rows(); ++r) {
    for (Eigen::Index c = r; c < omega.cols(); ++c) sample.upper.push_back(omega(r, c));
  }
  std::vector<double> payload = sample.measurement;
  payload.insert(payload.end(), sample.upper.begin(), sample.upper.end());
  sample.text = lineOf(one.tag, ids, payload) + sample.text;
  return sample;
}

Numbers errorOf(const decltype(EdgeCase::error)& error, const Sample& sample) {
  std::vector<Numbers> x;
  std::vector<Numbers> resources;
  for (const auto& numbers : sample.vertices) x.push_back(wide(numbers));
  for (const auto& numbers : sample.resources) resources.push_back(wide(numbers));
  return error(x, resources, wide(sample.measurement));
}

Real weighted(const Numbers& e, const std::vector<double>& upper) {
  Real sum = 0;
  std::size_t next = 0;
  for (std::size_t r = 0; r < e.size(); ++r) {
    for (std::size_t c = r; c < e.size(); ++c) {
      sum += (r == c ? 1 : 2) * e[r] * upper[next++] * e[c];
    }
  }
  return sum;
}

void checkJacobian(const LoadedGraph& loaded, const std::string& tag) {
  const EdgeBlock& block = loaded.graph.edgeBlocks()[0];
  ASSERT_EQ(tag, block.type->tag);
  EdgeUnderTest edge;
  edge.type = block.type;
  std::vector<std::vector<double>> x;
  for (const VertexRef v : block.vertices) {
    edge.slots.push_back(&loaded.graph.type(v));
    const double* numbers = loaded.values.at(v);
    x.emplace_back(numbers, numbers + loaded.graph.type(v).ambient_dim);
  }
  edge.measurement = block.measurements;
  for (const std::int32_t index : block.resources) {
    edge.resources.push_back(loaded.graph.resources()[std::size_t(index)].data.get());
  }
  const Eigen::MatrixXd exact = edge.jacobian(x);
  const Eigen::MatrixXd numeric = edge.numericJacobian(x);
  const double scale = 1 + numeric.lpNorm<Eigen::Infinity>();
  EXPECT_LT((exact - numeric).lpNorm<Eigen::Infinity>() / scale, 2e-6) << tag;
}

}  // namespace

void checkEdgeCase(const EdgeCase& one, unsigned seed) {
  SCOPED_TRACE(one.tag);
  Engine engine;
  Random random(seed);
  // The first sample only tells the dimension of the error.
  const std::size_t dim = errorOf(one.error, makeSample(one, 1, random)).size();
  int differentiated = 0;
  for (int i = 0; i < 40; ++i) {
    const Sample sample = makeSample(one, dim, random);
    const LoadedGraph loaded = loadText(sample.text, engine);
    const Numbers error = errorOf(one.error, sample);
    const Real expected = weighted(error, sample.upper);
    const double chi2 = evaluateChi2(loaded.graph, loaded.values);
    EXPECT_NEAR(chi2 / double(expected), 1, 1e-8) << sample.text;
    const std::string written = formatG2o(loaded.graph, loaded.values);
    const LoadedGraph again = loadText(written, engine);
    EXPECT_EQ(formatG2o(again.graph, again.values), written);
    EXPECT_NEAR(evaluateChi2(again.graph, again.values) / chi2, 1, 1e-12);
    if (!one.smooth(one.looked_at ? errorOf(one.looked_at, sample) : error)) continue;
    ++differentiated;
    checkJacobian(loaded, one.tag);
  }
  EXPECT_GT(differentiated, 8);
}

std::string messagesOf(const std::string& text) {
  Engine engine;
  try {
    loadText(text, engine);
  } catch (const Error& error) {
    return error.formatted();
  }
  return "loaded";
}

}  // namespace graft::testing
