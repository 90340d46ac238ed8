// SPDX-License-Identifier: BSD-3-Clause
// Edges that may be wrong: kernels by tag and by file, levels, graduated non-convexity.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

/// A point's prior at 0 and two sightings of it; with widths so small that Huber is |e|.
const std::string kPoses =
    "VERTEX_SE2 0 0 0 0\nFIX 0\nVERTEX_SE2 1 0.4 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
const std::string kFar = "EDGE_SE2 0 1 4 0 0 1 0 0 1 0 1\n";

class Robust : public ::testing::Test {
 protected:
  testing::CommandResult graft(const std::string& arguments) const {
    return testing::runCommand(testing::binaryDirectory() + "/bin/graft " + arguments);
  }
  std::string file(const std::string& text) const {
    return testing::writeTestFile(folder_, "g.g2o", text);
  }
  /// x of vertex 1 in what optimize writes.
  double solved(const std::string& text, const std::string& options = "") {
    const testing::CommandResult result =
        graft("optimize " + file(text) + " -o " + folder_ + "/out.g2o " + options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    written_ = testing::readTestFile(folder_ + "/out.g2o");
    const std::size_t at = written_.find("VERTEX_SE2 1 ");
    return std::stod(written_.substr(at + 13));
  }

  std::string folder_ = testing::makeTemporaryDirectory();
  std::string written_;
};

/// Reweighting nears the minimum step by step and ends when chi2 changes by 1e-10.
constexpr double kReweighted = 1e-4;

TEST_F(Robust, KernelsFromTheFileAndFromOptions) {
  // Two pulls: 1 - x + (4 - x) = 0; with Huber of width w on the far one: x - 1 = w.
  EXPECT_NEAR(solved(kPoses + kFar), 2.5, kReweighted);
  EXPECT_NEAR(solved(kPoses + kFar + "ROBUST_KERNEL Huber 0.5\n"), 1.5, kReweighted);
  EXPECT_NE(written_.find("ROBUST_KERNEL Huber 0.5\n"), std::string::npos);
  EXPECT_NEAR(solved(kPoses + kFar + "ROBUST_KERNEL Huber 0.5\n", "--robust-kernel none"), 2.5,
              kReweighted);
  // What an option says is not written: the graph keeps its own.
  EXPECT_NE(written_.find("ROBUST_KERNEL Huber 0.5\n"), std::string::npos);
  EXPECT_NEAR(
      solved(kPoses + kFar, "--initial-guess file --robust-kernel Saturated --kernel-width 1.4"), 1,
      kReweighted);
  EXPECT_EQ(written_.find("ROBUST_KERNEL"), std::string::npos);
  EXPECT_NEAR(solved(kPoses + kFar, "--initial-guess file --robust-kernel EDGE_SE2=Saturated:1.4"),
              1, kReweighted);
}

TEST_F(Robust, KernelsByTagStandBesideThoseForAll) {
  const std::string prior = "EDGE_PRIOR_SE2 1 7 0 0 1 0 0 1 0 1\n";
  const std::string text = kPoses + prior;
  EXPECT_NEAR(solved(text), 4, kReweighted);
  EXPECT_NEAR(solved(text, "--robust-kernel EDGE_PRIOR_SE2=Huber:0.5"), 1.5, kReweighted);
  EXPECT_NEAR(solved(text, "--robust-kernel EDGE_PRIOR_SE2=Huber --kernel-width 0.25"), 1.25,
              kReweighted);
  EXPECT_NEAR(solved(text, "--robust-kernel EDGE_SE2=Huber:0.5"), 6.5, kReweighted);
  for (const char* options : {"--robust-kernel EDGE_SE2=none --robust-kernel Huber:0.5",
                              "--robust-kernel Huber:0.5 --robust-kernel EDGE_SE2=none"}) {
    EXPECT_NEAR(solved(text, options), 1.5, kReweighted) << options;
  }
  EXPECT_NEAR(solved(text,
                     "--robust-kernel EDGE_SE2=Huber:0.1 --robust-kernel "
                     "EDGE_PRIOR_SE2=Huber:0.2 --initial-guess file"),
              7, 0.2);
}

TEST_F(Robust, LevelsFromTheFile) {
  const std::string text = kPoses + kFar + "G2O_EDGE_LEVEL 1\n";
  EXPECT_NEAR(solved(text), 1, 1e-9);
  EXPECT_NE(written_.find("G2O_EDGE_LEVEL 1\n"), std::string::npos);
  EXPECT_NEAR(solved(text, "--level 1"), 4, 1e-9);
  EXPECT_NEAR(solved(text, "--level all"), 2.5, 1e-9);
  EXPECT_NEAR(solved(text, "--level 5"), 0.4, 1e-12);
  // The covariance is that of the edges that were solved: I, and I/2 for both.
  for (const char* options : {"", "--level 1", "--level all"}) {
    ASSERT_EQ(graft("optimize " + file(text) + " --covariance " + folder_ + "/c.txt " + options)
                  .exit_code,
              0);
    const std::string covariance = testing::readTestFile(folder_ + "/c.txt");
    const double variance = std::stod(covariance.substr(covariance.find("VERTEX_SE2 1 ") + 13));
    EXPECT_NEAR(variance, std::string(options) == "--level all" ? 0.5 : 1, 1e-12);
  }
}

/// A closed walk of 12 poses, a true and a false closure.
std::string walk() {
  std::string text;
  const auto pose = [](int i) {
    const double angle = 2 * 3.141592653589793 * i / 12;
    return std::to_string(4 * std::cos(angle)) + ' ' + std::to_string(4 * std::sin(angle)) + " 0";
  };
  const auto edge = [](int a, int b, double off) {
    const auto at = [](int i, bool sine) {
      const double angle = 2 * 3.141592653589793 * i / 12;
      return 4 * (sine ? std::sin(angle) : std::cos(angle));
    };
    return "EDGE_SE2 " + std::to_string(a) + ' ' + std::to_string(b) + ' ' +
           std::to_string(at(b, false) - at(a, false) + off) + ' ' +
           std::to_string(at(b, true) - at(a, true)) + " 0 100 0 0 100 0 400\n";
  };
  for (int i = 0; i < 12; ++i) text += "VERTEX_SE2 " + std::to_string(i) + ' ' + pose(i) + '\n';
  for (int i = 0; i < 11; ++i) text += edge(i, i + 1, 0.01 * (i % 3 - 1));
  return text + edge(0, 11, 0) + edge(2, 8, 5);
}

TEST_F(Robust, GraduationNamesWhatItSwitchesOff) {
  for (const std::string kind : {"tls", "gm"}) {
    const testing::CommandResult result =
        graft("optimize " + file(walk()) + " --gnc " + kind + " --json -");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto gnc = nlohmann::json::parse(result.out)["gnc"];
    EXPECT_EQ(gnc["kind"], kind);
    EXPECT_EQ(gnc["candidates"], 2);
    ASSERT_EQ(gnc["off"].size(), 1u);
    EXPECT_EQ(gnc["off"][0]["tag"], "EDGE_SE2");
    EXPECT_EQ(gnc["off"][0]["ids"], (std::vector<int>{2, 8}));
    EXPECT_EQ(gnc["off"][0]["line"], 25);
    EXPECT_EQ(gnc["off"][0]["weight"], 0);
    EXPECT_GT(gnc["off"][0]["chi2"], 1000);
    EXPECT_NEAR(gnc["off"][0]["threshold"].get<double>(), 11.3449, 1e-4);
    EXPECT_NE(result.err.find("1 of 2 edges switched off"), std::string::npos) << result.err;
  }
  const testing::CommandResult trusting =
      graft("optimize " + file(walk()) + " --gnc tls --gnc-trust EDGE_SE2 --json -");
  EXPECT_EQ(nlohmann::json::parse(trusting.out)["gnc"]["candidates"], 0);
  const testing::CommandResult both =
      graft("optimize " + file(walk()) +
            " --gnc tls --gnc-trust consecutive --gnc-trust EDGE_SE2 --json -");
  EXPECT_EQ(nlohmann::json::parse(both.out)["gnc"]["candidates"], 0);
  const testing::CommandResult wary =
      graft("optimize " + file(walk()) + " --gnc tls --gnc-trust none --json -");
  EXPECT_EQ(nlohmann::json::parse(wary.out)["gnc"]["candidates"], 13);
}

TEST_F(Robust, GraduationCanMarkWhatItSwitchesOff) {
  const std::string out = folder_ + "/out.g2o";
  ASSERT_EQ(graft("optimize " + file(walk()) + " --gnc tls -o " + out).exit_code, 0);
  EXPECT_EQ(testing::readTestFile(out).find("G2O_EDGE_LEVEL"), std::string::npos);
  const testing::CommandResult result =
      graft("optimize " + file(walk()) + " --gnc tls --gnc-level 3 --json - -o " + out);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(testing::readTestFile(out).find("EDGE_SE2 2 8 "), std::string::npos);
  EXPECT_NE(testing::readTestFile(out).find("G2O_EDGE_LEVEL 3\n"), std::string::npos);
  // The output is a graph at its optimum.
  const testing::CommandResult again = graft("optimize " + out + " --json -");
  const double chi2 = nlohmann::json::parse(result.out)["chi2_final"];
  EXPECT_NEAR(nlohmann::json::parse(again.out)["chi2_initial"].get<double>(), chi2, 1e-9);
  EXPECT_NEAR(nlohmann::json::parse(again.out)["chi2_final"].get<double>(), chi2, 1e-9);
}

}  // namespace
}  // namespace graft
