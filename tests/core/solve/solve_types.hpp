// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <string>
#include <vector>

#include "core/graph/graph.hpp"
#include "core/types/registry.hpp"

namespace graft::testing {

/// A registry with the types of these tests:
///  vertices VERTEX_SE2, VERTEX_SE3:QUAT, TEST_POINT2 (x y);
///  TEST_BETWEEN2, TEST_BETWEEN3: relative poses, with propagate();
///  TEST_PRIOR: a point is at (x, y); TEST_DIFFERENCE: b - a = (x, y);
///  TEST_RANGE: distance of two points;
///  TEST_NEAREST: the point is at the nearest of three anchors (x y x y x y);
///  TEST_CHOICE: the same, and lists its choices;
///  TEST_BEYOND: a x + b y >= c (a b c), nothing where that holds;
///  TEST_BEYOND_SEEN: the same for a point less a pose's position, vertices pose, point;
///  TEST_LEASH: a point is where a pose is, vertices pose, point;
///  TEST_NAN: not finite once a point's x is above 5 (x y);
///  TEST_FORGETS: leaves its Jacobian unwritten;
///  TEST_WRONG: a Jacobian of the wrong sign;
///  TEST_CENTROID: dynamic, the mean of n points is at (x, y).
/// Kernel "cauchy"; solver "test_dense".
Registry& testRegistry();

/// A graph under construction, with its values.
struct TestGraph {
  Graph graph;
  Values values;

  VertexRef vertex(const char* tag, std::int64_t id, const std::vector<double>& estimate,
                   bool fixed = false);
  VertexRef point(std::int64_t id, double x, double y, bool fixed = false) {
    return vertex("TEST_POINT2", id, {x, y}, fixed);
  }
  void edge(const char* tag, const std::vector<std::int64_t>& ids,
            const std::vector<double>& measurement, const std::vector<double>& information = {},
            std::int64_t line = 0, std::int32_t kernel = -1);
  std::vector<double> at(std::int64_t id) const;
};

/// One line of a generated pose graph; lines may be added in any order.
struct PoseGraphPart {
  bool is_vertex;
  std::vector<std::int64_t> ids;
  std::vector<double> numbers;
};

/// A walk of `count` poses in space with loop closures; measurements are exact
/// plus Gaussian noise, estimates are the truth plus `disturbance`.
std::vector<PoseGraphPart> makePoseGraph(int count, double noise, double disturbance,
                                         std::uint64_t seed);
TestGraph assemble(const std::vector<PoseGraphPart>& parts);

}  // namespace graft::testing
