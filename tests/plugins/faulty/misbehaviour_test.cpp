// SPDX-License-Identifier: BSD-3-Clause
// Functions of a plugin that throw, crash, end the process, write too much or never
// return while a graph is loaded or solved: the program names plugin, type and function,
// ends with the stated code, and an earlier output stays as it was.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <regex>

#include "core/types/stamp.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

namespace fs = std::filesystem;

const std::string kVertices = "FAULTY_POINT 0 0.5 0.3\nFAULTY_POINT 1 1 2\nFAULTY_POINT 2 3 2\n";
const std::string kEdges =
    "FAULTY_EDGE 0 1 1 1 1 0 1\nFAULTY_EDGE 1 2 1 0 1 0 1\nFAULTY_NEAREST 1 1\n"
    "FAULTY_SUM 0 1 2 || 3 1\nFAULTY_NUMBER 7 2.5\n";

/// Runs `graft optimize` over an earlier output.
class Optimized {
 public:
  explicit Optimized(const std::string& fault, const std::string& options = "",
                     const std::string& graph = kVertices + kEdges,
                     const std::string& name = "g.g2o") {
    testing::writeTestFile(folder_, name, graph);
    testing::writeTestFile(folder_, "out.g2o", "earlier result");
    const std::string binary = testing::binaryDirectory();
    result = testing::runCommand("cd " + folder_ + " && GRAFT_TEST_FAULT=" + fault + " " + binary +
                                 "/bin/graft optimize " + name + " --plugin " + binary +
                                 "/lib/graft/faulty/libgraft_faulty.so -o out.g2o " + options);
  }
  std::string output() const { return testing::readTestFile(folder_ + "/out.g2o"); }
  /// Files beside input and output, e.g. temporary ones that were left.
  int strangers() const {
    int count = -2;
    for (const auto& entry : fs::directory_iterator(folder_)) count += entry.exists() ? 1 : 0;
    return count;
  }
  testing::CommandResult result;

 private:
  std::string folder_ = testing::makeTemporaryDirectory();
};

struct Spoiled {
  const char* fault;
  const char* options;
  int exit_code;
  const char* message;  ///< regular expression
};

class Misbehaving : public ::testing::TestWithParam<Spoiled> {};

TEST_P(Misbehaving, IsNamedAndLeavesTheOutputAlone) {
  const Spoiled& one = GetParam();
  const std::string fault = one.fault;
  const bool crash = fault.compare(0, 7, "crashes") == 0 || fault.compare(0, 6, "aborts") == 0;
  if (crash && detail::sanitizerBits() != 0) GTEST_SKIP() << "the sanitizer reports crashes";
  const bool loader =
      fault.find("loader") != std::string::npos || fault.find("recognizes") != std::string::npos;
  const bool made =
      fault.find("identity") != std::string::npos || fault.find("propagate") != std::string::npos;
  const Optimized run(fault, one.options,
                      loader ? "FAULTY\n" : (made ? std::string() : kVertices) + kEdges,
                      loader ? "g.faulty" : "g.g2o");
  EXPECT_EQ(run.result.exit_code, one.exit_code) << run.result.err;
  EXPECT_TRUE(std::regex_search(run.result.err, std::regex(one.message))) << run.result.err;
  EXPECT_NE(run.result.err.find("libgraft_faulty.so"), std::string::npos) << run.result.err;
  EXPECT_EQ(run.output(), "earlier result");
  EXPECT_EQ(run.strangers(), 0);
}

constexpr const char* kSolver = "--linear-solver faulty_dense";
constexpr const char* kGuess = "--initial-guess faulty_shift";
constexpr const char* kImpatient = "--plugin-patience 1";
constexpr const char* kKernel = "--robust-kernel FaultyCauchy";

