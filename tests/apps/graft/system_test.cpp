// SPDX-License-Identifier: BSD-3-Clause
// A system that fails, interrupts or kills at every single call: outputs are the old or
// the new ones, complete, and the end is one of those that are stated.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "core/types/stamp.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

namespace fs = std::filesystem;

const std::string kGraph =
    "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0.1 0\nVERTEX_SE2 2 2 0.3 0.1\nFIX 0\n"
    "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0.1 1 0 0 1 0 1\n";

constexpr const char* kOptimize = "/bin/graft optimize in.g2o -o out.g2o --threads 1";

/// Names that begin as hidden ones of ours do.
int temporaries(const std::string& folder) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    count += entry.path().filename().string().compare(0, 7, ".graft-") == 0 ? 1 : 0;
  }
  return count;
}

class System : public ::testing::Test {
 protected:
  void SetUp() override {
    if (detail::sanitizerBits() != 0) GTEST_SKIP() << "a sanitizer has these calls to itself";
    testing::writeTestFile(folder_, "in.g2o", kGraph);
    ASSERT_EQ(run(kOptimize).exit_code, 0);
    expected_ = testing::readTestFile(folder_ + "/out.g2o");
    ASSERT_NE(expected_, "");
  }
  testing::CommandResult run(const std::string& command, const std::string& environment = "") {
    return testing::runCommand("cd " + folder_ + " && timeout -s ABRT 60 env " + environment + " " +
                               testing::binaryDirectory() + command);
  }
  /// The same on the hostile system.
  testing::CommandResult runOn(const std::string& system, const std::string& command = kOptimize) {
    fs::remove(folder_ + "/failed");
    return run(command, "LD_PRELOAD=" + testing::binaryDirectory() +
                            "/tests/libhostile_system.so " + system);
  }
  bool failed() const { return fs::exists(folder_ + "/failed"); }

  /// Runs with the first, second, ... call of a kind failing until none is left; returns
  /// how many there are. `end` gets the exit code, "old" or "new", and what was said.
  template <class End>
  int sweep(const std::string& call, const std::string& mode, const std::string& what,
            const End& end) {
    for (int k = 1;; ++k) {
      const std::string out = testing::writeTestFile(folder_, "out.g2o", "earlier result");
      const testing::CommandResult result =
          runOn("GRAFT_TEST_IO_CALL=" + call + " GRAFT_TEST_IO_NUMBER=" + std::to_string(k) +
                " GRAFT_TEST_IO_MODE=" + mode + " GRAFT_TEST_IO_DO=" + what);
      SCOPED_TRACE(call + " " + mode + " " + what + " " + std::to_string(k) + ": exit code " +
                   std::to_string(result.exit_code) + ", " + result.err);
      const std::string content = testing::readTestFile(out);
      EXPECT_TRUE(content == "earlier result" || content == expected_) << content;
      if (!failed()) {
        EXPECT_EQ(result.exit_code, 0);
        EXPECT_EQ(content, expected_);
        return k - 1;
      }
      end(result.exit_code, content == expected_, result.err);
      if (::testing::Test::HasFailure()) return k;
    }
  }
  std::string folder_ = testing::makeTemporaryDirectory();
  std::string expected_;
};

TEST_F(System, ReadsThatAreShortOrInterruptedChangeNothing) {
  for (const char* what : {"short", "interrupt"}) {
    const int calls = sweep("read", "from", what, [](int code, bool is_new, const std::string&) {
      EXPECT_EQ(code, 0);
      EXPECT_TRUE(is_new);
    });
    EXPECT_GT(calls, 2);
  }
}

TEST_F(System, FilesThatCannotBeOpenedOrReadAreNamed) {
  for (const char* call : {"open", "read"}) {
    for (const char* mode : {"once", "from"}) {
      int refused = 0;
      sweep(call, mode, "fail", [&](int code, bool is_new, const std::string& said) {
        // A plugin that cannot be read is a warning as long as nobody needs it.
        EXPECT_TRUE(code == 0 || code == 3 || code == 5 || code == 7);
        EXPECT_TRUE(code == 5 || is_new == (code == 0));
        EXPECT_NE(said.find(code == 0 ? ": warning: " : ": error: "), std::string::npos);
        refused += code != 0 ? 1 : 0;
      });
      EXPECT_GT(refused, 1);
    }
  }
}

