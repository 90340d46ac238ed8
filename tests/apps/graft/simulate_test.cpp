// SPDX-License-Identifier: BSD-3-Clause
// Simulated graphs are what they claim: seeded, consistent with their noise.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/graft/simulated_world.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

class Simulate : public ::testing::TestWithParam<const char*> {
 protected:
  std::string make(const std::string& options) {
    const testing::CommandResult result = testing::runCommand(
        testing::binaryDirectory() + "/bin/graft simulate " + GetParam() + " -o - " + options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  }
};

TEST_P(Simulate, TheSeedDecides) {
  EXPECT_EQ(make("--size 6 --seed 4"), make("--size 6 --seed 4"));
  EXPECT_NE(make("--size 6 --seed 4"), make("--size 6 --seed 5"));
}

/// At the optimum chi2 has a chi-squared distribution whose degrees of freedom
/// are the measured numbers minus the free ones.
TEST_P(Simulate, ResidualsHaveTheStatedNoise) {
  const std::string size = std::string(GetParam()) == "manhattan" ? "600" : "9";
  const std::string path =
      testing::writeTestFile(testing::makeTemporaryDirectory(), "g.g2o", make("--size " + size));
  const testing::CommandResult result =
      testing::runCommand(testing::binaryDirectory() + "/bin/graft optimize " + path + " --json -");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto document = nlohmann::json::parse(result.out);
  const int dim = std::string(GetParam()) == "manhattan" ? 3 : 6;
  const double freedom =
      dim * (document["edges"].get<double>() - document["vertices"].get<double>() + 1);
  ASSERT_GT(freedom, 100);
  EXPECT_NEAR(document["chi2_final"].get<double>(), freedom, 5 * std::sqrt(2 * freedom));
}

/// With much noise, default options end where a solve ends that begins at the truth.
TEST_P(Simulate, DefaultOptionsFindTheOptimumNearTheTruth) {
  const bool planar = std::string(GetParam()) == "manhattan";
  const std::string noise = planar ? "--sigma-t 0.2 --sigma-r 0.1" : "--sigma-t 0.3 --sigma-r 0.2";
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string truth = folder + "/truth.txt";
  const std::string graph = make("--size " + std::string(planar ? "1500" : "10") + " --seed 8 " +
                                 noise + " --truth " + truth);
  // The edges as they are, the vertices at their true places.
  std::istringstream lines(graph);
  std::string at_truth = testing::readTestFile(truth);
  ASSERT_EQ(at_truth.find("VERTEX"), 0u);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("VERTEX", 0) != 0) at_truth += line + "\n";
  }
  const auto solve = [&](const std::string& text, const char* name, const std::string& options) {
    const std::string path = testing::writeTestFile(folder, name, text);
    const testing::CommandResult result = testing::runCommand(
        testing::binaryDirectory() + "/bin/graft optimize " + path + " --json - " + options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  };
  const auto found = solve(graph, "graph.g2o", "");
  const auto reference = solve(at_truth, "truth.g2o", "--initial-guess file");
  EXPECT_EQ(found["status"], "converged");
  EXPECT_NE(found["chi2_initial"], reference["chi2_initial"]);
  EXPECT_LE(found["chi2_final"].get<double>(), reference["chi2_final"].get<double>() * (1 + 1e-7));
}

INSTANTIATE_TEST_SUITE_P(, Simulate, ::testing::Values("sphere", "torus", "grid", "manhattan"),
                         [](const auto& info) { return std::string(info.param); });

TEST(NormalDeviates, HaveMomentsOfTheNormalDistribution) {
  NormalDeviates random(9);
  constexpr int kCount = 200000;
  double moments[4] = {};
  for (int i = 0; i < kCount; ++i) {
    const double x = random.next();
    for (int k = 0; k < 4; ++k) moments[k] += std::pow(x, k + 1) / kCount;
  }
  EXPECT_NEAR(moments[0], 0, 0.01);
  EXPECT_NEAR(moments[1], 1, 0.02);
  EXPECT_NEAR(moments[2], 0, 0.05);
  EXPECT_NEAR(moments[3], 3, 0.1);
}

TEST(SimulatedWorld, SuccessiveGridPosesAreNeighbours) {
  const SimulatedWorld world = gridWorld(4);
  ASSERT_EQ(world.space.size(), 64u);
  EXPECT_EQ(world.edges.size(), 3u * 4 * 4 * 3);
  for (const auto& [a, b] : world.edges) {
    EXPECT_NEAR(
        (world.space[std::size_t(a)].translation - world.space[std::size_t(b)].translation).norm(),
        1, 1e-12);
  }
}

}  // namespace
}  // namespace graft
