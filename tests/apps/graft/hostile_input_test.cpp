// SPDX-License-Identifier: BSD-3-Clause
// Inputs and surroundings that are made to hurt: cut, endless, huge or random files, and
// a system that has no more memory, threads, stack or disk.
#include <gtest/gtest.h>

#include <random>
#include <regex>
#include <sstream>

#include "core/types/stamp.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

const std::string kVertices = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n";
const std::string kEdge =
    "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";

class Hostile : public ::testing::Test {
 protected:
  testing::CommandResult run(const std::string& arguments, const std::string& before = "",
                             const std::string& environment = "") {
    return testing::runCommand("cd " + folder_ + " && " + before + " timeout -s KILL 120 env " +
                               environment + " " + testing::binaryDirectory() + "/bin/graft " +
                               arguments);
  }
  testing::CommandResult check(const std::string& text) {
    testing::writeTestFile(folder_, "in.g2o", text);
    return run("check in.g2o");
  }
  std::string folder_ = testing::makeTemporaryDirectory();
};

TEST_F(Hostile, ARecordCutAfterAnyFieldIsRefusedWithTheCount) {
  for (const std::string& record : {std::string("VERTEX_SE3:QUAT 1 1 0 0 0 0 0 1"), kEdge}) {
    std::istringstream fields(record);
    std::string cut, field;
    fields >> cut;
    int count = 0;
    while (fields >> field) {
      const bool edge = record == kEdge;
      const testing::CommandResult result = check((edge ? kVertices : "") + cut + "\n");
      EXPECT_EQ(result.exit_code, 3) << cut;
      const std::string said = count == 0 || (edge && count == 1)
                                   ? "expected id, the line ends"
                                   : "fields, got " + std::to_string(count);
      EXPECT_NE(result.err.find(said), std::string::npos) << cut << '\n' << result.err;
      cut += ' ' + field;
      ++count;
    }
  }
}

bool isUtf8(const std::string& text) {
  return testing::runCommand("iconv -f UTF-8 -t UTF-16 > /dev/null <<'END'\n" + text + "\nEND")
             .exit_code == 0;
}

TEST_F(Hostile, RandomBytesGiveOneShortMessage) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 30; ++i) {
    std::string bytes = i == 0 ? std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16) : std::string();
    while (bytes.size() < 4096) bytes += char(random() & 0xff);
    const testing::CommandResult result = check(bytes);
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_LT(result.err.size(), 10000u);
    // No control byte, and no byte outside a well-formed character, reaches a terminal.
    for (const char c : result.err) {
      EXPECT_TRUE(c == '\n' || c < 0 || (c >= ' ' && c != 0x7f)) << int(c);
    }
    EXPECT_TRUE(isUtf8(result.err)) << result.err;
  }
}

TEST_F(Hostile, EndlessAndSpecialFilesEnd) {
  testing::CommandResult result = run("check /dev/zero");
  EXPECT_EQ(result.exit_code, 6) << result.err;
  EXPECT_NE(result.err.find("/dev/zero: error: larger than the limit"), std::string::npos);
  EXPECT_EQ(run("check /dev/null").exit_code, 3);
  EXPECT_EQ(run("check /proc/self/mem").exit_code, 3);
  result = testing::runCommand(testing::binaryDirectory() + "/bin/graft check - <&-");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.err.find("<stdin>: error: read failed"), std::string::npos) << result.err;
}

// Address space is the sanitizers' own.
#define GRAFT_SKIP_WITH_SANITIZER() \
  if (detail::sanitizerBits() != 0) GTEST_SKIP() << "not with a sanitizer"

TEST_F(Hostile, HugeLinesAndAMillionUnknownTagsNeedLittleMemory) {
  GRAFT_SKIP_WITH_SANITIZER();
  const std::string limit = "ulimit -v 300000;";
  testing::writeTestFile(folder_, "comment.g2o",
                         "# " + std::string(50000000, 'x') + "\n" + kVertices + kEdge);
  EXPECT_EQ(run("check comment.g2o", limit).exit_code, 0);
  std::string record = "VERTEX_XY 0 ";
  for (int i = 0; i < 20000000; ++i) record += "1 ";
  testing::writeTestFile(folder_, "record.g2o", record);
  testing::CommandResult result = run("check record.g2o", limit);
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_LT(result.err.size(), 1000u);
  std::string tags;
  for (int i = 0; i < 1000000; ++i) tags += "TAG_" + std::to_string(i) + " 1\n";
  testing::writeTestFile(folder_, "tags.g2o", tags);
  result = run("check tags.g2o", limit);
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.err.find("and 999980 more errors"), std::string::npos);
}

