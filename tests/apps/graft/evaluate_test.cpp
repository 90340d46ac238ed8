// SPDX-License-Identifier: BSD-3-Clause
// graft evaluate: chi2 by tag and the worst edges, in closed form.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

// e = (1, 0) with Omega = diag(4, 1), and (0, 2) with Omega = diag(1, 9).
const std::string kGraph =
    "VERTEX_XY 0 0 0\nFIX 0\nVERTEX_XY 1 2 1\nVERTEX_XY 2 5 5\n"
    "EDGE_POINTXY 0 1 1 1 4 0 1\nEDGE_POINTXY 0 2 5 3 1 0 9\n";

testing::CommandResult evaluate(const std::string& text, const std::string& options) {
  const std::string in = testing::writeTestFile(testing::makeTemporaryDirectory(), "in.g2o", text);
  return testing::runCommand(testing::binaryDirectory() + "/bin/graft evaluate " + in + " " +
                             options);
}

TEST(Evaluate, SaysChi2ByTagAndTheWorstEdges) {
  const testing::CommandResult result = evaluate(kGraph, "--json - --worst 1");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto document = nlohmann::json::parse(result.out);
  EXPECT_EQ(document["chi2"], 40.0);
  // dF/dx = 2 Omega e: (8, 0) and (0, 36).
  EXPECT_EQ(document["gradient_max"], 36.0);
  EXPECT_EQ(document["by_tag"]["EDGE_POINTXY"]["edges"], 2);
  EXPECT_EQ(document["by_tag"]["EDGE_POINTXY"]["chi2"], 40.0);
  ASSERT_EQ(document["worst"].size(), 1u);
  EXPECT_EQ(document["worst"][0]["vertices"], (std::vector<int>{0, 2}));
  EXPECT_EQ(document["worst"][0]["line"], 6);
  EXPECT_EQ(document["worst"][0]["chi2"], 36.0);
  EXPECT_EQ(document["worst"][0]["error"], (std::vector<double>{0, 2}));
}

TEST(Evaluate, WritesALinePerEdge) {
  EXPECT_EQ(evaluate(kGraph, "--residuals -").out,
            "tag,vertices,line,chi2,weight,error,whitened\n"
            "EDGE_POINTXY,0 1,5,4,1,1 0,2 0\nEDGE_POINTXY,0 2,6,36,1,0 2,0 6\n");
}

TEST(Evaluate, RefusesWhatCannotBeEvaluated) {
  EXPECT_EQ(evaluate("EDGE_SE2 0 1 2 0 0 1 0 0 1 0 1\n", "").exit_code, 4);
  EXPECT_EQ(evaluate(kGraph, "--json - --residuals -").exit_code, 2);
  EXPECT_EQ(evaluate(kGraph, "--worst -1").exit_code, 2);
  EXPECT_EQ(evaluate(kGraph, "--json /nonexistent/x").exit_code, 5);
  EXPECT_EQ(evaluate(kGraph + "EDGE_POINTXY 0 9 5 3 1 0 9\n", "").exit_code, 3);
}

}  // namespace
}  // namespace graft
