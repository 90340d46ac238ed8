// SPDX-License-Identifier: BSD-3-Clause
// Outputs: atomic, canonical, independent of locale and threads; signals.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

namespace fs = std::filesystem;

testing::CommandResult graft(const std::string& arguments, const std::string& before = "") {
  return testing::runCommand(before + testing::binaryDirectory() + "/bin/graft " + arguments);
}

/// A loop of poses in the plane with noisy measurements and poor estimates.
std::vector<std::string> ringLines(int n) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> noise(-0.05, 0.05);
  std::vector<std::string> lines;
  for (int i = 0; i < n; ++i) {
    lines.push_back("VERTEX_SE2 " + std::to_string(i) + ' ' + std::to_string(i * 0.9) + ' ' +
                    std::to_string(noise(random)) + " 0.1");
    lines.push_back("EDGE_SE2 " + std::to_string(i) + ' ' + std::to_string((i + 1) % n) + ' ' +
                    std::to_string(1 + noise(random)) + ' ' + std::to_string(noise(random)) + ' ' +
                    std::to_string(6.283185307 / n + 0.1 * noise(random)) + " 10 1 0 20 0 300");
  }
  return lines;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

TEST(Outputs, DoNotDependOnThreadsOrTheOrderOfLines) {
  const std::string folder = testing::makeTemporaryDirectory();
  std::vector<std::string> lines = ringLines(300);
  std::mt19937_64 random(5);
  std::string first;
  for (const char* threads : {"1", "2", "3", "8"}) {
    const std::string in = testing::writeTestFile(folder, "in.g2o", joined(lines));
    const testing::CommandResult result =
        graft("optimize " + in + " -o " + folder + "/out.g2o --threads " + threads);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const std::string out = testing::readTestFile(folder + "/out.g2o");
    if (first.empty()) first = out;
    EXPECT_EQ(out, first) << threads;
    std::shuffle(lines.begin(), lines.end(), random);
  }
}

TEST(Outputs, AreCanonical) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string in = testing::writeTestFile(folder, "in.g2o", joined(ringLines(20)));
  ASSERT_EQ(graft("convert " + in + " -o " + folder + "/a.g2o").exit_code, 0);
  ASSERT_EQ(graft("convert " + folder + "/a.g2o -o " + folder + "/b.g2o").exit_code, 0);
  EXPECT_EQ(testing::readTestFile(folder + "/a.g2o"), testing::readTestFile(folder + "/b.g2o"));
}

TEST(Outputs, DoNotDependOnTheLocale) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string in = testing::writeTestFile(folder, "in.g2o", joined(ringLines(20)));
  const std::string locale = "localedef -i de_DE -f UTF-8 " + folder + "/de_DE.UTF-8 2>/dev/null";
  if (testing::runCommand(locale).exit_code != 0) GTEST_SKIP() << "no source of a German locale";
  ASSERT_EQ(graft("optimize " + in + " -o " + folder + "/a.g2o").exit_code, 0);
  ASSERT_EQ(graft("optimize " + in + " -o " + folder + "/b.g2o",
                  "LOCPATH=" + folder + " LC_ALL=de_DE.UTF-8 ")
                .exit_code,
            0);
  EXPECT_EQ(testing::readTestFile(folder + "/a.g2o"), testing::readTestFile(folder + "/b.g2o"));
}

TEST(Outputs, ReplaceALinkInsteadOfFollowingIt) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string in = testing::writeTestFile(folder, "in.g2o", joined(ringLines(5)));
  const std::string victim = testing::writeTestFile(folder, "victim", "precious");
  fs::create_symlink(victim, folder + "/out.g2o");
  ASSERT_EQ(graft("optimize " + in + " -o " + folder + "/out.g2o").exit_code, 0);
  EXPECT_EQ(testing::readTestFile(victim), "precious");
  EXPECT_FALSE(fs::is_symlink(folder + "/out.g2o"));
}

TEST(Outputs, MayReplaceTheInput) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string in = testing::writeTestFile(folder, "in.g2o", joined(ringLines(5)));
  ASSERT_EQ(graft("optimize " + in + " -o " + in).exit_code, 0);
  EXPECT_EQ(graft("check " + in).exit_code, 0);
}

TEST(Outputs, AnInterruptedRunSavesTheBestAndSaysSo) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string in = testing::writeTestFile(folder, "in.g2o", joined(ringLines(20000)));
  const std::string out = folder + "/out.g2o";
  for (const auto& [signal, code] : {std::pair{"INT", 130}, {"TERM", 143}}) {
    fs::remove(out);
    // A background job of a script ignores SIGINT unless told otherwise.
    const testing::CommandResult result =
        testing::runCommand("timeout --preserve-status -s " + std::string(signal) + " 0.4 " +
                            testing::binaryDirectory() + "/bin/graft optimize " + in + " -o " +
                            out + " --iterations 100000 --initial-guess file --json -");
    if (result.exit_code == 0) GTEST_SKIP() << "done before the signal came";
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.out.find("\"status\": \"interrupted\""), std::string::npos) << result.out;
    EXPECT_EQ(graft("check " + out).exit_code, 0);
  }
}

TEST(Outputs, TheTimeLimitStopsWithAUsableResult) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string in = testing::writeTestFile(folder, "in.g2o", joined(ringLines(2000)));
  const testing::CommandResult result =
      graft("optimize " + in + " --initial-guess file --time-limit 1e-9 --json -");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.out.find("\"status\": \"time_limit\""), std::string::npos) << result.out;
}

TEST(Outputs, CovariancesHaveALinePerVertex) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string in = testing::writeTestFile(
      folder, "in.g2o",
      "VERTEX_SE2 0 0 0 0\nFIX 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 4 0 0 16 0 64\n");
  const testing::CommandResult result = graft("optimize " + in + " --covariance -");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "VERTEX_SE2 0 0 0 0 0 0 0\nVERTEX_SE2 1 0.25 0 0 0.0625 0 0.015625\n");
}

}  // namespace
}  // namespace graft
