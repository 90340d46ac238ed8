// SPDX-License-Identifier: BSD-3-Clause
// Defective files into the program: how it ends, what it says, and that an
// earlier output is left alone.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

namespace fs = std::filesystem;

struct InputCase {
  const char* name;
  std::string content;
  int exit_code;
  const char* message;  ///< regular expression on standard error
};

const std::string kV0 = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n";
const std::string kV1 = "VERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n";
const std::string kZ = " 1 0 0 0 0 0 1";
const std::string kOmega = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";
const std::string kEdge = "EDGE_SE3:QUAT 0 1" + kZ + kOmega + "\n";
const std::string kGood = kV0 + kV1 + kEdge;
const std::string kPoint = "VERTEX_XY 5 1 2\n";
const std::string kPlane = "VERTEX_SE2 6 1 2 0\n";

std::string edgeWith(const std::string& measurement) {
  return kV0 + kV1 + "EDGE_SE3:QUAT 0 1 " + measurement + kOmega + "\n";
}
std::string vertexWith(const std::string& number) {
  return "VERTEX_XY 0 " + number + " 2\nVERTEX_SE2 1 0 0 0\nEDGE_SE2_XY 1 0 1 2 1 0 1\n";
}
std::string planeEdge(const std::string& information) {
  return kPoint + kPlane + "EDGE_SE2_XY 6 5 1 2 " + information + "\n";
}
std::string repeated(const std::string& line, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += line + std::to_string(i) + "\n";
  return text;
}

