// SPDX-License-Identifier: BSD-3-Clause
// The conformance kit against planted faults: each must be named, by type and
// check, and nothing may be found where there is none.
#include <gtest/gtest.h>

#include <regex>
#include <sstream>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

testing::CommandResult check(const std::string& fault, const std::string& arguments = "") {
  const std::string binary = testing::binaryDirectory();
  return testing::runCommand("GRAFT_TEST_FAULT=" + fault + " " + binary +
                             "/bin/graft check-plugin " + binary +
                             "/lib/graft/faulty/libgraft_faulty.so " + arguments);
}

TEST(Conformance, FindsNothingWhereNothingIsWrong) {
  const testing::CommandResult result = check("none");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_NE(result.out.find(" 0 failed, "), std::string::npos) << result.out;
  // Whatever the seed.
  EXPECT_EQ(check("none", "--seed 2 --samples 31").exit_code, 0);
}

struct PlantedFault {
  const char* name;
  const char* type;
  const char* check;
  const char* text;  ///< regular expression
};

class Planted : public ::testing::TestWithParam<PlantedFault> {};

TEST_P(Planted, IsNamed) {
  const PlantedFault& fault = GetParam();
  // The metadata are those of the file, not of a type.
  const testing::CommandResult result =
      check(fault.name, fault.check == std::string("metadata")
                            ? ""
                            : std::string("--time-limit 5 --only ") + fault.type);
  EXPECT_EQ(result.exit_code, 7) << result.out;
  // path: error: TYPE: check: text
  const std::regex line("libgraft_faulty\\.so: error: " + std::string(fault.type) + ": " +
                        std::regex_replace(std::string(fault.check), std::regex("[.+]"), "\\$&") +
                        ": [^\n]*" + fault.text);
  EXPECT_TRUE(std::regex_search(result.err, line)) << result.err;
}

