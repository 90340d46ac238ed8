// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "core/io/g2o_writer.hpp"
#include "core/io/graph_loader.hpp"
#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"
#include "tests/support/graphs.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

class Toro : public ::testing::Test {
 protected:
  LoadedGraph loadText(const std::string& text, const std::string& name = "one.graph") {
    diagnostics_.clear();
    return testing::loadText(text, engine_.registry(), diagnostics_, {}, name);
  }
  std::string failure(const std::string& text) {
    try {
      loadText(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      return error.formatted();
    }
    return "loaded";
  }
  Engine engine_;
  Diagnostics diagnostics_;
};

TEST_F(Toro, PlanarInformationIsReordered) {
  // I = [1 2 3; 2 8 5; 3 5 20], TORO's order ff fs ss rr fr sr.
  const LoadedGraph loaded = loadText(
      "# a comment\nEDGE2 0 1 0.5 -1 0.25 1 2 8 20 3 5\nVERTEX2 0 0 0 0\nVERTEX2 1 1 2 3\r\n");
  EXPECT_EQ(loaded.format, "toro");
  EXPECT_EQ(formatG2o(loaded.graph, loaded.values),
            "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 2 3\nEDGE_SE2 0 1 0.5 -1 0.25 1 2 3 8 5 20\n");
}

TEST_F(Toro, SpaceIsAsG2oReadsTheSameTags) {
  // g2o's own VERTEX3 and EDGE3 have another path through the engine: types with
  // Euler angles, J in the error.
  const std::string text =
      "VERTEX3 0 0.5 -1 2 0.3 -0.4 2.5\nVERTEX3 1 1 2 3 -0.6 0.7 -3\n"
      "EDGE3 0 1 1 -2 0.5 0.4 -0.9 1.1 10 1 0 1 2 0 11 0 1 0 2 12 0 1 1 13 2 0 14 1 15\n";
  const LoadedGraph toro = loadText(text);
  const LoadedGraph g2o = loadText(text, "one.g2o");
  EXPECT_EQ(toro.format, "toro");
  EXPECT_EQ(g2o.format, "g2o");
  EXPECT_STREQ(toro.graph.edgeBlocks()[0].type->tag, "EDGE_SE3:QUAT");
  EXPECT_STREQ(g2o.graph.edgeBlocks()[0].type->tag, "EDGE3");
  const double chi2 = evaluateChi2(g2o.graph, g2o.values);
  EXPECT_GT(chi2, 1);
  EXPECT_NEAR(evaluateChi2(toro.graph, toro.values) / chi2, 1, 1e-12);
}

TEST_F(Toro, AnglesAreRollPitchYaw) {
  const LoadedGraph loaded =
      loadText("VERTEX3 0 1 2 3 0 0 1\nVERTEX3 1 0 0 0 1 0 0\nVERTEX2 2 0 0 0");
  const double* yaw = loaded.values.at(loaded.graph.find(0));
  EXPECT_NEAR(yaw[5], std::sin(0.5), 1e-15);
  EXPECT_NEAR(yaw[6], std::cos(0.5), 1e-15);
  EXPECT_NEAR(loaded.values.at(loaded.graph.find(1))[3], std::sin(0.5), 1e-15);
}

TEST_F(Toro, OtherTextInAGraphFileIsG2o) {
  EXPECT_EQ(loadText("VERTEX_SE2 0 0 0 0\n").format, "g2o");
}

TEST_F(Toro, PlanarTagsAreKnownInAnyFile) {
  EXPECT_EQ(loadText("VERTEX2 0 0 0 0\n", "one.txt").format, "toro");
}

TEST_F(Toro, BadLinesSayWhatIsWrong) {
  const std::pair<const char*, const char*> table[] = {
      {"VERTEX2 0 1 2", "one.graph:2:14: error: VERTEX2: expected a number, the line ends"},
      {"VERTEX2 0 1 2 x", "one.graph:2:15: error: VERTEX2: 'x' is not a number"},
      {"VERTEX2 0 1 2 3 4", "one.graph:2:17: error: unexpected token '4'"},
      {"VERTEX2 -1 1 2 3", "expected an id, got '-1'"},
      {"VERTEX2 7 1 2 3", "vertex 7 is already defined in line 1"},
      {"EDGE2 7", "expected an id, got the end of the line"},
      {"EDGE2 7 8 1 2 3 1 0 1 1 0 0", "vertex 8 is not defined"},
      {"EDGE2 7 8 1 2 3 1 0 1 1 0", "EDGE2: expected a number, the line ends"},
      {"VERTEX2 8 0 0 0\nEDGE2 7 8 1 2 3 1 2 1 1 0 0", "is not positive semidefinite"},
      {"VERTEX3 8 0 0 0 0 nan 0", "VERTEX3: 'nan' is not a finite number"},
      {"EQUIV 7 8", "unknown tag 'EQUIV', TORO has VERTEX2, EDGE2, VERTEX3 and EDGE3"},
  };
  for (const auto& [line, message] : table) {
    const std::string said = failure(std::string("VERTEX2 7 0 0 0\n") + line + "\n");
    EXPECT_NE(said.find(message), std::string::npos) << line << "\n" << said;
  }
}

}  // namespace
}  // namespace graft