TEST_F(Hostile, NumbersOfAnyLengthAreTheNearestDouble) {
  const std::string thirds = "0." + std::string(100000, '3');
  testing::writeTestFile(folder_, "in.g2o",
                         "VERTEX_XY 0 " + thirds + " -0.0\nVERTEX_XY 1 4e-320 1e-999\n");
  EXPECT_EQ(run("convert in.g2o -o -").out,
            "VERTEX_XY 0 0.3333333333333333 -0\nVERTEX_XY 1 4e-320 0\n");
}

TEST_F(Hostile, IdsMayBeSparse) {
  testing::writeTestFile(folder_, "in.g2o",
                         "VERTEX_XY 0 0 0\nFIX 0\nVERTEX_XY 9000000000000000000 5 5\n"
                         "EDGE_POINTXY 0 9000000000000000000 1 2 1 0 1\n");
  const testing::CommandResult result = run("optimize in.g2o -o -");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("VERTEX_XY 9000000000000000000 1 2\n"), std::string::npos);
}

TEST_F(Hostile, EdgesGivenTwiceCountTwice) {
  const std::string edge = "EDGE_POINTXY 0 1 1 2 1 0 1\n";
  testing::writeTestFile(
      folder_, "in.g2o",
      "VERTEX_XY 0 0 0\nFIX 0\nVERTEX_XY 1 0 0\n" + edge + edge + "EDGE_POINTXY 0 1 4 2 1 0 1\n");
  const testing::CommandResult result = run("optimize in.g2o --algorithm gn -o -");
  // (1 + 1 + 4) / 3
  const std::size_t at = result.out.find("VERTEX_XY 1 ");
  ASSERT_NE(at, std::string::npos) << result.out;
  EXPECT_NEAR(std::stod(result.out.substr(at + 12)), 2, 1e-9);
}

TEST_F(Hostile, WhatIsNotSolvedForStaysAsItWas) {
  const std::string all =
      "VERTEX_XY 0 0.1 0\nFIX 0\nVERTEX_XY 1 7 0.3\nFIX 1\nVERTEX_XY 8 1 1\n"
      "EDGE_POINTXY 0 1 1 2 1 0 1\n";
  testing::writeTestFile(folder_, "in.g2o", all);
  EXPECT_EQ(run("optimize in.g2o -o -").out, all);
  const std::string loose = std::regex_replace(all, std::regex("FIX 1\n"), "");
  testing::writeTestFile(folder_, "in.g2o", loose);
  EXPECT_EQ(run("optimize in.g2o --iterations 0 --initial-guess file -o -").out, loose);
}

TEST_F(Hostile, SignsOfQuaternionsDoNotMatter) {
  const auto graph = [](int signs) {
    const auto q = [signs](int bit, const char* positive, const char* negative) {
      return std::string((signs >> bit & 1) != 0 ? negative : positive) + "\n";
    };
    const std::string edge = kEdge.substr(0, kEdge.find(" 1 0 0 0 0 0 1"));
    return "VERTEX_SE3:QUAT 0 0 0 0 " + q(0, "0.6 0 0 0.8", "-0.6 0 0 -0.8") + "FIX 0\n" +
           "VERTEX_SE3:QUAT 1 1 0 0 " + q(1, "0 0.6 0 0.8", "0 -0.6 0 -0.8") + edge + " 1 0 0 " +
           std::regex_replace(q(2, "0 0 0.6 0.8", "0 0 -0.6 -0.8"), std::regex("\n"), "") +
           kEdge.substr(edge.size() + 14) + "\n";
  };
  std::string first;
  for (int signs = 0; signs < 8; ++signs) {
    testing::writeTestFile(folder_, "in.g2o", graph(signs));
    const testing::CommandResult result = run("evaluate in.g2o");
    ASSERT_EQ(result.exit_code, 0) << result.err << graph(signs);
    const std::string chi2 = result.out.substr(0, result.out.find('\n'));
    if (first.empty()) first = chi2;
    EXPECT_EQ(chi2, first) << signs;
  }
}

