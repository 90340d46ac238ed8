// SPDX-License-Identifier: BSD-3-Clause
// What surrounds a run: a full disk, few descriptors, no folder for temporary files, clocks
// that jump, signals, masks, and another user's rights.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/types/stamp.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

namespace fs = std::filesystem;

class Surroundings : public ::testing::Test {
 protected:
  Surroundings() {
    // A ring that takes a few steps.
    std::string text = "FIX 0\n";
    for (int i = 0; i < 300; ++i) {
      const std::string id = std::to_string(i);
      text += "VERTEX_SE2 " + id + " " + std::to_string(0.9 * i) + " 0 0.1\nEDGE_SE2 " + id + " " +
              std::to_string((i + 1) % 300) + " 1 0 0.02 10 1 0 20 0 300\n";
    }
    testing::writeTestFile(folder_, "in.g2o", text);
  }
  /// Runs a line of the shell in the folder; GRAFT stands for the program.
  testing::CommandResult shell(std::string line) {
    const std::string word = "GRAFT";
    const std::string program = testing::binaryDirectory() + "/bin/graft";
    for (std::size_t at = 0; (at = line.find(word, at)) != std::string::npos; at += program.size())
      if (line.compare(at, 6, "GRAFT_") != 0) line.replace(at, word.size(), program);
    return testing::runCommand("cd " + folder_ + " && { " + line + "\n}");
  }
  std::string read(const std::string& name) { return testing::readTestFile(folder_ + "/" + name); }
  std::string folder_ = testing::makeTemporaryDirectory();
};

TEST_F(Surroundings, ADiskThatIsFullKeepsTheOldFile) {
  if (shell("unshare -Urm mount -t tmpfs -o size=64k none .").exit_code != 0) {
    GTEST_SKIP() << "no file system may be mounted here";
  }
  const testing::CommandResult result = shell(
      "mkdir disk; unshare -Urm sh -c 'mount -t tmpfs -o size=24k none disk && "
      "echo earlier > disk/out.g2o && { GRAFT optimize in.g2o -o disk/out.g2o; echo $?; "
      "cat disk/out.g2o; ls -A disk; }'");
  EXPECT_EQ(result.out.substr(result.out.find('5')), "5\nearlier\nout.g2o\n") << result.out;
  EXPECT_NE(result.err.find("disk/out.g2o: error: write failed: No space left on device; the "
                            "previous file is kept"),
            std::string::npos)
      << result.err;
}

TEST_F(Surroundings, FewDescriptorsAreEnoughOrNamed) {
  if (detail::sanitizerBits() != 0) GTEST_SKIP() << "a sanitizer needs descriptors of its own";
  ASSERT_EQ(shell("GRAFT optimize in.g2o -o expected.g2o --threads 2 </dev/null").exit_code, 0);
  bool refused = false;
  bool done = false;
  for (int limit = 3; limit <= 12; ++limit) {
    testing::writeTestFile(folder_, "out.g2o", "earlier result");
    const testing::CommandResult result =
        shell("exec </dev/null; ulimit -n " + std::to_string(limit) +
              "; exec GRAFT optimize in.g2o -o out.g2o --threads 2");
    SCOPED_TRACE(std::to_string(limit) + ": " + result.err);
    // With less than the program itself needs, the dynamic linker ends it.
    if (result.err.find("error while loading shared libraries") != std::string::npos) continue;
    if (result.exit_code == 0) {
      EXPECT_EQ(read("out.g2o"), read("expected.g2o"));
      done = true;
    } else {
      EXPECT_TRUE(result.exit_code == 5 || result.exit_code == 7) << result.exit_code;
      EXPECT_NE(result.err.find("error: "), std::string::npos);
      EXPECT_NE(result.err.find("Too many open files"), std::string::npos);
      EXPECT_EQ(read("out.g2o"), "earlier result");
      refused = true;
    }
  }
  EXPECT_TRUE(refused && done);
}

TEST_F(Surroundings, NoFolderForTemporaryFilesIsNeeded) {
  for (const char* folder : {"/nonexistent", "/proc"}) {
    const std::string set = std::string("TMPDIR=") + folder;
    EXPECT_EQ(shell(set + " GRAFT optimize in.g2o -o out.g2o").exit_code, 0);
    // Of a loader, the kit checks files that it makes.
    const testing::CommandResult kit = shell(set + " GRAFT check-plugin toro");
    EXPECT_EQ(kit.exit_code, 0) << kit.out << kit.err;
  }
}

TEST_F(Surroundings, ACalendarThatJumpsDoesNotMatter) {
  if (detail::sanitizerBits() != 0) GTEST_SKIP() << "a sanitizer has these calls to itself";
  const std::string run = " GRAFT optimize in.g2o --threads 1 --time-limit 600 --json ";
  ASSERT_EQ(shell(run + "plain.json -o plain.g2o").exit_code, 0);
  const auto summary = [this](const std::string& name) {
    nlohmann::json document = nlohmann::json::parse(read(name));
    for (const auto& [phase, seconds] : document["seconds"].items()) {
      EXPECT_GE(seconds.get<double>(), 0) << phase;
      EXPECT_LT(seconds.get<double>(), 500) << phase;
    }
    return document["status"].get<std::string>() + document["chi2_final"].dump();
  };
  // To 1970, to 2038 and beyond, and to and fro by days.
  for (const char* step : {"86400", "1763770000", "3000000000"}) {
    const testing::CommandResult result = shell(
        std::string("GRAFT_TEST_CLOCK=") + step + " LD_PRELOAD=" + testing::binaryDirectory() +
        "/tests/libhostile_system.so" + run + "j.json -o j.g2o");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(read("j.g2o"), read("plain.g2o")) << step;
    EXPECT_EQ(summary("j.json"), summary("plain.json")) << step;
  }
  // The calendar does jump.
  EXPECT_NE(shell("GRAFT_TEST_CLOCK=3000000000 LD_PRELOAD=" + testing::binaryDirectory() +
                  "/tests/libhostile_system.so date +%Y")
                .out,
            shell("date +%Y").out);
}