INSTANTIATE_TEST_SUITE_P(
    , Planted,
    ::testing::Values(
        PlantedFault{"jacobian_sign", "FAULTY_EDGE", "jacobian",
                     "derivative of error 2 by number 2 of slot 1 \\(FAULTY_POINT\\) is"},
        PlantedFault{"jacobian_term", "FAULTY_EDGE", "jacobian", "numerically"},
        PlantedFault{"errors_differ", "FAULTY_EDGE", "errors.same", "with and without"},
        PlantedFault{"propagate", "FAULTY_EDGE", "propagate", "to slot 2 leaves an error"},
        PlantedFault{"measurement_rounds", "FAULTY_EDGE", "normalize.keeps", "valid already"},
        PlantedFault{"overrun", "FAULTY_EDGE", "evaluate.overrun",
                     "writes 1 numbers behind the end of the errors"},
        PlantedFault{"overrun_jacobian", "FAULTY_EDGE", "evaluate.overrun",
                     "behind the end of the Jacobian"},
        PlantedFault{"unwritten", "FAULTY_EDGE", "evaluate.written",
                     "number 8 of 8 of the Jacobian"},
        PlantedFault{"state", "FAULTY_EDGE", "evaluate.state", "the second time"},
        PlantedFault{"first_measurement", "FAULTY_EDGE", "evaluate.batch", "one item differ"},
        PlantedFault{"threads", "FAULTY_EDGE", "evaluate.threads", "another thread"},
        PlantedFault{"aligned", "FAULTY_EDGE", "evaluate.alignment", "signal 6"},
        PlantedFault{"reads_behind", "FAULTY_EDGE", "evaluate.bounds",
                     "(signal 11|ended the process)"},
        PlantedFault{"changes_input", "FAULTY_EDGE", "evaluate.inputs", "changes its input"},
        PlantedFault{"identity_singular", "FAULTY_EDGE", "identity", "not finite"},
        PlantedFault{"not_finite", "FAULTY_EDGE", "evaluate.finite", "not finite"},
        PlantedFault{"evaluate_throws", "FAULTY_EDGE", "evaluate.overrun", "thrown by an edge"},
        PlantedFault{"evaluate_fails", "FAULTY_EDGE", "evaluate.overrun", "not today"},
        PlantedFault{"evaluate_crashes", "FAULTY_EDGE", "jacobian", "signal 6"},
        PlantedFault{"evaluate_exits", "FAULTY_EDGE", "jacobian",
                     "ended the process \\(exit status 0\\)"},
        PlantedFault{"always_changed", "FAULTY_NEAREST", "associate.again", "something changed"},
        PlantedFault{"choices_endless", "FAULTY_NEAREST", "associate.alternatives", "goes on"},
        PlantedFault{"choices_depend", "FAULTY_NEAREST", "associate.alternatives",
                     "depends on the estimates"},
        PlantedFault{"choices_unlisted", "FAULTY_NEAREST", "associate.alternatives",
                     "not among the choices"},
        PlantedFault{"never_changed", "FAULTY_NEAREST", "associate.overrun", "`changed`"},
        PlantedFault{"shape_zero", "FAULTY_SUM", "shape", "0 errors"},
        PlantedFault{"fixed_arity", "FAULTY_SUM", "evaluate+.written", "Jacobian"},
        PlantedFault{"rho_zero", "FaultyCauchy", "rho.zero", "rho\\(0\\) is 1"},
        PlantedFault{"rho_slope", "FaultyCauchy", "rho.zero", "rho'\\(0\\) is 2"},
        PlantedFault{"rho_derivative", "FaultyCauchy", "rho.derivative", "rho' at s"},
        PlantedFault{"rho_second", "FaultyCauchy", "rho.second_derivative", "rho'' at s"},
        PlantedFault{"rho_falls", "FaultyCauchy", "rho.monotone", "falls"},
        PlantedFault{"metadata", "FaultyCauchy", "metadata", "does not register it"},
        PlantedFault{"accepts_garbage", "FAULTY_NUMBER", "load.refuses", "accepts"},
        PlantedFault{"refuses_silently", "FAULTY_NUMBER", "load.refuses", "without a reason"},
        PlantedFault{"recognizes_all", "faulty", "recognizes", "garbage"},
        PlantedFault{"loads_nothing", "faulty", "load.refuses", "without anything"},
        PlantedFault{"guess_silent", "faulty_shift", "guess.empty", "without a reason"},
        PlantedFault{"guess_moves_held", "faulty_shift", "guess.loop", "is held, but was moved"},
        PlantedFault{"guess_unmarked", "faulty_shift", "guess.loop", "without being marked"},
        PlantedFault{"guess_nan", "faulty_shift", "guess.loop", "no estimate|not finite"},
        PlantedFault{"guess_state", "faulty_shift", "guess.loop", "two calls"},
        PlantedFault{"solver_damping", "faulty_dense", "solve", "with damping: relative error"},
        PlantedFault{"solver_indefinite", "faulty_dense", "factorize.indefinite", "accepts"},
        PlantedFault{"solver_nan", "faulty_dense", "factorize.not_finite", "accepts"},
        PlantedFault{"solver_bytes_nan", "faulty_dense", "solve", "factor_bytes\\(\\) gives nan"},
        PlantedFault{"solver_state", "faulty_dense", "solve.state", "the second time"},
        PlantedFault{"solver_overrun", "faulty_dense", "solve", "beside x"}),
    [](const auto& info) { return std::string(info.param.name); });

/// Faults of the vertex, which the edges over it feel, too.
class PlantedInVertex : public ::testing::TestWithParam<PlantedFault> {};

TEST_P(PlantedInVertex, IsNamed) {
  const PlantedFault& fault = GetParam();
  const testing::CommandResult result = check(fault.name, "--time-limit 0.5 --only FAULTY_POINT");
  EXPECT_EQ(result.exit_code, 7) << result.out;
  const std::regex line("error: FAULTY_POINT: " + std::string(fault.check) + ": [^\n]*" +
                        fault.text);
  EXPECT_TRUE(std::regex_search(result.err, line)) << result.err;
}

INSTANTIATE_TEST_SUITE_P(
    , PlantedInVertex,
    ::testing::Values(PlantedFault{"identity_nan", "", "identity.finite", "not finite"},
                      PlantedFault{"normalize_rounds", "", "normalize.keeps", "valid already"},
                      PlantedFault{"normalize_rounds", "", "text", "loses bits"},
                      PlantedFault{"normalize_throws", "", "normalize.keeps", "thrown by a vertex"},
                      PlantedFault{"plus_zero", "", "plus.zero", "x plus 0 is not x"},
                      PlantedFault{"plus_in_place", "", "plus.in_place", "in place"},
                      PlantedFault{"plus_before", "", "plus.overrun", "before the begin"},
                      PlantedFault{"minus_swapped", "", "minus.inverse", "is not y"},
                      PlantedFault{"minus_unwritten", "", "minus.written", "number 2 of 2"},
                      PlantedFault{"minus_hangs", "", "minus.zero", "no answer within 0.5 s"}),
    [](const auto& info) {
      return std::string(info.param.name) + "_" +
             std::regex_replace(std::string(info.param.check), std::regex("\\."), "_");
    });