INSTANTIATE_TEST_SUITE_P(
    , Misbehaving,
    ::testing::Values(
        Spoiled{"throws_in_evaluate", "", 4,
                "edge FAULTY_EDGE 0 1 \\(line 4\\): thrown by the plugin \\(plugin .*faulty\\.so"},
        Spoiled{"throws_in_associate", "", 4, "FAULTY_NEAREST .*: thrown by the plugin"},
        Spoiled{"throws_in_plus", "", 7,
                "faulty\\.so: error: FAULTY_POINT: plus\\(\\) threw an exception: thrown by"},
        Spoiled{"throws_in_propagate", "", 7,
                "error: FAULTY_EDGE: propagate\\(\\) threw an exception"},
        Spoiled{"throws_in_identity", "", 7,
                "error: FAULTY_POINT: identity\\(\\) threw an exception"},
        Spoiled{"throws_in_normalize", "", 3, "g2o:1:.*FAULTY_POINT 0: thrown by the plugin"},
        Spoiled{"throws_in_shape", "", 3, "g2o:7:.*FAULTY_SUM .*: thrown by the plugin"},
        Spoiled{"throws_in_kernel", kKernel, 7,
                "error: FaultyCauchy: evaluate\\(\\) threw an exception"},
        Spoiled{"throws_in_solver", kSolver, 4,
                "linear solver faulty_dense failed: thrown by the plugin"},
        Spoiled{"throws_in_resource", "", 7,
                "error: FAULTY_NUMBER: load\\(\\) threw an exception: thrown by the plugin "
                "\\(input: g\\.g2o:8\\)"},
        Spoiled{"throws_in_recognizes", "", 7, "error: faulty: the loader threw an exception"},
        Spoiled{"throws_in_loader", "", 7,
                "error: faulty: the loader threw an exception: thrown by the plugin \\(input: "
                "g\\.faulty\\)"},
        Spoiled{"throws_in_guess", kGuess, 4,
                "no initial guess faulty_shift: thrown by the plugin \\(plugin .*faulty\\.so\\)"},
        Spoiled{"crashes_in_evaluate", "", 7,
                "error: FAULTY_EDGE: evaluate\\(\\) crashed: signal 11 \\(Segmentation fault\\); "
                "outputs that were not complete are as they were before; input: g\\.g2o\n$"},
        Spoiled{"crashes_in_evaluate", "--threads 3", 7, "FAULTY_EDGE: evaluate\\(\\) crashed"},
        Spoiled{"aborts_in_evaluate", "", 7, "evaluate\\(\\) crashed: signal 6 \\(Aborted\\)"},
        Spoiled{"crashes_in_associate", "", 7, "FAULTY_NEAREST: associate\\(\\) crashed"},
        Spoiled{"crashes_in_plus", "", 7, "FAULTY_POINT: plus\\(\\) crashed: signal 11"},
        Spoiled{"crashes_in_propagate", "", 7, "FAULTY_EDGE: propagate\\(\\) crashed"},
        Spoiled{"crashes_in_identity", "", 7, "FAULTY_POINT: identity\\(\\) crashed"},
        Spoiled{"crashes_in_normalize", "", 7, "FAULTY_POINT: normalize\\(\\) crashed"},
        Spoiled{"crashes_in_shape", "", 7, "FAULTY_SUM: shape\\(\\) crashed"},
        Spoiled{"crashes_in_kernel", kKernel, 7, "FaultyCauchy: evaluate\\(\\) crashed"},
        Spoiled{"crashes_in_solver", kSolver, 7, "faulty_dense: the linear solver crashed"},
        Spoiled{"crashes_in_resource", "", 7,
                "FAULTY_NUMBER: load\\(\\) crashed: signal 11 .*; input: g\\.g2o:8\n"},
        Spoiled{"crashes_in_recognizes", "", 7, "faulty: the loader crashed"},
        Spoiled{"crashes_in_loader", "", 7,
                "faulty: the loader crashed: signal 11 .*; input: g\\.faulty\n"},
        Spoiled{"crashes_in_guess", kGuess, 7,
                "faulty_shift: guess\\(\\) crashed: signal 11 .*; input: g\\.g2o\n"},
        Spoiled{"aborts_in_resource", "", 7, "FAULTY_NUMBER: load\\(\\) crashed: signal 6"},
        Spoiled{"aborts_in_loader", "", 7, "faulty: the loader crashed: signal 6"},
        Spoiled{"aborts_in_guess", kGuess, 7, "faulty_shift: guess\\(\\) crashed: signal 6"},
        Spoiled{"exits_in_evaluate", "", 7, "error: FAULTY_EDGE: evaluate\\(\\) ended the program"},
        Spoiled{"exits_in_plus", "", 7, "FAULTY_POINT: plus\\(\\) ended the program"},
        Spoiled{"exits_in_normalize", "", 7, "FAULTY_POINT: normalize\\(\\) ended the program"},
        Spoiled{"exits_in_solver", kSolver, 7, "faulty_dense: the linear solver ended"},
        Spoiled{"exits_in_loader", "", 7,
                "faulty: the loader ended the program.*; input: g\\.faulty\n"},
        Spoiled{"exits_in_recognizes", "", 7, "faulty: the loader ended the program"},
        Spoiled{"exits_in_resource", "", 7,
                "FAULTY_NUMBER: load\\(\\) ended the program.*; input: g\\.g2o:8\n"},
        Spoiled{"exits_in_guess", kGuess, 7,
                "faulty_shift: guess\\(\\) ended the program.*; input: g\\.g2o\n"},
        Spoiled{"hangs_in_loader", kImpatient, 7,
                "faulty: the loader has not returned for 1 s, the limit of --plugin-patience is 1 "
                "s; .*; input: g\\.faulty\n"},
        Spoiled{"hangs_in_recognizes", kImpatient, 7, "faulty: the loader has not returned for 1"},
        Spoiled{"hangs_in_resource", kImpatient, 7,
                "FAULTY_NUMBER: load\\(\\) has not returned for 1 s, .*; input: g\\.g2o:8\n"},
        Spoiled{"hangs_in_normalize", kImpatient, 7,
                "FAULTY_POINT: normalize\\(\\) has not returned for 1 s"},
        Spoiled{"hangs_in_guess", "--initial-guess faulty_shift --plugin-patience 1", 7,
                "faulty_shift: guess\\(\\) has not returned for 1 s, .*; input: g\\.g2o\n"},
        Spoiled{"overrun", "", 4,
                "FAULTY_EDGE: evaluate\\(\\) writes behind the end of its errors"},
        Spoiled{"overrun_jacobian", "", 4,
                "FAULTY_EDGE: evaluate\\(\\) writes behind the end of its Jacobians"},
        Spoiled{"always_infinite", "", 4, "error of edge FAULTY_EDGE 0 1 .* is not finite"},
        Spoiled{"always_unwritten", "", 4, "Jacobian of edge FAULTY_EDGE 0 1 .* is not finite"},
        Spoiled{"rho_nan", kKernel, 4,
                "FAULTY_EDGE 0 1 .*is not finite, its kernel is FaultyCauchy"},
        Spoiled{"shape_zero", "", 3, "FAULTY_SUM .*its shape\\(\\) says 0 errors"},
        Spoiled{"shape_huge", "", 3, "FAULTY_SUM .*its shape\\(\\) says 1000000000 errors"},
        Spoiled{"identity_nan", "", 3, "identity of FAULTY_POINT .*has a number that is not"},
        Spoiled{"solver_block", kSolver, 4, "faulty_dense finds no positive definite matrix"}),
    [](const auto& info) {
      std::string name = info.param.fault;
      if (info.param.options == std::string("--threads 3")) name += "_of_three_threads";
      return name;
    });

