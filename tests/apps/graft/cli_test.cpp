// SPDX-License-Identifier: BSD-3-Clause
// The command line: usage errors, plugins by option, listings.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

const std::string kSquare =
    "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nFIX 0\nEDGE_SE2 0 1 2 0 0 1 0 0 1 0 1\n";

testing::CommandResult graft(const std::string& arguments, const std::string& before = "") {
  return testing::runCommand(before + testing::binaryDirectory() + "/bin/graft " + arguments);
}

std::string square() {
  return testing::writeTestFile(testing::makeTemporaryDirectory(), "g.g2o", kSquare);
}

struct UsageCase {
  const char* arguments;  ///< IN stands for a good file
  int exit_code;
  const char* message;
};

TEST(Cli, WrongUseIsSaid) {
  const UsageCase cases[] = {
      {"", 2, "subcommand is required"},
      {"optimise IN", 2, "graft --help"},
      {"optimize", 2, "IN is required"},
      {"optimize IN --bogus", 2, "--bogus"},
      {"optimize IN extra", 2, "extra"},
      {"optimize IN --iterations abc", 2, "--iterations"},
      {"optimize IN --iterations -5", 2, "--iterations"},
      {"optimize IN --iterations 99999999999", 2, "--iterations"},
      {"optimize IN --iterations", 2, "--iterations"},
      {"optimize IN --algorithm newton", 2, "--algorithm"},
      {"optimize IN --initial-guess luck", 2, "--initial-guess"},
      {"optimize IN --information maybe", 2, "--information"},
      {"optimize IN --threads 0", 2, "--threads: expected 'all' or a number"},
      {"optimize IN --threads 1000000", 2, "--threads"},
      {"optimize IN --threads x", 2, "--threads"},
      {"optimize IN --time-limit -1", 2, "--time-limit"},
      {"optimize IN --robust-kernel Hubert", 2, "unknown robust kernel 'Hubert' .*Huber"},
      {"optimize IN --robust-kernel Huber --kernel-width 0", 2, "--kernel-width"},
      {"optimize IN --robust-kernel Huber --kernel-width nan", 2, "--kernel-width"},
      {"optimize IN --kernel-width 1", 2, "--robust-kernel"},
      {"optimize IN --robust-kernel Huber:0", 2, "--robust-kernel: expected a positive number"},
      {"optimize IN --robust-kernel EDGE_SE2=Huber:x", 2, "--robust-kernel: expected a positive"},
      {"optimize IN --robust-kernel EDGE_SE2=Hubert", 2, "unknown robust kernel 'Hubert'"},
      {"optimize IN --robust-kernel =Huber", 2, "--robust-kernel: no tag before '='"},
      {"optimize IN --robust-kernel EDGE_SE3=Huber", 2, "no edge has the tag 'EDGE_SE3'"},
      {"optimize IN --robust-kernel Huber --robust-kernel Cauchy", 2, "two kernels for all edges"},
      {"optimize IN --level -1", 2, "--level: expected 'all' or a number from 0, got '-1'"},
      {"optimize IN --level x", 2, "--level: expected"},
      {"optimize IN --gnc huber", 2, "--gnc"},
      {"optimize IN --gnc tls --robust-kernel Huber", 2, "--gnc excludes --robust-kernel|excludes"},
      {"optimize IN --gnc-trust none", 2, "--gnc"},
      {"optimize IN --gnc-inlier-probability 0.9", 2, "--gnc"},
      {"optimize IN --gnc-level 1", 2, "--gnc"},
      {"optimize IN --gnc tls --gnc-inlier-probability 1", 2, "number between 0 and 1"},
      {"optimize IN --gnc tls --gnc-inlier-probability 0", 2, "number between 0 and 1"},
      {"optimize IN --gnc tls --gnc-inlier-probability nan", 2, "gnc-inlier-probability"},
      {"optimize IN --gnc tls --gnc-trust EDGE_SE3", 2, "no edge has the tag 'EDGE_SE3'"},
      {"optimize IN --gnc tls --gnc-trust none --gnc-trust EDGE_SE2", 2, "none cannot be combined"},
      {"optimize IN --gnc tls --gnc-noise loud", 2, "--gnc-noise"},
      {"optimize IN --gnc tls --gnc-level 0", 2, "--gnc-level"},
      {"optimize IN --linear-solver magic", 2, "unknown linear solver 'magic' \\(known: block"},
      {"optimize IN -o - --json -", 2, "only one of"},
      {"optimize /nonexistent.g2o", 3, "/nonexistent.g2o: error: No such file"},
      {"optimize /", 3, "/: error: is a directory"},
      {"optimize IN -o /nonexistent/out.g2o", 5, "/nonexistent/out.g2o: error: No such file"},
      {"optimize IN -o /dev/full", 5, "No space left"},
      {"optimize IN --json /dev/full", 5, "No space left"},
      {"optimize IN > /dev/full", 5, "cannot write the results"},
      {"optimize IN --plugin nowhere", 7, "no plugin named 'nowhere' \\(known: "},
      {"optimize IN --plugin /nonexistent.so", 7, "No such file"},
      {"optimize IN --plugin IN", 7, "not a plugin: it is no ELF file"},
      {"types UNHEARD_OF", 2, "no known plugin provides 'UNHEARD_OF'"},
      {"convert IN", 2, "--output is required"},
      {"check IN --plugin /lib/x86_64-linux-gnu/libc.so.6", 7, "no section|No such file"},
  };
  const std::string in = square();
  for (const UsageCase& one : cases) {
    const std::string arguments = std::regex_replace(one.arguments, std::regex("IN"), in);
    const testing::CommandResult result = graft(arguments);
    EXPECT_EQ(result.exit_code, one.exit_code) << one.arguments << '\n' << result.err;
    EXPECT_TRUE(std::regex_search(result.err, std::regex(one.message))) << one.arguments << '\n'
                                                                        << result.err;
  }
}

