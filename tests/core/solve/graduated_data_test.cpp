// SPDX-License-Identifier: BSD-3-Clause
// Graduation on public graphs to which false closures are added: the optimum is that of
// the file without them, solved by itself.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"
#include "tests/support/graphs.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

class GraduatedData : public ::testing::Test {
 protected:
  LoadedGraph load(const std::string& path) { return testing::loadData(path, engine_.registry()); }

  /// Adds false closures until `share` of all closures are false: between any two vertices,
  /// with measurements spread as far as the file's longest; line = -1.
  static std::size_t addFalse(Graph& graph, double share, std::uint64_t seed) {
    const EdgeBlock block = graph.edgeBlocks().front();
    const std::vector<VertexRef> vertices = graph.verticesById();
    std::size_t closures = 0;
    double longest = 0;
    for (std::size_t e = 0; e < block.size(); ++e) {
      const VertexRef* v = &block.vertices[std::size_t(block.vertex_begin[e])];
      closures += std::abs(graph.id(v[0]) - graph.id(v[1])) == 1 ? 0 : 1;
      longest =
          std::max(longest, std::abs(block.measurements[std::size_t(block.measurement_begin[e])]));
    }
    const auto count = std::size_t(std::lround(double(closures) * share / (1 - share)));
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> u(-1, 1);
    for (std::size_t i = 0; i < count;) {
      const VertexRef a = vertices[random() % vertices.size()];
      const VertexRef b = vertices[random() % vertices.size()];
      if (std::abs(graph.id(a) - graph.id(b)) < 10) continue;
      const std::size_t like = random() % block.size();
      Graph::EdgeSpec spec;
      spec.type = block.type;
      spec.vertices = {a, b};
      const int dim = block.type->measurement_dim;
      for (int k = 0; k < dim; ++k) {
        const bool translation = k < (dim == 3 ? 2 : 3);
        spec.measurement.push_back((translation ? std::max(10.0, longest) : 3) * u(random));
      }
      spec.information.assign(block.information.begin() + block.information_begin[like],
                              block.information.begin() + block.information_begin[like + 1]);
      spec.line = -1;
      graph.addEdge(spec);
      ++i;
    }
    return count;
  }

  /// The largest difference of translations.
  static double difference(const Values& a, const Values& b) {
    double largest = 0;
    const std::size_t dim = a.dim(0);
    for (std::size_t i = 0; i < a.array(0).size(); ++i) {
      if (i % dim >= (dim == 3 ? 2 : 3)) continue;
      largest = std::max(largest, std::abs(a.array(0)[i] - b.array(0)[i]));
    }
    return largest;
  }

  Engine engine_;
};

class GraduatedSmallData : public GraduatedData,
                           public ::testing::WithParamInterface<const char*> {};

TEST_P(GraduatedSmallData, FindsTheOptimumOfTheFileWithoutFalseClosures) {
  const std::string path = "pose_graphs/" + std::string(GetParam()) + ".g2o";
  GRAFT_REQUIRE_DATA(path);
  SolveOptions exact;
  exact.function_tolerance = 1e-14;
  LoadedGraph clean = load(path);
  optimize(clean.graph, clean.values, engine_.registry(), exact);
  for (const std::uint64_t seed : {1, 2}) {
    LoadedGraph loaded = load(path);
    const std::size_t false_count = addFalse(loaded.graph, 0.3, seed);
    SolveOptions options = exact;
    options.graduation.kind = RobustEstimation::kTruncatedLeastSquares;
    options.graduation.inlier_probability = 0.9999;
    const Summary summary = optimize(loaded.graph, loaded.values, engine_.registry(), options);
    EXPECT_EQ(summary.status, Status::kConverged);
    std::size_t false_off = 0;
    for (const SwitchedOff& off : summary.graduation.off) false_off += off.line == -1 ? 1 : 0;
    EXPECT_EQ(false_off, false_count) << seed;
    EXPECT_EQ(summary.graduation.off.size(), false_count) << seed;
    EXPECT_LT(difference(loaded.values, clean.values), 1e-4) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(, GraduatedSmallData,
                         ::testing::Values("smallGrid3D", "MIT", "CSAIL", "intel"),
                         [](const auto& info) { return std::string(info.param); });

struct LargeCase {
  const char* name;
  std::uint64_t seed;
};

class GraduatedLargeData : public GraduatedData, public ::testing::WithParamInterface<LargeCase> {};

/// Among hundreds of false closures one may be true enough: then the cost is lower with it.
TEST_P(GraduatedLargeData, CostsNoMoreThanTheFileWithoutFalseClosures) {
  const std::string path = "pose_graphs/" + std::string(GetParam().name) + ".g2o";
  GRAFT_REQUIRE_DATA(path);
  LoadedGraph clean = load(path);
  const double clean_chi2 = optimize(clean.graph, clean.values, engine_.registry(), {}).chi2_final;
  LoadedGraph loaded = load(path);
  const std::size_t false_count = addFalse(loaded.graph, 0.3, GetParam().seed);
  SolveOptions options;
  options.graduation.kind = RobustEstimation::kTruncatedLeastSquares;
  const Summary summary = optimize(loaded.graph, loaded.values, engine_.registry(), options);
  ASSERT_EQ(summary.status, Status::kConverged);
  ASSERT_FALSE(summary.graduation.off.empty());
  // All information matrices have full rank, so that thresholds are the same.
  const double threshold = summary.graduation.off.front().threshold;
  std::size_t false_off = 0;
  double cost = summary.chi2_final;
  for (const SwitchedOff& off : summary.graduation.off) {
    EXPECT_GT(off.square, off.threshold);
    EXPECT_EQ(off.threshold, threshold);
    cost += off.threshold;
    false_off += off.line == -1 ? 1 : 0;
  }
  EXPECT_LE(cost, (clean_chi2 + double(false_count) * threshold) * (1 + 1e-9));
  EXPECT_LE(false_count - false_off, 1U);
  if (false_off == false_count && summary.graduation.off.size() == false_count) {
    EXPECT_LT(difference(loaded.values, clean.values), 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(, GraduatedLargeData,
                         ::testing::Values(LargeCase{"M3500", 1}, LargeCase{"M3500", 2},
                                           LargeCase{"M3500", 3}, LargeCase{"sphere2500", 1}),
                         [](const auto& info) {
                           return info.param.name + std::string("_") +
                                  std::to_string(info.param.seed);
                         });

}  // namespace
}  // namespace graft
