// SPDX-License-Identifier: BSD-3-Clause
// A plugin outside graft's tree: water levels, a vertex type of its own, a
// ternary edge and an edge over any number of vertices.
#include "core/types/plugin.hpp"

/// One number, m.
template <class T = double>
struct Level {
  static constexpr int kAmbientDim = 1;
  static constexpr int kTangentDim = 1;
  static constexpr const char* kFields = "height";
  T height = T(0);

  static Level fromArray(const double* p) {
    Level level;
    level.height = T(p[0]);
    return level;
  }
  void toArray(double* p) const { p[0] = graft::valueOf(height); }
  static const char* normalize(double*) { return nullptr; }
  Level plus(const graft::Vec<T, 1>& d) const {
    Level level;
    level.height = height + d[0];
    return level;
  }
  graft::Vec<T, 1> minus(const Level& o) const { return graft::Vec<T, 1>(height - o.height); }
  void renormalize() {}
};

template <>
struct graft::VertexTag<Level> {
  static constexpr const char* kTag = "VERTEX_LEVEL";
  static constexpr const char* kDoc = "height of a water level, m";
};

struct LevelPrior : graft::Edge<LevelPrior, 1, Level>, graft::Measured<graft::Numbers<1>> {
  static constexpr auto tag = "LEVEL_PRIOR";
  static constexpr auto doc = "measured height";
  template <class T>
  graft::Vec<T, 1> error(const Level<T>& a) const {
    return graft::Vec<T, 1>(a.height - measurement.values[0]);
  }
};

struct LevelBetween : graft::Edge<LevelBetween, 1, Level, Level, Level> {
  static constexpr auto tag = "LEVEL_BETWEEN";
  static constexpr auto doc = "the second lies in the middle of the first and the third";
  template <class T>
  graft::Vec<T, 1> error(const Level<T>& a, const Level<T>& b, const Level<T>& c) const {
    return graft::Vec<T, 1>(b.height - (a.height + c.height) * 0.5);
  }
};

struct LevelSum : graft::DynamicEdge<LevelSum, Level> {
  static constexpr auto tag = "LEVEL_SUM";
  static constexpr auto doc = "measured sum of any number of levels";
  static bool shape(int, int& error_dim, int& measurement_dim) {
    error_dim = measurement_dim = 1;
    return true;
  }
  template <class T>
  void error(const std::vector<Level<T>>& levels, const std::vector<double>& measurement,
             graft::Vec<T, Eigen::Dynamic>& e) const {
    e[0] = T(-measurement[0]);
    for (const Level<T>& level : levels) e[0] += level.height;
  }
};

GRAFT_PLUGIN(levels, registry) {
  registry.addVertex<Level>();
  registry.add<LevelPrior>();
  registry.add<LevelBetween>();
  registry.add<LevelSum>();
}