TEST(SolverOfAPlugin, WhoseFactorDoesNotFitIsNotBegun) {
  const Optimized run("solver_bytes", kSolver);
  EXPECT_EQ(run.result.exit_code, 4) << run.result.err;
  EXPECT_TRUE(std::regex_search(
      run.result.err,
      std::regex("no usable result: the factor of the normal equations needs 1000 PB, .* are free; "
                 "an iterative linear solver, such as pcg, makes no factor")))
      << run.result.err;
  EXPECT_EQ(run.output(), "earlier result");
}

/// Many batches of edges, each of which takes a while with "sleeps_in_evaluate".
std::string manyEdges() {
  std::string text = kVertices;
  for (int i = 0; i < 40000; ++i) text += "FAULTY_EDGE 0 1 1 1 1 0 1\n";
  return text;
}

TEST(LongCalls, ACallThatNeverReturnsEndsWithTheTimeLimit) {
  const Optimized run("hangs_in_evaluate", "--time-limit 0.1 --threads 2");
  EXPECT_EQ(run.result.exit_code, 7) << run.result.err;
  EXPECT_TRUE(std::regex_search(
      run.result.err,
      std::regex("libgraft_faulty\\.so: error: FAULTY_EDGE: evaluate\\(\\) has not returned for "
                 "[0-9]+ s, the time limit of 0.1 s is over")))
      << run.result.err;
  EXPECT_EQ(run.output(), "earlier result");
  EXPECT_EQ(run.strangers(), 0);
}

