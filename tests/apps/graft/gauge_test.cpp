// SPDX-License-Identifier: BSD-3-Clause
// What nothing fixes: found per connected component, fixed the same way every time, and
// said; with positions, poses in the plane and in space, and graphs in TORO's format.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <sstream>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

struct GaugeCase {
  const char* name;
  const char* file;
  std::vector<std::string> lines;
  std::vector<std::string> notes;  ///< all of them, by their begin
  std::vector<std::string> kept;   ///< lines that stay as they were
};

const std::string kI3 = " 1 0 0 1 0 1";
const std::string kI6 = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";

std::vector<GaugeCase> cases() {
  const std::string held = " is held where it is: nothing fixes its component of ";
  const std::string open = "no edge determines this: ";
  return {
      {"plane",
       "g.g2o",
       {"VERTEX_SE2 7 1 2 0.5", "VERTEX_SE2 3 4 5 0.1", "EDGE_SE2 7 3 1 0 0" + kI3,
        "VERTEX_SE2 20 0 0 0", "VERTEX_SE2 21 1 1 1", "EDGE_SE2 21 20 1 0 0" + kI3},
       {"VERTEX_SE2 20" + held + "2", "VERTEX_SE2 3" + held + "2"},
       {"VERTEX_SE2 3 4 5 0.1", "VERTEX_SE2 20 0 0 0"}},
      {"space",
       "g.g2o",
       {"VERTEX_SE3:QUAT 5 1 2 3 0 0 0 1", "VERTEX_SE3:QUAT 6 0 0 0 0 0 0 1",
        "EDGE_SE3:QUAT 6 5 1 0 0 0 0 0 1" + kI6},
       {"VERTEX_SE3:QUAT 5" + held + "2"},
       {"VERTEX_SE3:QUAT 5 1 2 3 0 0 0 1"}},
      {"landmarks_only",
       "g.g2o",
       {"VERTEX_XY 2 0.5 0.5", "VERTEX_XY 1 3 4", "EDGE_POINTXY 1 2 1 1 1 0 1"},
       {"VERTEX_XY 1" + held + "2"},
       {"VERTEX_XY 1 3 4"}},
      {"one_of_two_is_fixed",
       "g.g2o",
       {"VERTEX_XY 1 3 4", "VERTEX_XY 2 0 0", "FIX 2", "EDGE_POINTXY 1 2 1 1 1 0 1",
        "VERTEX_XY 8 1 1", "VERTEX_XY 9 0 0", "EDGE_POINTXY 9 8 1 1 1 0 1"},
       {"VERTEX_XY 8" + held + "2"},
       {"VERTEX_XY 2 0 0", "VERTEX_XY 8 1 1"}},
      {"a_whole_prior_holds",
       "g.g2o",
       {"VERTEX_SE2 1 1 2 0.5", "VERTEX_SE2 2 4 5 0.1", "EDGE_SE2 1 2 1 0 0" + kI3,
        "EDGE_PRIOR_SE2 1 0 0 0" + kI3},
       {},
       {}},
      {"a_position_leaves_the_heading",
       "g.g2o",
       {"VERTEX_SE2 1 1 2 0.5", "VERTEX_SE2 2 4 5 0.1", "EDGE_SE2 1 2 1 0 0" + kI3,
        "EDGE_PRIOR_SE2_XY 1 0 0 1 0 1"},
       {open + "VERTEX_SE2 2 is free along (", open + "VERTEX_SE2 1 is free along ("},
       {}},
      {"positions_of_two_poses_hold",
       "g.g2o",
       {"VERTEX_SE2 1 1 2 0.5", "VERTEX_SE2 2 4 5 0.1", "EDGE_SE2 1 2 1 0 0" + kI3,
        "EDGE_PRIOR_SE2_XY 1 0 0 1 0 1", "EDGE_PRIOR_SE2_XY 2 1 0 1 0 1"},
       {},
       {}},
      {"a_position_in_space_leaves_three_turns",
       "g.g2o",
       {"PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1", "VERTEX_SE3:QUAT 5 1 2 3 0 0 0 1",
        "EDGE_SE3_XYZ_PRIOR 5 0 0 0 0 1 0 0 1 0 1"},
       {open + "VERTEX_SE3:QUAT 5 is free along (", open + "VERTEX_SE3:QUAT 5 is free along (",
        open + "VERTEX_SE3:QUAT 5 is free along ("},
       {}},
      {"toro",
       "g.graph",
       {"VERTEX2 4 0 0 0", "VERTEX2 5 1 1 0", "EDGE2 4 5 1 0 0 1 0 1 1 0 0"},
       {"VERTEX_SE2 4" + held + "2"},
       {"VERTEX_SE2 4 0 0 0"}},
  };
}

class Gauge : public ::testing::TestWithParam<GaugeCase> {};

TEST_P(Gauge, IsFoundFixedAndSaidWhateverTheOrderOfLines) {
  const GaugeCase& one = GetParam();
  const std::string folder = testing::makeTemporaryDirectory();
  std::vector<std::string> lines = one.lines;
  std::mt19937_64 random(3);
  testing::CommandResult first;
  for (int round = 0; round < 4; ++round) {
    std::string text;
    for (const std::string& line : lines) text += line + '\n';
    testing::writeTestFile(folder, one.file, text);
    const testing::CommandResult result =
        testing::runCommand(testing::binaryDirectory() + "/bin/graft optimize " + folder + "/" +
                            one.file + " --initial-guess file -o -");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    std::istringstream said(result.err);
    std::vector<std::string> notes;
    for (std::string line; std::getline(said, line);) {
      if (line.rfind("note: ", 0) == 0) notes.push_back(line.substr(6));
    }
    ASSERT_EQ(notes.size(), one.notes.size()) << result.err;
    std::sort(notes.begin(), notes.end());
    std::vector<std::string> expected = one.notes;
    std::sort(expected.begin(), expected.end());
    for (std::size_t i = 0; i < notes.size(); ++i)
      EXPECT_EQ(notes[i].find(expected[i]), 0u) << notes[i];
    for (const std::string& kept : one.kept) {
      EXPECT_NE(result.out.find(kept + "\n"), std::string::npos) << result.out;
    }
    if (round == 0) first = result;
    EXPECT_EQ(result.out, first.out) << "it depends on the order of lines";
    if (std::string(one.file) == "g.g2o") std::shuffle(lines.begin(), lines.end(), random);
  }
}

INSTANTIATE_TEST_SUITE_P(, Gauge, ::testing::ValuesIn(cases()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace graft