TEST_F(Surroundings, AHangupIsATermination) {
  const std::string run =
      " --preserve-status -s HUP 0.3 GRAFT optimize in.g2o -o out.g2o --json - --iterations 100000 "
      "--plugin " +
      testing::binaryDirectory() + "/lib/graft/faulty/libgraft_faulty.so";
  std::string text = "FAULTY_POINT 0 0.5 0.3\nFAULTY_POINT 1 1 2\n";
  for (int i = 0; i < 40000; ++i) text += "FAULTY_EDGE 0 1 1 1 1 0 1\n";
  testing::writeTestFile(folder_, "in.g2o", text);
  const testing::CommandResult result =
      shell("GRAFT_TEST_FAULT=sleeps_in_evaluate timeout" + run + " --initial-guess file");
  EXPECT_EQ(result.exit_code, 143) << result.err;
  EXPECT_NE(result.out.find("\"status\": \"interrupted\""), std::string::npos) << result.out;
  EXPECT_NE(read("out.g2o").find("FAULTY_POINT 1 1 2"), std::string::npos);
  // A caller's wish to go on (nohup) holds.
  testing::writeTestFile(folder_, "in.g2o", "VERTEX_XY 0 1 2\nFIX 0\n");
  EXPECT_EQ(
      shell("trap '' HUP; GRAFT optimize in.g2o -o out.g2o & kill -HUP $!; wait $!").exit_code, 0);
}

TEST_F(Surroundings, SignalsThatStopAndContinueDoNotMatter) {
  ASSERT_EQ(shell("GRAFT optimize in.g2o -o expected.g2o --initial-guess file").exit_code, 0);
  const testing::CommandResult result = shell(
      "GRAFT optimize in.g2o -o out.g2o --initial-guess file & pid=$!; for i in 1 2 3; do "
      "kill -STOP $pid && sleep 0.05; kill -CONT $pid; done 2>/dev/null; wait $pid");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read("out.g2o"), read("expected.g2o"));
}

TEST_F(Surroundings, AReaderThatIsGoneIsAnOutputThatFailed) {
  // The reader has closed its end before the program writes.
  const testing::CommandResult result = shell(
      "{ sleep 0.2; GRAFT optimize in.g2o -o -; echo $? > code; } | exec 0<&-; sleep 0.1; "
      "until [ -s code ]; do sleep 0.05; done");
  EXPECT_EQ(read("code"), "5\n") << result.err;
  EXPECT_NE(result.err.find("<stdout>: error: write failed: Broken pipe"), std::string::npos)
      << result.err;
}

TEST_F(Surroundings, ModesFollowTheMaskAndStayWhereAFileIsReplaced) {
  const auto modeOf = [this](const std::string& name) {
    struct stat status {};
    EXPECT_EQ(::stat((folder_ + "/" + name).c_str(), &status), 0);
    return status.st_mode & 07777;
  };
  const struct {
    const char* mask;
    mode_t mode;
  } cases[] = {{"077", 0600}, {"022", 0644}, {"000", 0666}};
  for (const auto& one : cases) {
    const std::string set = std::string("umask ") + one.mask + "; ";
    ASSERT_EQ(shell(set + "rm -f out.g2o; GRAFT optimize in.g2o -o out.g2o").exit_code, 0);
    EXPECT_EQ(modeOf("out.g2o"), one.mode) << one.mask;
    ASSERT_EQ(shell(set + "chmod 640 out.g2o; GRAFT optimize in.g2o -o out.g2o").exit_code, 0);
    EXPECT_EQ(modeOf("out.g2o"), mode_t(0640)) << one.mask;
  }
}

TEST_F(Surroundings, AProgramWithAnothersRightsIgnoresTheEnvironment) {
  if (detail::sanitizerBits() != 0) GTEST_SKIP() << "a leak check may not look at such a program";
  if (::geteuid() != 0) GTEST_SKIP() << "needs root";
  const std::string library =
      testing::binaryDirectory() + "/lib/graft/misbehaving/libgraft_misbehaving.so";
  ASSERT_EQ(shell("chmod 755 .; mkdir plugins && cp " + library + " plugins; cp GRAFT own; " +
                  "cp GRAFT other; chown 65534 other; chmod 4755 other")
                .exit_code,
            0);
  const std::string set = "GRAFT_PLUGIN_PATH=" + folder_ + "/plugins ";
  EXPECT_EQ(shell(set + "./own types Misbehaving").exit_code, 0);
  const testing::CommandResult result = shell(set + "./other types Misbehaving");
  if (shell("findmnt -no OPTIONS -T . | grep -q nosuid").exit_code == 0) {
    GTEST_SKIP() << "no program takes another's rights on this file system";
  }
  EXPECT_EQ(result.exit_code, 2) << result.out << result.err;
}

}  // namespace
}  // namespace graft