TEST_F(System, WritesThatFailKeepTheOldFile) {
  const std::map<std::string, std::string> said = {
      {"write", "out.g2o: error: write failed: No space left on device; the previous file is kept"},
      {"fsync", "out.g2o: error: fsync failed: Input/output error; the previous file is kept"},
      {"close", "out.g2o: error: close failed: Input/output error; the previous file is kept"},
      {"rename", "out.g2o: error: rename failed: No space left on device; the previous file is"}};
  for (const auto& [call, text] : said) {
    for (const char* mode : {"once", "from"}) {
      int kept = 0;
      sweep(call, mode, "fail",
            [&, &expected = text, &given = call](int code, bool is_new, const std::string& s) {
              if (code == 0) {
                // Closing what was only read.
                EXPECT_EQ(given, "close");
              } else if (is_new) {
                EXPECT_EQ(code, 5);
                EXPECT_NE(s.find("out.g2o: error: written, but durability is not confirmed: "),
                          std::string::npos);
              } else {
                EXPECT_EQ(code, 5);
                EXPECT_NE(s.find(expected), std::string::npos);
                ++kept;
              }
              EXPECT_EQ(temporaries(folder_), 0);
            });
      EXPECT_GE(kept, 1) << call;
    }
  }
}

TEST_F(System, WritesThatAreShortOrInterruptedChangeNothing) {
  for (const char* what : {"short", "interrupt"}) {
    const int calls = sweep("write", "from", what, [](int code, bool is_new, const std::string&) {
      EXPECT_EQ(code, 0);
      EXPECT_TRUE(is_new);
    });
    EXPECT_GT(calls, 0);
  }
}

TEST_F(System, WhereEverythingFailsTheEndIsNear) {
  const int calls = sweep("any", "from", "fail", [&](int code, bool, const std::string&) {
    EXPECT_TRUE(code == 0 || code == 3 || code == 5 || code == 7);
  });
  EXPECT_GT(calls, 15);
}

TEST_F(System, AKillAtAnyCallLeavesTheOldOrTheNewFile) {
  int left = 0;
  const int calls = sweep("any", "once", "kill", [&](int code, bool, const std::string&) {
    EXPECT_EQ(code, 137);
    left = std::max(left, temporaries(folder_));
  });
  EXPECT_GT(calls, 15);
  // The runs that followed removed what was left by those before them.
  EXPECT_EQ(left, 1);
  EXPECT_EQ(temporaries(folder_), 0);
}

/// What the log of the hostile system says of the disk: whatever a rename gives a name to
/// has been written out by then, and every rename is written out at the end.
void expectDurable(const std::string& log) {
  std::ifstream lines(log);
  std::set<std::string> dirty;
  int renames = 0;
  const auto parent = [](const std::string& path) {
    const std::string folder = fs::path(path).parent_path().string();
    return folder.empty() ? std::string(".") : folder;
  };
  const auto absolute = [&](const std::string& path) {
    const fs::path folder = fs::path(log).parent_path();
    return (path.front() == '/' ? fs::path(path) : folder / path).lexically_normal().string();
  };
  for (std::string what, from, to, line; std::getline(lines, line);) {
    std::istringstream words(line);
    words >> what >> from >> to;
    from = absolute(from);
    if (from.size() > 1 && from.back() == '/') from.pop_back();
    if (what == "create") dirty.insert(parent(from));
    if (what == "write") dirty.insert(from);
    if (what == "fsync") dirty.erase(from);
    if (what != "rename" && what != "exchange") continue;
    ++renames;
    for (const std::string& path : dirty) {
      EXPECT_FALSE(path == from || path.compare(0, from.size() + 1, from + "/") == 0)
          << path << " may be lost after " << line;
    }
    dirty.insert(parent(absolute(to)));
  }
  EXPECT_GT(renames, 0);
  for (const std::string& path : dirty) {
    EXPECT_NE(path.find(".graft-"), std::string::npos) << path << " may be lost at the end";
  }
}

TEST_F(System, NothingGetsItsNameBeforeItIsOnTheDisk) {
  const std::string log = folder_ + "/calls";
  ASSERT_EQ(runOn("GRAFT_TEST_IO_LOG=" + log).exit_code, 0);
  expectDurable(log);
  for (const char* text : {"one", "two"}) {
    fs::remove(log);
    ASSERT_EQ(runOn("GRAFT_TEST_IO_LOG=" + log, std::string("/tests/staged_writer out ") + text)
                  .exit_code,
              0);
    expectDurable(log);
  }
}

