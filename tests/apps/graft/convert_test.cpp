// SPDX-License-Identifier: BSD-3-Clause
// graft convert: TORO there and back, tracks out.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

class Convert : public ::testing::Test {
 protected:
  testing::CommandResult run(const std::string& text, const std::string& name,
                             const std::string& format) {
    const std::string in = testing::writeTestFile(folder_, name, text);
    return testing::runCommand(testing::binaryDirectory() + "/bin/graft convert " + in +
                               " -o - --to " + format);
  }
  std::string folder_ = testing::makeTemporaryDirectory();
};

TEST_F(Convert, PlanarGraphsGoToToroAndBackBitByBit) {
  const std::string g2o =
      "VERTEX_SE2 0 0.1 -2e-17 3\nVERTEX_SE2 5 1 2 0.3333333333333333\n"
      "EDGE_SE2 0 5 0.5 -1 0.25 1.5 0.2 0.3 8 0.5 20\n";
  const testing::CommandResult toro = run(g2o, "in.g2o", "toro");
  EXPECT_EQ(toro.out,
            "VERTEX2 0 0.1 -2e-17 3\nVERTEX2 5 1 2 0.3333333333333333\n"
            "EDGE2 0 5 0.5 -1 0.25 1.5 0.2 8 20 0.3 0.5\n");
  EXPECT_EQ(toro.err, "");
  EXPECT_EQ(run(toro.out, "in.graph", "g2o").out, g2o);
}

TEST_F(Convert, GraphsInSpaceGoToToroAndBackToRounding) {
  const std::string g2o =
      "VERTEX_SE3:QUAT 0 1 2 3 0.1 -0.5 0.5 0.7\nVERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\n"
      "EDGE_SE3:QUAT 0 1 1 2 3 -0.4 0.1 0.7 0.6 10 1 0 1 2 0 11 0 1 0 2 12 0 1 1 13 2 0 14 1 15\n";
  const std::string canonical = run(g2o, "in.g2o", "g2o").out;
  const std::string back = run(run(g2o, "in.g2o", "toro").out, "in.graph", "g2o").out;
  std::istringstream a(canonical), b(back);
  std::string x, y;
  int numbers = 0;
  while (a >> x && b >> y) {
    if (x[0] == 'V' || x[0] == 'E') {
      EXPECT_EQ(x, y);
    } else {
      EXPECT_NEAR(std::stod(x), std::stod(y), 1e-12);
      ++numbers;
    }
  }
  EXPECT_EQ(numbers, 2 * 8 + 2 + 7 + 21);
}

TEST_F(Convert, WhatToroHasNotIsCounted) {
  const testing::CommandResult result =
      run("VERTEX_SE2 0 0 0 0\nFIX 0\nVERTEX_XY 1 0 0\nVERTEX_XY 2 0 0\n"
          "EDGE_SE2_XY 0 1 1 1 1 0 1\nEDGE_SE2_XY 0 2 1 1 1 0 1\n",
          "in.g2o", "toro");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, "VERTEX2 0 0 0 0\n");
  EXPECT_NE(result.err.find("2 EDGE_SE2_XY left out: toro has nothing like it"), std::string::npos);
  EXPECT_NE(result.err.find("2 VERTEX_XY left out"), std::string::npos);
  EXPECT_NE(result.err.find("1 FIX left out"), std::string::npos);
  const testing::CommandResult nothing = run("VERTEX_XY 1 0 0\n", "in.g2o", "toro");
  EXPECT_EQ(nothing.exit_code, 4);
  EXPECT_NE(nothing.err.find("nothing in it can be written as toro"), std::string::npos);
}

TEST_F(Convert, TracksOfAnyPoses) {
  const std::string text =
      "VERTEX_SE3:QUAT 7 1 2 3 0 0 0 1\nVERTEX_SE2 3 4 5 0\nVERTEX_XY 9 0 0\n"
      "VERTEX3 8 1 0 0 0 0 1.5707963267948966\n";
  const testing::CommandResult tum = run(text, "in.g2o", "tum");
  EXPECT_EQ(tum.out.substr(0, tum.out.find("8 ")), "3 4 5 0 0 0 0 1\n7 1 2 3 0 0 0 1\n");
  EXPECT_NE(tum.err.find("1 VERTEX_XY left out: tum has nothing like it"), std::string::npos);
  std::istringstream kitti(run(text, "in.g2o", "kitti").out);
  const double expected[3][12] = {{1, 0, 0, 4, 0, 1, 0, 5, 0, 0, 1, 0},
                                  {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3},
                                  {0, -1, 0, 1, 1, 0, 0, 0, 0, 0, 1, 0}};
  for (const auto& row : expected) {
    for (const double entry : row) {
      double read = 9;
      kitti >> read;
      EXPECT_NEAR(read, entry, 1e-15);
    }
  }
  std::string rest;
  EXPECT_FALSE(kitti >> rest);
}

}  // namespace
}  // namespace graft
