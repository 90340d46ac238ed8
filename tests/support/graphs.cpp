// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/graphs.hpp"

#include "tests/support/test_data.hpp"

namespace graft::testing {

LoadedGraph loadText(const std::string& text, Registry& registry, Diagnostics& diagnostics,
                     const LoadOptions& options, const std::string& name) {
  const std::string path = writeTestFile(makeTemporaryDirectory(), name, text);
  return loadGraph(path, registry, options, diagnostics);
}

LoadedGraph loadData(const std::string& relative, Registry& registry) {
  Diagnostics diagnostics;
  return loadGraph(dataPath(relative), registry, {}, diagnostics);
}

std::string cubeOfPoses(int side) {
  std::string text;
  const auto id = [&](int x, int y, int z) { return std::to_string((x * side + y) * side + z); };
  std::string edges;
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      for (int z = 0; z < side; ++z) {
        text += "VERTEX_SE3:QUAT " + id(x, y, z) + " " + std::to_string(x) + " " +
                std::to_string(y) + " " + std::to_string(z) + " 0 0 0 1\n";
        const int next[3][3] = {{x + 1, y, z}, {x, y + 1, z}, {x, y, z + 1}};
        for (int axis = 0; axis < 3; ++axis) {
          if (next[axis][axis] == side) continue;
          edges += "EDGE_SE3:QUAT " + id(x, y, z) + " " +
                   id(next[axis][0], next[axis][1], next[axis][2]) + " " +
                   (axis == 0   ? "1.1 0 0"
                    : axis == 1 ? "0 1.1 0"
                                : "0 0 1.1") +
                   " 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
        }
      }
    }
  }
  return text + "FIX 0\n" + edges;
}

}  // namespace graft::testing
