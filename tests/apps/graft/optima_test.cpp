// SPDX-License-Identifier: BSD-3-Clause
// The standard graphs, with default options, end at the best known cost.
#include <gtest/gtest.h>

#include <algorithm>

#include <nlohmann/json.hpp>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

struct Optimum {
  const char* name;
  double chi2;  ///< the best that g2o and Ceres found from the file's estimates
};

class Optima : public ::testing::TestWithParam<Optimum> {};

TEST_P(Optima, AreReachedWithDefaultOptions) {
  const std::string path = std::string("pose_graphs/") + GetParam().name + ".g2o";
  GRAFT_REQUIRE_DATA(path);
  const testing::CommandResult result = testing::runCommand(
      testing::binaryDirectory() + "/bin/graft optimize " + testing::dataPath(path) + " --json -");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto document = nlohmann::json::parse(result.out);
  EXPECT_EQ(document["status"], "converged");
  EXPECT_LE(document["chi2_final"].get<double>(), GetParam().chi2 * (1 + 1e-6));
}

INSTANTIATE_TEST_SUITE_P(, Optima,
                         ::testing::Values(Optimum{"sphere2500", 727.1495},
                                           Optimum{"parking-garage", 1.238691},
                                           Optimum{"smallGrid3D", 458.15378},
                                           Optimum{"intel", 45.00470}, Optimum{"MIT", 41.16327},
                                           Optimum{"torus3D", 14574.75},
                                           Optimum{"M3500", 137.91295}, Optimum{"dlr", 56860.353},
                                           Optimum{"CSAIL", 40.55513}),
                         [](const auto& info) {
                           std::string name = info.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace graft
