// SPDX-License-Identifier: BSD-3-Clause
// A robot drives along a square and comes back 10 cm off: build the graph,
// solve it, read the corrected poses.
#include <cmath>
#include <cstdio>

#include "core/graph/factor_graph.hpp"
#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"

int main() {
  graft::Engine engine;  // finds the installed plugins
  graft::FactorGraph graph(engine.registry());

  const double turn = std::acos(0.0);  // 90 degrees, rad
  for (int i = 0; i < 4; ++i) graph.addVertex("VERTEX_SE2", i);
  graph.fix(0);
  for (int i = 0; i < 3; ++i) graph.addEdge("EDGE_SE2", {i, i + 1}, {1, 0, turn});
  graph.addEdge("EDGE_SE2", {3, 0}, {1.1, 0, turn});

  const graft::Summary summary = graft::optimize(graph.graph(), graph.values(), engine.registry());
  std::printf("%s, chi2 %.6f\n", graft::statusName(summary.status), summary.chi2_final);
  for (int i = 0; i < 4; ++i) {
    const std::vector<double> pose = graph.estimate(i);
    std::printf("%d: x %.4f y %.4f theta %.4f\n", i, pose[0], pose[1], pose[2]);
  }
  return summary.usable() ? 0 : 1;
}