TEST(Conformance, ACrashEndsOneCheckAndTheRestGoesOn) {
  const testing::CommandResult result = check("evaluate_crashes", "--verbose");
  const auto has = [&](const char* text) {
    EXPECT_NE(result.out.find(text), std::string::npos) << text << "\n" << result.out;
  };
  has("FAILED evaluate.overrun to errors.same (21 checks): signal 6");
  has("passed normalize.keeps");
  has("FAILED propagate: signal 6");
  // No other type is blamed.
  std::istringstream lines(result.err);
  for (std::string one; std::getline(lines, one);) {
    EXPECT_NE(one.find("error: FAULTY_EDGE: "), std::string::npos) << one;
  }
}

TEST(Conformance, OneTypeCanBeChosen) {
  const testing::CommandResult result = check("none", "--only FaultyCauchy --verbose");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.out.find("passed rho.zero"), std::string::npos) << result.out;
  EXPECT_EQ(result.out.find("passed jacobian"), std::string::npos) << result.out;
  EXPECT_EQ(check("none", "--only NOBODY").exit_code, 2);
}

TEST(Conformance, WhatIsNoPluginIsRefusedWithItsName) {
  const std::string program = testing::binaryDirectory() + "/bin/graft check-plugin ";
  const std::string text = testing::writeTestFile(testing::makeTemporaryDirectory(), "a.so", "x");
  testing::CommandResult result = testing::runCommand(program + text);
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_EQ(result.err, text + ": error: not a plugin: it is no ELF file\n");
  result = testing::runCommand(program + "nobody");
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_NE(result.err.find("there is no plugin named 'nobody' (known: "), std::string::npos);
  EXPECT_EQ(testing::runCommand(program).exit_code, 2);
  EXPECT_EQ(testing::runCommand(program + "slam2d --samples 0").exit_code, 2);
}

struct SolverCase {
  const char* fault;
  int exit_code;
  const char* message;
};

TEST(FaultyPlugin, FailsTheEdgeAndNotTheProgram) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string graph = testing::writeTestFile(folder, "g.g2o",
                                                   "FAULTY_POINT 0 0.5 0.3\n"
                                                   "FAULTY_POINT 1 1 2\n"
                                                   "FAULTY_EDGE 0 1 1 1 1 0 1\n");
  const std::string binary = testing::binaryDirectory();
  const auto optimize = [&](const std::string& fault) {
    return testing::runCommand("GRAFT_TEST_FAULT=" + fault + " " + binary + "/bin/graft optimize " +
                               graph + " --plugin " + binary +
                               "/lib/graft/faulty/libgraft_faulty.so -o " + folder + "/out.g2o");
  };
  const SolverCase cases[] = {
      {"evaluate_throws", 4, "edge FAULTY_EDGE 0 1 (line 3): thrown by an edge"},
      {"evaluate_fails", 4, "edge FAULTY_EDGE 0 1 (line 3): not today"},
      {"always_infinite", 4, "the error of edge FAULTY_EDGE 0 1 (line 3) is not finite"},
      {"always_unwritten", 4, "the Jacobian of edge FAULTY_EDGE 0 1 (line 3) is not finite"},
      {"normalize_throws", 3, graph.c_str()},
      {"normalize_throws", 3, ":1:14: error: FAULTY_POINT 0: thrown by a vertex"},
  };
  for (const SolverCase& one : cases) {
    const testing::CommandResult result = optimize(one.fault);
    EXPECT_EQ(result.exit_code, one.exit_code) << one.fault << result.err;
    EXPECT_NE(result.err.find(one.message), std::string::npos) << result.err;
    EXPECT_EQ(testing::readTestFile(folder + "/out.g2o"), "") << one.fault;
  }
  EXPECT_EQ(optimize("none").exit_code, 0);
}

}  // namespace
}  // namespace graft