/// What a folder of staged_writer holds, hidden entries left out.
std::map<std::string, std::string> contentOf(const std::string& folder) {
  std::map<std::string, std::string> content;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (name.front() != '.' && entry.is_regular_file()) {
      content[name] = testing::readTestFile(entry.path().string());
    }
  }
  return content;
}

TEST_F(System, AFolderOfOutputsIsPutBackWhereACallFailsAndWholeByEntryWhereItIsKilled) {
  const std::string out = folder_ + "/out";
  const std::map<std::string, std::string> old = {{"a/first", "one"},
                                                  {"a/b/second", "one"},
                                                  {"third", "one"},
                                                  {"obsolete", "one"},
                                                  {"mine", "precious"}};
  const std::map<std::string, std::string> now = {
      {"a/first", "two"}, {"a/b/second", "two"}, {"third", "two"}, {"mine", "precious"}};
  for (const char* what : {"fail", "kill"}) {
    bool old_seen = false;
    bool new_seen = false;
    for (int k = 1;; ++k) {
      fs::remove_all(out);
      for (const auto& [name, text] : old) testing::writeTestFile(out, name, text);
      const testing::CommandResult result =
          runOn("GRAFT_TEST_IO_CALL=any GRAFT_TEST_IO_MODE=once GRAFT_TEST_IO_NUMBER=" +
                    std::to_string(k) + " GRAFT_TEST_IO_DO=" + what,
                "/tests/staged_writer out two");
      SCOPED_TRACE(std::string(what) + " " + std::to_string(k) + ": " + result.err);
      const std::map<std::string, std::string> content = contentOf(out);
      if (*what == 'f') {
        const bool confirmed = result.err.find("durability is not confirmed") == std::string::npos;
        EXPECT_EQ(content, result.exit_code == 0 || !confirmed ? now : old);
        EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 5);
        EXPECT_EQ(temporaries(out), 0);
      } else {
        EXPECT_EQ(content.at("a/first"), content.at("a/b/second"));
        for (const auto& [name, text] : content) {
          EXPECT_TRUE(text == old.at(name) || (now.count(name) > 0 && text == now.at(name)));
        }
        EXPECT_GE(content.size(), now.size());
        ASSERT_EQ(run("/tests/staged_writer out two").exit_code, 0);
        EXPECT_EQ(temporaries(out), 0);
        EXPECT_EQ(contentOf(out), now);
      }
      old_seen = old_seen || content == old;
      new_seen = new_seen || content == now;
      if (!failed() || HasFailure()) break;
    }
    EXPECT_TRUE(old_seen && new_seen);
  }
}

TEST_F(System, ManyRunsMayWriteOneFile) {
  const std::string program = testing::binaryDirectory() + kOptimize;
  // Every state that a reader meets is a complete result; what one run takes for left over
  // by a killed one is never another's.
  const testing::CommandResult result = testing::runCommand(
      "cd " + folder_ + "; cp out.g2o expected; for i in 1 2 3 4 5 6 7 8 9 10; do (" + program +
      " >/dev/null || echo run $?) & done\n"
      "for i in $(seq 200); do cmp out.g2o expected || echo torn; done; wait");
  EXPECT_EQ(result.out, "") << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(temporaries(folder_), 0);
}

TEST_F(System, WhatAKilledRunLeftIsRemovedAndWhatALivingOneHoldsIsNot) {
  const std::string stale = testing::writeTestFile(folder_, ".graft-out.g2o-abcdef", "half");
  const std::string held = testing::writeTestFile(folder_, ".graft-out.g2o-ghijkl", "half");
  const std::string other = testing::writeTestFile(folder_, ".graft-out.g2o-notours", "half");
  const std::string link = folder_ + "/.graft-out.g2o-mnopqr";
  fs::create_symlink(other, link);
  const testing::CommandResult result = testing::runCommand(
      "cd " + folder_ + " && flock " + held + " " + testing::binaryDirectory() + kOptimize);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_FALSE(fs::exists(stale));
  EXPECT_TRUE(fs::exists(held));
  EXPECT_TRUE(fs::exists(other));
  EXPECT_TRUE(fs::is_symlink(link));
}

}  // namespace
}  // namespace graft
