// SPDX-License-Identifier: BSD-3-Clause
// graft check: what it says about a graph that is read but not well.
#include <gtest/gtest.h>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

class Check : public ::testing::Test {
 protected:
  testing::CommandResult run(const std::string& command, const std::string& text) {
    const std::string in = testing::writeTestFile(folder_, "in.g2o", text);
    return testing::runCommand(testing::binaryDirectory() + "/bin/graft " + command + " " + in);
  }
  static void expectSaid(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in\n" << text;
  }
  std::string folder_ = testing::makeTemporaryDirectory();
};

TEST_F(Check, NamesComponentsAndWhatEdgesLeaveOpen) {
  const testing::CommandResult result =
      run("check",
          "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_XY 2 3 0\nVERTEX_XY 9 5 5\n"
          "VERTEX_SE2 10 0 0 0\nVERTEX_SE2 11 1 0 0\n"
          "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_BEARING_SE2_XY 0 2 0 5\n"
          "EDGE_SE2 10 11 1 0 0 1 0 0 1 0 0\n");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  expectSaid(result.out, "3 connected components");
  expectSaid(result.out, "component of vertex 0 (3 vertices) is not anchored");
  expectSaid(result.out, "component of vertex 10 (2 vertices) is not anchored");
  expectSaid(result.out, "1 vertices without edges");
  expectSaid(result.err, "vertex 9 has no edge");
  expectSaid(result.out, "2 directions that no edge determines");
  // The bearing from 0 sees 2 along x: x is open; so is the heading of 11.
  expectSaid(result.out, "VERTEX_XY 2 is free along (1 x)");
  expectSaid(result.out, "VERTEX_SE2 11 is free along (1 theta)");
  expectSaid(result.out, "2 Jacobians of EDGE_SE2 agree");
  expectSaid(result.out, "chi2 at the estimates of the file: 0");
}

TEST_F(Check, OptimizeNamesWhatABearingAloneLeavesOpen) {
  const std::string text =
      "VERTEX_SE2 0 0 0 0\nFIX 0\nVERTEX_XY 2 3 0\nEDGE_BEARING_SE2_XY 0 2 0.1 5\n";
  const testing::CommandResult damped = run("optimize", text);
  EXPECT_EQ(damped.exit_code, 0) << damped.err;
  expectSaid(damped.err, "note: no edge determines this: VERTEX_XY 2 is free along (");
  const testing::CommandResult undamped = run("optimize --algorithm gn --initial-guess file", text);
  EXPECT_EQ(undamped.exit_code, 4);
  expectSaid(undamped.err, "note: no edge determines this: VERTEX_XY 2 is free along (1 x)");
  expectSaid(undamped.err, "(VERTEX_XY 2 is free along (1 x))");
}

TEST_F(Check, NamesOddWeights) {
  std::string text = "VERTEX_XY 0 0 0\nFIX 0\n";
  for (int i = 1; i < 8; ++i) {
    text += "VERTEX_XY " + std::to_string(i) + " 0 0\nEDGE_POINTXY 0 " + std::to_string(i) +
            " 0 0 " + (i == 4 ? "1e9" : "100") + " 0 100\n";
  }
  const testing::CommandResult result = run("check", text);
  expectSaid(result.out, "1 edges whose weight is off the median");
  expectSaid(result.out, "EDGE_POINTXY 0 4 (line 10): 1e+07 times the median");
  expectSaid(result.out, "0 directions that no edge determines");
}

TEST_F(Check, MeanRotationsShowQuaternionsWithWInFront) {
  const auto graph = [](const char* first, const char* second) {
    const std::string weight = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
    return "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\nFIX 0\n"
           "EDGE_SE3:QUAT 0 1 1 0 0 " +
           (first + weight) + "EDGE_SE3:QUAT 0 1 1 0 0 " + (second + weight);
  };
  // Turns by 0 and 90 degrees, and what they look like to who reads w last.
  const std::string right = run("check", graph("0 0 0 1", "0 0 0.70710678 0.70710678")).out;
  expectSaid(right, "      45 degrees is the mean rotation of EDGE_SE3:QUAT\n");
  const std::string wrong = run("check", graph("1 0 0 0", "0.70710678 0 0 0.70710678")).out;
  expectSaid(wrong,
             "     135 degrees is the mean rotation of EDGE_SE3:QUAT (does the file give qw first? "
             "expected qx qy qz qw)\n");
}

TEST_F(Check, IndefiniteInformationIsRefusedByNameAndSolvedIfProjected) {
  const std::string text =
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_SE2 2 2 0 0\n"
      "EDGE_SE2 0 1 1 0 0 1 2 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 -3 0 1\n"
      "EDGE_SE2 0 2 2 0.1 0 1 0 0 1 0 1\nEDGE_SE2 1 2 2 0 0 0 0 0 0 0 0\n";
  for (const char* command : {"check", "optimize"}) {
    const testing::CommandResult refused = run(command, text);
    EXPECT_EQ(refused.exit_code, 3);
    expectSaid(refused.err,
               ":4: error: EDGE_SE2 0 1: the information matrix is not positive "
               "semidefinite, its smallest eigenvalue is -0.99999");
    expectSaid(refused.err,
               ":5: error: EDGE_SE2 1 2: the information matrix is not positive "
               "semidefinite, its smallest eigenvalue is -3");
    EXPECT_EQ(refused.err.find(":6: error"), std::string::npos);
    expectSaid(refused.err, ":7: warning: EDGE_SE2 1 2 has an information matrix of zeros");
    const testing::CommandResult projected =
        run(std::string(command) + " --information project", text);
    EXPECT_EQ(projected.exit_code, 0) << projected.err;
    expectSaid(projected.err, ":4: warning: EDGE_SE2 0 1: the information matrix is not positive");
  }
  const testing::CommandResult solved = run("optimize --information project --json -", text);
  expectSaid(solved.out, "\"status\": \"converged\"");
}

TEST_F(Check, FarFromUnitQuaternionsAreNamed) {
  const testing::CommandResult result =
      run("check", "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 0 0 0 0 0 0 1.05\n");
  EXPECT_EQ(result.exit_code, 0);
  expectSaid(result.err, ":2: warning: the quaternion has length 1.05, expected 1; normalised");
}

}  // namespace
}  // namespace graft