/// A star and a clique: one vertex with every edge, and every pair with one.
std::string starAndClique(int rays, int members) {
  std::string text = "VERTEX_XY 0 0 0\nFIX 0\n";
  for (int i = 1; i <= rays; ++i) {
    const std::string id = std::to_string(i);
    text += "VERTEX_XY " + id + " 0 0\nEDGE_POINTXY 0 " + id + " 1 2 1 0 1\n";
  }
  for (int i = 1; i <= members; ++i) {
    for (int k = 1; k < i; ++k) {
      text += "EDGE_POINTXY " + std::to_string(i) + ' ' + std::to_string(k) + " 0 0 1 0 1\n";
    }
  }
  return text;
}

TEST_F(Hostile, ASmallStackAndFewThreadsAreEnough) {
  GRAFT_SKIP_WITH_SANITIZER();
  testing::writeTestFile(folder_, "in.g2o", starAndClique(60000, 150));
  const testing::CommandResult free = run("optimize in.g2o -o free.g2o --threads 2");
  ASSERT_EQ(free.exit_code, 0) << free.err;
  EXPECT_EQ(run("optimize in.g2o -o stack.g2o --threads 2", "ulimit -s 256;").exit_code, 0);
  // Stacks of 512 MB for 64 threads do not fit.
  const testing::CommandResult few =
      run("optimize in.g2o -o few.g2o --threads 64", "ulimit -s 524288; ulimit -v 1000000;");
  EXPECT_EQ(few.exit_code, 0) << few.err;
  EXPECT_EQ(few.out.find(" 64 threads"), std::string::npos) << few.out;
  const std::string expected = testing::readTestFile(folder_ + "/free.g2o");
  EXPECT_EQ(testing::readTestFile(folder_ + "/stack.g2o"), expected);
  EXPECT_EQ(testing::readTestFile(folder_ + "/few.g2o"), expected);
}

TEST_F(Hostile, MemoryDiskAndFilesThatRunOutLeaveTheOutputAlone) {
  GRAFT_SKIP_WITH_SANITIZER();
  testing::writeTestFile(folder_, "in.g2o", starAndClique(60000, 300));
  const struct {
    const char* limit;
    int exit_code;
    const char* said;
  } cases[] = {
      {"ulimit -v 40000;", 6, "error: out of memory"},
      {"ulimit -f 1;", 5,
       "out.g2o: error: write failed: File too large; the previous file is kept"},
  };
  for (const auto& one : cases) {
    testing::writeTestFile(folder_, "out.g2o", "earlier result");
    const testing::CommandResult result =
        run("optimize in.g2o -o out.g2o --threads 1 2>err || { code=$?; cat err >&2; exit $code; }",
            std::string(one.limit));
    EXPECT_EQ(result.exit_code, one.exit_code) << one.limit << result.err;
    EXPECT_NE(result.err.find(one.said), std::string::npos) << result.err;
    EXPECT_EQ(testing::readTestFile(folder_ + "/out.g2o"), "earlier result");
  }
}

TEST_F(Hostile, NoAllocationThatFailsIsACrash) {
  GRAFT_SKIP_WITH_SANITIZER();
  testing::writeTestFile(folder_, "in.g2o", kVertices + kEdge + "\n");
  const std::string preload =
      "LD_PRELOAD=" + testing::binaryDirectory() + "/tests/libfail_allocation.so ";
  ASSERT_EQ(run("optimize in.g2o -o expected.g2o --threads 1", "", preload).exit_code, 0);
  const std::string expected = testing::readTestFile(folder_ + "/expected.g2o");
  for (const char* mode : {"once", "from"}) {
    int failed = 0;
    for (int k = 1;; k += 41) {
      testing::writeTestFile(folder_, "out.g2o", "earlier result");
      const testing::CommandResult result =
          run("optimize in.g2o -o out.g2o --threads 1 2>err; code=$?; test -f failed && "
              "echo failed; exit $code",
              "rm -f failed;",
              preload + "GRAFT_TEST_FAIL_ALLOCATION=" + std::to_string(k) +
                  " GRAFT_TEST_FAIL_MODE=" + mode);
      const bool hit = result.out.find("failed") != std::string::npos;
      const std::string out = testing::readTestFile(folder_ + "/out.g2o");
      EXPECT_TRUE(out == expected || out == "earlier result") << k;
      EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 3 || result.exit_code == 5 ||
                  result.exit_code == 6 || result.exit_code == 7)
          << mode << ' ' << k << ": " << result.exit_code
          << testing::readTestFile(folder_ + "/err");
      if (result.exit_code == 0) {
        EXPECT_EQ(out, expected) << k;
      }
      if (!hit) break;
      ++failed;
    }
    EXPECT_GT(failed, 20) << "nothing was made to fail";
  }
}

}  // namespace
}  // namespace graft