TEST(LongCalls, ALoaderThatCallsBackIsNoHang) {
  const Optimized run("loads_slowly", "--plugin-patience 0.5", "FAULTY\n", "g.faulty");
  EXPECT_EQ(run.result.exit_code, 3) << run.result.err;
  EXPECT_NE(run.result.err.find("this format holds nothing"), std::string::npos) << run.result.err;
}

/// What ends a resource's life comes after the outputs.
TEST(LongCalls, ACrashAtTheEndIsNamedAndTheOutputIsThere) {
  if (detail::sanitizerBits() != 0) GTEST_SKIP() << "the sanitizer reports crashes";
  const Optimized run("crashes_in_destroy");
  EXPECT_EQ(run.result.exit_code, 7) << run.result.err;
  EXPECT_NE(run.result.err.find("error: FAULTY_NUMBER: destroy() crashed: signal 11"),
            std::string::npos)
      << run.result.err;
  EXPECT_NE(run.output().find("FAULTY_POINT 2 "), std::string::npos) << run.output();
}

TEST(LongCalls, SlowCallsAreNoHang) {
  // The limit comes in the first evaluation; the best so far is what the file gave.
  const Optimized run("sleeps_in_evaluate", "--time-limit 0.01 --initial-guess file");
  EXPECT_EQ(run.result.exit_code, 0) << run.result.err;
  EXPECT_NE(run.result.out.find("time_limit"), std::string::npos) << run.result.out;
}

/// Starts a program in the background, waits until it has loaded the faulty plugin, and
/// sends SIGTERM `times` times.
testing::CommandResult terminated(const std::string& folder, const std::string& fault, int times) {
  const std::string binary = testing::binaryDirectory();
  std::string script =
      "cd " + folder + " && GRAFT_TEST_FAULT=" + fault + " timeout -s KILL 60 " + binary +
      "/bin/graft optimize g.g2o -o out.g2o --json - --threads 2 " +
      "--initial-guess file --plugin " + binary +
      "/lib/graft/faulty/libgraft_faulty.so & outer=$!\n" +
      "pid=\n"
      "until [ -n \"$pid\" ] && grep -q libgraft_faulty /proc/$pid/maps; do\n"
      "  sleep 0.05; pid=$(cat /proc/$outer/task/$outer/children); pid=${pid%% *}\n"
      "done; sleep 0.3\n";
  for (int i = 0; i < times; ++i) script += "kill -TERM $pid; sleep 0.7\n";
  return testing::runCommand(script + "wait $outer");
}

TEST(LongCalls, AnInterruptEndsAnEvaluationBetweenTwoBatches) {
  const std::string folder = testing::makeTemporaryDirectory();
  testing::writeTestFile(folder, "g.g2o", manyEdges());
  const testing::CommandResult result = terminated(folder, "sleeps_in_evaluate", 1);
  EXPECT_EQ(result.exit_code, 143) << result.err;
  EXPECT_NE(result.out.find("\"status\": \"interrupted\""), std::string::npos) << result.out;
  // The first evaluation alone takes longer: it was not finished.
  EXPECT_NE(result.out.find("\"chi2_initial\": null"), std::string::npos) << result.out;
  EXPECT_NE(testing::readTestFile(folder + "/out.g2o").find("FAULTY_POINT 2 3 2"),
            std::string::npos);
}

TEST(LongCalls, ASecondSignalEndsACallThatNeverReturns) {
  const std::string folder = testing::makeTemporaryDirectory();
  testing::writeTestFile(folder, "g.g2o", kVertices + kEdges);
  testing::writeTestFile(folder, "out.g2o", "earlier result");
  const testing::CommandResult result = terminated(folder, "hangs_in_evaluate", 2);
  EXPECT_EQ(result.exit_code, 143) << result.err;
  EXPECT_NE(result.err.find("libgraft_faulty.so: error: FAULTY_EDGE: evaluate() was running when a "
                            "second signal ended the program"),
            std::string::npos)
      << result.err;
  EXPECT_EQ(testing::readTestFile(folder + "/out.g2o"), "earlier result");
}

}  // namespace
}  // namespace graft