TEST(Cli, HelpAndVersion) {
  EXPECT_EQ(graft("--version").exit_code, 0);
  EXPECT_NE(graft("--help").out.find("optimize"), std::string::npos);
  const std::string help = graft("optimize --help").out;
  for (const char* option : {"--output",
                             "--iterations",
                             "--algorithm",
                             "--linear-solver",
                             "--plugin",
                             "--robust-kernel",
                             "--kernel-width",
                             "--initial-guess",
                             "--lenient",
                             "--information",
                             "--time-limit",
                             "--threads",
                             "--covariance",
                             "--json",
                             "--level",
                             "--gnc",
                             "--gnc-trust",
                             "--gnc-noise",
                             "--gnc-inlier-probability",
                             "--gnc-level"}) {
    EXPECT_NE(help.find(option), std::string::npos) << option;
  }
}

TEST(Cli, JsonHasExactlyTheseKeys) {
  const testing::CommandResult result = graft("optimize " + square() + " --json -");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto document = nlohmann::json::parse(result.out);
  std::set<std::string> keys;
  for (const auto& item : document.items()) keys.insert(item.key());
  EXPECT_EQ(keys, (std::set<std::string>{"status",        "reason",
                                         "iterations",    "chi2_initial",
                                         "chi2_final",    "vertices",
                                         "edges",         "threads",
                                         "seconds",       "start",
                                         "chi2_start",    "chi2_by_tag",
                                         "linear_solver", "ordering",
                                         "factor_flops",  "factor_bytes",
                                         "alternatives",  "associations_changed",
                                         "inner_parts",   "notes",
                                         "phases",        "log"}));
  keys.clear();
  for (const auto& item : document["seconds"].items()) keys.insert(item.key());
  EXPECT_EQ(keys, (std::set<std::string>{"load", "initial_guess", "solve", "write", "total"}));
  EXPECT_EQ(document["status"], "converged");
  EXPECT_EQ(document["chi2_initial"], 1.0);
  EXPECT_EQ(document["chi2_final"], 0.0);
  EXPECT_EQ(document["vertices"], 2);
  EXPECT_GE(document["seconds"]["total"], document["seconds"]["solve"]);
}