std::vector<InputCase> cases() {
  using namespace std::string_literals;
  return {
      // A: syntax
      {"empty", "", 3, "in\\.g2o:1: error: no vertices"},
      {"only_comments", "# nothing\n\n   \n", 3, "in\\.g2o:1: error: no vertices"},
      {"only_fix", "FIX 1\n", 3, "no vertices"},
      {"blank_line", kV0 + " \t \n" + kV1 + kEdge, 0, ""},
      {"tag_only", "VERTEX_SE3:QUAT\n", 3, "in\\.g2o:1:16: error: expected id, the line ends"},
      {"edge_tag_only", kGood + "EDGE_SE3:QUAT\n", 3, ":4:14: error: expected id"},
      {"vertex_cut", "VERTEX_SE3:QUAT 0 0 0 0 0 0 0\n", 3,
       ":1:30: error: .*expected 8 fields, got 7"},
      {"vertex_id_only", "VERTEX_SE3:QUAT 0\n", 3, "expected 8 fields, got 1"},
      {"edge_without_information", kV0 + kV1 + "EDGE_SE3:QUAT 0 1" + kZ + "\n", 3,
       ":3:32: error: EDGE_SE3:QUAT: expected 30 fields, got 9"},
      {"edge_ids_only", kV0 + kV1 + "EDGE_SE3:QUAT 0 1\n", 3, "expected 30 fields, got 2"},
      {"edge_one_id", kV0 + kV1 + "EDGE_SE3:QUAT 0\n", 3, "expected id, the line ends"},
      {"extra_token", kGood.substr(0, kGood.size() - 1) + " 7\n", 3,
       "unexpected token '7': EDGE_SE3:QUAT has 30 fields, got 31"},
      {"trailing_comment", kGood.substr(0, kGood.size() - 1) + " # fine\n", 0, ""},
      {"full_matrix",
       kV0 + kV1 + "EDGE_SE3:QUAT 0 1" + kZ +
           " 1 0 0 0 0 0 0 1 0 0 0 0 0 0 1 0 0 0 0 0 0 1 0 0 0 0 0 0 1 0 0 0 0 0 0 1\n",
       3, "has 30 fields, got 45"},
      {"no_final_newline", kGood.substr(0, kGood.size() - 1), 0, ""},
      {"crlf", std::regex_replace(kGood, std::regex("\n"), "\r\n"), 0, ""},
      {"cr_only", std::regex_replace(kGood, std::regex("\n"), "\r"), 3,
       "in\\.g2o:1: error: no newline; CR line ends are not supported"},
      {"byte_order_mark", "\xef\xbb\xbf" + kGood, 0, ""},
      {"utf16", "\xff\xfeV\0E\0"s, 3, "looks like UTF-16"},
      {"utf32", "\0\0\xfe\xff\0\0\0V"s, 3, "looks like UTF-16 or UTF-32"},
      {"nul_byte", kV0 + "VERTEX_SE3:QUAT 1 0\0 0 0 0 0 0 1\n"s, 3,
       ":2:19: error: control byte '\\\\x00', this is not a text file"},
      {"escape_in_tag", "\x1b[2J 1 2\n" + kGood, 3, ":1:1: error: control byte '\\\\x1b'"},
      {"elf", "\x7f"s + "ELF\2\1\1\0\0\n\1\2\3\n"s, 3, "control byte '\\\\x7f'"},
      {"gzip", "\x1f\x8b\x08\0\0\0"s, 3, "gzip input is not supported"},
      {"kernel_first", "ROBUST_KERNEL Huber 1\n" + kGood, 3,
       ":1:1: error: ROBUST_KERNEL belongs behind the line of an edge"},
      {"level_behind_vertex", kV0 + "G2O_EDGE_LEVEL 1\n" + kV1 + kEdge, 3,
       ":2:1: error: G2O_EDGE_LEVEL belongs behind the line of an edge"},
      {"level_behind_fix", kGood + "FIX 0\nG2O_EDGE_LEVEL 1\n", 3, ":5:1: error: G2O_EDGE_LEVEL"},
      {"kernel_unknown", kGood + "ROBUST_KERNEL Hubert 1\n", 3,
       ":4:15: error: unknown robust kernel 'Hubert'.*Huber"},
      {"kernel_without_name", kGood + "ROBUST_KERNEL\n", 3,
       ":4:14: error: expected the name of a kernel, the line ends"},
      {"kernel_without_width", kGood + "ROBUST_KERNEL Huber\n", 3,
       ":4:20: error: ROBUST_KERNEL: expected 2 fields, got 1"},
      {"kernel_width_zero", kGood + "ROBUST_KERNEL Huber 0\n", 3,
       ":4: error: the width of a robust kernel must be positive, got 0"},
      {"kernel_width_nan", kGood + "ROBUST_KERNEL Huber nan\n", 3, ":4:21: error: .*'nan'"},
      {"kernel_too_much", kGood + "ROBUST_KERNEL Huber 1 2\n", 3,
       ":4:23: error: unexpected token '2'"},
      {"kernel_twice", kGood + "ROBUST_KERNEL Huber 1\nROBUST_KERNEL Cauchy 1\n", 3,
       ":5: error: the edge of line 3 has a robust kernel already"},
      {"level_empty", kGood + "G2O_EDGE_LEVEL\n", 3,
       ":4:15: error: expected a level, the line ends"},
      {"level_negative", kGood + "G2O_EDGE_LEVEL -1\n", 3,
       ":4:16: error: expected a level from 0 to 2147483647, got '-1'"},
      {"level_fraction", kGood + "G2O_EDGE_LEVEL 1.5\n", 3, ":4:16: error: expected a level"},
      {"level_too_big", kGood + "G2O_EDGE_LEVEL 2147483648\n", 3, ":4:16: error: expected a level"},
      {"level_too_much", kGood + "G2O_EDGE_LEVEL 1 2\n", 3, ":4:18: error: unexpected token '2'"},
      {"level_twice", kGood + "G2O_EDGE_LEVEL 1\nG2O_EDGE_LEVEL 1\n", 3,
       ":5: error: the edge of line 3 has a level already"},
      {"level_of_lost_edge", kGood + "EDGE_FOO 1 2 3\nG2O_EDGE_LEVEL 1\n", 3,
       ":5: warning: G2O_EDGE_LEVEL of a line that was not read, skipped"},
      {"unknown_tag", kGood + "EDGE_FOO 1 2 3\n", 3, ":4:1: error: unknown tag 'EDGE_FOO'"},
      {"unknown_tag_near", kGood + "EDGE_SE3QUAT 1 2 3\n", 3, "EDGE_SE3:QUAT\\?"},
      {"lower_case_tag", "vertex_se2 1 2 3\n", 3, "upper and lower case differ: VERTEX_SE2\\?"},
      {"many_unknown_tags", repeated("TAG_", 5000), 3, "and 4980 more errors"},
      {"kernel_as_tag", "Huber 1 2\n", 3, "Huber is a robust kernel of the plugin kernels"},
      // B: numbers
      {"nan", vertexWith("nan"), 3, ":1:13: error: 'nan' is not a finite number"},
      {"minus_nan", vertexWith("-nan"), 3, "'-nan' is not a"},
      {"nan_payload", vertexWith("nan(123)"), 3, "'nan\\(123\\)' is not a"},
      {"inf", vertexWith("inf"), 3, "'inf' is not a finite number"},
      {"infinity", vertexWith("-Infinity"), 3, "'-Infinity' is not a finite number"},
      {"too_large", vertexWith("1e999"), 3, "'1e999' is out of range"},
      {"too_large_negative", vertexWith("-1e999"), 3, "out of range"},
      {"just_too_large", vertexWith("1.7976931348623159e308"), 3, "out of range"},
      {"tiny", vertexWith("1e-999"), 0, ""},
      {"denormal", vertexWith("4e-320"), 0, ""},
      {"plus_sign", vertexWith("+1.5"), 0, ""},
      {"digits_and_letters", vertexWith("1.5abc"), 3, "'1.5abc' is not a number"},
      {"two_points", vertexWith("1.5.2"), 3, "is not a number"},
      {"open_exponent", vertexWith("1e"), 3, "is not a number"},
      {"fortran_exponent", vertexWith("1d5"), 3, "is not a number"},
      {"hexadecimal", vertexWith("0x1p3"), 3, "is not a number"},
      {"underscore", vertexWith("1_000"), 3, "is not a number"},
      {"decimal_comma", vertexWith("1,5"), 3, "decimal comma\\? use '\\.'"},
      {"long_mantissa", vertexWith("0." + std::string(400, '3')), 0, ""},
      {"no_leading_digit", vertexWith(".5"), 0, ""},
      {"no_trailing_digit", vertexWith("5."), 0, ""},
      {"infinite_cost", vertexWith("1e300") + "FIX 0 1\n", 4, "no usable result"},
      // C: ids and topology
      {"duplicate_vertex", kGood + kV0, 3, ":4:17: error: vertex 0 is already defined in line 1"},
      {"missing_vertex", kV0 + kEdge, 3,
       ":2:17: error: vertex 1 is not defined \\(needed by EDGE_SE3:QUAT slot 2\\)"},
      {"definitions_follow", "FIX 0\n" + kEdge + kV1 + kV0, 0, ""},
      {"fix_missing", kGood + "FIX 9\n", 3, ":4: error: vertex 9 is not defined \\(FIX\\)"},
      {"fix_without_id", kGood + "FIX\n", 3, ":4:4: error: expected id"},
      {"negative_id", "VERTEX_XY -5 1 2\n", 3, ":1:11: error: id '-5' is negative"},
      {"id_too_large", "VERTEX_XY 9223372036854775808 1 2\n", 3, "is out of range \\(0 to 92233"},
      {"largest_id", "VERTEX_XY 9223372036854775807 1 2\n", 0, "has no edge"},
      {"id_with_point", "VERTEX_XY 2.7 1 2\n", 3, "expected an integer id, got '2.7'"},
      {"id_with_exponent", "VERTEX_XY 1e3 1 2\n", 3, "expected an integer id"},
      {"self_loop", kV0 + "EDGE_SE3:QUAT 0 0" + kZ + kOmega + "\n", 3,
       ":2: error: .*vertex 0 twice"},
      {"wrong_slot", kPoint + kV0 + "EDGE_SE3:QUAT 0 5" + kZ + kOmega + "\n", 3,
       "slot 2 needs VERTEX_SE3:QUAT, vertex 5 is VERTEX_XY"},
      {"prior_on_plane_pose",
       kPlane + "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\nEDGE_SE3_PRIOR 6 0" + kZ + kOmega + "\n", 3,
       "slot 1 needs VERTEX_SE3:QUAT, vertex 6 is VERTEX_SE2"},
      {"missing_parameter", kV0 + "EDGE_SE3_PRIOR 0 7" + kZ + kOmega + "\n", 3,
       ":2:18: error: resource 7 is not defined \\(needed by EDGE_SE3_PRIOR\\)"},
      {"duplicate_parameter",
       kV0 + "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\nPARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n", 3,
       ":3:18: error: resource 0 is already defined"},
      {"parameter_after_use",
       "EDGE_SE3_PRIOR 0 7" + kZ + kOmega + "\n" + kV0 + "PARAMS_SE3OFFSET 7 0 0 0 0 0 0 1\n", 0,
       ""},
      {"parameter_of_another_type",
       kV0 + "PARAMS_SE2OFFSET 7 0 0 0\nEDGE_SE3_PRIOR 0 7" + kZ + kOmega + "\n", 3,
       ":3: error: edge EDGE_SE3_PRIOR needs a PARAMS_SE3OFFSET, resource 7 is PARAMS_SE2OFFSET"},
      {"parameter_with_a_number_that_is_none", kV0 + "PARAMS_SE3OFFSET 7 0 0 x 0 0 0 1\n", 3,
       ":2: error: PARAMS_SE3OFFSET 7: .*'x'"},
      {"parameter_with_negative_id", kV0 + "PARAMS_SE3OFFSET -7 0 0 0 0 0 0 1\n", 3,
       ":2:18: error: id '-7' is negative"},
      {"parameter_without_id", kV0 + "PARAMS_SE3OFFSET\n", 3, ":2:17: error: expected id"},
      {"parameter_id_where_a_vertex_is", kV0 + "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n", 0, ""},
      {"short_parameter", kV0 + "PARAMS_SE3OFFSET 0 0 0 0\n", 3,
       ":2: error: PARAMS_SE3OFFSET 0: expected 7 numbers"},
      {"dynamic_without_separator", kV0 + kPoint + "EDGE_SE3_LOTSOF_XYZ 0 5 1 2 3 1 0 0 1 0 1\n", 3,
       ":3:"},
      {"dynamic_without_vertices", kV0 + "EDGE_SE3_LOTSOF_XYZ || 1\n", 3, ":2:"},
      {"isolated_vertex", kGood + "VERTEX_SE3:QUAT 8 0 0 0 0 0 0 1\n", 0,
       "warning: vertex 8 has no edge and keeps its estimate"},
      {"all_fixed", kGood + "FIX 0 1\n", 0, ""},
      {"two_components", kGood + kPoint + kPlane + "EDGE_SE2_XY 6 5 1 2 1 0 1\n", 0, ""},
      {"no_vertex_lines", kEdge, 0, "note: no vertex lines; 2 vertices made along the edges"},
      // D: information and quaternions
      {"zero_information", planeEdge("0 0 0"), 0, ":3: warning: .*zeros"},
      {"negative_information", planeEdge("-1 0 1"), 3,
       ":3: error: EDGE_SE2_XY 6 5: the information matrix .*smallest eigenvalue is -1"},
      {"indefinite_information", planeEdge("1 2 1"), 3, "smallest eigenvalue is -(1|0\\.9999)"},
      {"rounded_singular", planeEdge("1 1.0000000001 1"), 0, ""},
      {"singular_information", planeEdge("1 1 1"), 0, ""},
      {"nan_information", planeEdge("1 nan 1"), 3, "'nan' is not a finite number"},
      {"zero_quaternion", edgeWith("1 0 0 0 0 0 0"), 3, ":3: error: .*the quaternion is zero"},
      {"zero_vertex_quaternion", "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0\n", 3,
       ":1.*the quaternion is zero"},
      {"long_quaternion", edgeWith("1 0 0 0 0 0 3"), 3, "the quaternion has length 3, expected 1"},
      {"short_quaternion", edgeWith("1 0 0 0 0 0 0.4"), 3, "the quaternion has length 0.4"},
      {"doubtful_quaternion", edgeWith("1 0 0 0 0 0 1.05"), 0,
       "warning: the quaternion has length"},
      {"rounded_quaternion", edgeWith("1 0 0 0 0 0 1.000001"), 0, ""},
      {"many_turns", "VERTEX_SE2 0 0 0 1e9\nVERTEX_SE2 1 0 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n",
       0, ""},
  };
}