TEST(Cli, TheLogTellsEveryIterationInJsonAndInTheSummary) {
  const std::string path = testing::makeTemporaryDirectory() + "/g.g2o";
  ASSERT_EQ(graft("simulate manhattan --size 60 --seed 3 -o " + path).exit_code, 0);
  const std::string json = path + ".json";
  const testing::CommandResult result = graft("optimize " + path + " --json " + json);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto document = nlohmann::json::parse(testing::readTestFile(json));
  // One of the names that --initial-guess takes.
  const std::string start = document["start"];
  EXPECT_EQ(graft("optimize " + path + " --initial-guess " + start).exit_code, 0) << start;
  EXPECT_NE(start, "file");
  const auto& log = document["log"];
  ASSERT_EQ(log.size(), document["iterations"].get<std::size_t>() + 1);
  EXPECT_EQ(log.front()["chi2"], document["chi2_start"]);
  EXPECT_EQ(log.back()["chi2"], document["chi2_final"]);
  double chi2 = 0;
  for (const auto& share : document["chi2_by_tag"]) chi2 += share.get<double>();
  EXPECT_NEAR(chi2, document["chi2_final"].get<double>(), 1e-9 * chi2);
  for (std::size_t i = 1; i < log.size(); ++i) {
    EXPECT_NEAR(log[i - 1]["chi2"].get<double>() - log[i]["chi2"].get<double>(),
                log[i]["chi2_change"].get<double>(), 1e-9 * log[0]["chi2"].get<double>());
    EXPECT_GE(log[i]["factorizations"], 1);
    EXPECT_NE(result.out.find("\n    " + std::to_string(i) + " "), std::string::npos) << result.out;
  }
  EXPECT_NE(result.out.find("factorize "), std::string::npos) << result.out;
}

TEST(Cli, Chi2InitialIsNullWithoutVertices) {
  const std::string path = testing::writeTestFile(testing::makeTemporaryDirectory(), "g.g2o",
                                                  "EDGE_SE2 0 1 2 0 0 1 0 0 1 0 1\n");
  const testing::CommandResult result = graft("optimize " + path + " --json -");
  EXPECT_TRUE(nlohmann::json::parse(result.out)["chi2_initial"].is_null());
}

TEST(Cli, ReadsStandardInput) {
  const testing::CommandResult result = graft("optimize - -o - < " + square());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out,
            "VERTEX_SE2 0 0 0 0\nFIX 0\nVERTEX_SE2 1 2 0 0\n"
            "EDGE_SE2 0 1 2 0 0 1 0 0 1 0 1\n");
}

TEST(Cli, AFileNeverLoadsCodeFromOutsideTheTrustedFolders) {
  const std::string bad = testing::binaryDirectory() + "/lib/graft/bad";
  const std::string good = square();
  EXPECT_EQ(graft("optimize " + good + " --robust-kernel Good_fine").exit_code, 2);
  EXPECT_EQ(graft("types Good_fine").exit_code, 2);
  EXPECT_EQ(graft("types Good_fine --plugin " + bad + "/libgraft_fine.so").exit_code, 0);
}

TEST(Cli, TypesAndPluginsDescribeWhatIsThere) {
  const std::string types = graft("types").out;
  EXPECT_NE(types.find("EDGE_SE3:QUAT id1 id2 x y z qx qy qz qw information (21 numbers"),
            std::string::npos)
      << types;
  EXPECT_NE(graft("types Huber").out.find("kernel Huber: quadratic"), std::string::npos);
  const testing::CommandResult plugins = graft("plugins");
  EXPECT_NE(plugins.out.find("slam3d 0"), std::string::npos);
  EXPECT_NE(plugins.out.find("edge EDGE_SE3:QUAT"), std::string::npos);
  EXPECT_NE(plugins.out.find("license BSD-3-Clause"), std::string::npos);
}

TEST(Cli, CheckCountsAndNamesLooseComponents) {
  const std::string text = kSquare + "VERTEX_SE2 7 0 0 0\nVERTEX_SE2 8 0 0 0\n" +
                           "EDGE_SE2 7 8 2 0 0 1 0 0 1 0 1\nEDGE_SE2 7 8 2 0 0 1 0 0 1 0 1\n";
  const std::string path = testing::writeTestFile(testing::makeTemporaryDirectory(), "g.g2o", text);
  const std::string out = graft("check " + path).out;
  EXPECT_NE(out.find("4 VERTEX_SE2"), std::string::npos) << out;
  EXPECT_NE(out.find("2 connected components"), std::string::npos);
  EXPECT_NE(out.find("component of vertex 7 (2 vertices) is not anchored"), std::string::npos);
  EXPECT_NE(out.find("1 edges between the same vertices"), std::string::npos);
}

}  // namespace
}  // namespace graft