class BadInput : public ::testing::TestWithParam<InputCase> {};

TEST_P(BadInput, EndsAsStatedAndLeavesEarlierOutputAlone) {
  const InputCase& one = GetParam();
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string input = testing::writeTestFile(folder, "in.g2o", one.content);
  const std::string output = testing::writeTestFile(folder, "out.g2o", "earlier result");
  const testing::CommandResult result =
      testing::runCommand("cd " + folder + " && " + testing::binaryDirectory() +
                          "/bin/graft optimize in.g2o -o out.g2o --threads 1");
  EXPECT_EQ(result.exit_code, one.exit_code) << result.err;
  EXPECT_TRUE(std::regex_search(result.err, std::regex(one.message))) << result.err;
  for (const char c : result.err) {
    EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20) << int(c);
  }
  if (one.exit_code != 0) {
    EXPECT_EQ(testing::readTestFile(output), "earlier result");
    EXPECT_NE(result.err.find("error: "), std::string::npos);
  } else {
    const std::string written = testing::readTestFile(output);
    EXPECT_EQ(written.find("nan"), std::string::npos);
    EXPECT_EQ(written.find("inf"), std::string::npos);
    EXPECT_NE(written, "earlier result");
  }
  int files = 0;
  for (const auto& entry : fs::directory_iterator(folder)) files += entry.exists() ? 1 : 0;
  EXPECT_EQ(files, 2) << "a file appeared or vanished";
}

INSTANTIATE_TEST_SUITE_P(, BadInput, ::testing::ValuesIn(cases()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace graft
