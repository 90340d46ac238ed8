// SPDX-License-Identifier: BSD-3-Clause
// Plugins that bring down, hold up or change the process that loads them: the
// probe and the doctor contain them, and the programs go on or end with 7.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "core/types/stamp.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

namespace fs = std::filesystem;

std::string library() {
  return testing::binaryDirectory() + "/lib/graft/misbehaving/libgraft_misbehaving.so";
}

testing::CommandResult graft(const std::string& how, const std::string& arguments) {
  return testing::runCommand("GRAFT_TEST_MISBEHAVIOUR=" + how + " " + testing::binaryDirectory() +
                             "/bin/graft " + arguments);
}

// A sanitizer's runtime turns the signal into an exit of its own.
constexpr const char* kCrash =
    "plugin failed in probe: (signal 11 \\(Segmentation fault\\)|it ended the process)";

struct Misbehaviour {
  const char* name;
  const char* failure;  ///< regular expression
};

class Misbehaving : public ::testing::TestWithParam<Misbehaviour> {};

/// Address space is not limited where a sanitizer needs all of it.
bool cannotBeTried(const Misbehaviour& one) {
  return detail::sanitizerBits() != 0 && std::string(one.name) == "eats";
}

TEST_P(Misbehaving, IsNamedByTheDoctor) {
  const Misbehaviour& one = GetParam();
  if (cannotBeTried(one)) GTEST_SKIP() << "not with a sanitizer";
  const testing::CommandResult result =
      graft(one.name, "plugins --doctor --time-limit 1 --plugin " + library());
  EXPECT_EQ(result.exit_code, 7) << result.out;
  EXPECT_TRUE(std::regex_search(
      result.err, std::regex("libgraft_misbehaving\\.so: error: " + std::string(one.failure))))
      << result.err;
  EXPECT_NE(result.out.find("good slam2d"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("BAD  misbehaving"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find(", 1 bad\n"), std::string::npos) << result.out;
}

TEST_P(Misbehaving, IsNotLoadedIntoTheProgram) {
  const Misbehaviour& one = GetParam();
  if (cannotBeTried(one)) GTEST_SKIP() << "not with a sanitizer";
  const testing::CommandResult result = graft(one.name, "types Misbehaving --plugin " + library());
  EXPECT_EQ(result.exit_code, 7) << result.out;
  EXPECT_EQ(result.out, "");
  EXPECT_TRUE(std::regex_search(
      result.err, std::regex("libgraft_misbehaving\\.so: error: " + std::string(one.failure))))
      << result.err;
}

INSTANTIATE_TEST_SUITE_P(
    , Misbehaving,
    ::testing::Values(
        Misbehaviour{"throws", "(plugin failed in probe: signal 6|it threw an exception|.*thrown)"},
        Misbehaviour{"aborts", "plugin failed in probe: signal 6 \\(Aborted\\)"},
        Misbehaviour{"crashes", kCrash},
        Misbehaviour{"exits", "plugin failed in probe: it ended the process \\(exit status 0\\)"},
        Misbehaviour{"loops", "plugin failed in probe: no answer within [15] s"},
        Misbehaviour{"eats",
                     "(out of memory|plugin failed in probe: signal 6|it threw.*bad_alloc)"},
        Misbehaviour{"closes_stderr", "plugin failed in probe: loading it changes standard error"},
        Misbehaviour{"closes_all", "plugin failed in probe: it ended the process"},
        Misbehaviour{"locale", "plugin failed in probe: loading it changes the locale"},
        Misbehaviour{"rounding", "plugin failed in probe: .*the floating-point mode"},
        Misbehaviour{"handler", "plugin failed in probe: .*the handler of signal 15"},
        Misbehaviour{"folder", "plugin failed in probe: .*the working folder"},
        Misbehaviour{"mask", "plugin failed in probe: .*the file mode mask"},
        Misbehaviour{"says", "plugin failed in probe: signal 6.*it said: goodbye, cruel world"},
        Misbehaviour{"register_crashes", kCrash},
        Misbehaviour{"register_exits", "plugin failed in probe: it ended the process"},
        Misbehaviour{"register_throws", "its registration threw an exception: thrown"},
        Misbehaviour{"register_rounding", "plugin failed in probe: .*the floating-point mode"}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(Doctor, FindsNothingWhereNothingIsWrong) {
  const testing::CommandResult result =
      graft("none", "plugins --doctor --plugin " + library() + " --plugin slam2d");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_NE(result.out.find("good misbehaving"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("good slam3d"), std::string::npos) << result.out;
}

TEST(Doctor, ThreadsAreNotedOnly) {
  const testing::CommandResult result = graft("thread", "plugins --doctor --plugin " + library());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("note: loading it starts 1 threads"), std::string::npos) << result.err;
}

TEST(Doctor, NamesFileAndFieldOfEveryBadPlugin) {
  const testing::CommandResult result =
      testing::runCommand("GRAFT_PLUGIN_PATH=" + testing::binaryDirectory() + "/lib/graft/bad " +
                          testing::binaryDirectory() + "/bin/graft plugins --doctor");
  EXPECT_EQ(result.exit_code, 7);
  const Misbehaviour cases[] = {
      {"major", "plugin ABI mismatch: abi_major is 99, this program has 1"},
      {"minor", "plugin ABI mismatch: abi_minor is [0-9]+, this program has [0-9]+ \\(it is newer"},
      {"size", "plugin ABI mismatch: size_of_edge_type is [0-9]+, this program has [0-9]+"},
      {"sanitizer", "plugin ABI mismatch: sanitizers is"},
      {"isa", "it needs a processor with unknown features"},
      {"magic", "not a plugin: its stamp has the wrong magic number"},
      {"nostamp", "not a plugin: it has no section \\.graft\\.stamp"},
      {"lonely", "it requires the plugin nowhere, which is not found"},
      {"circle_a", "plugins require each other in a circle"},
      {"noentry", "it has no function graft_plugin_register"},
      {"fails", "the plugin's registration failed: no licence key"},
      {"throws", "its registration threw an exception: thrown through the boundary"},
      {"duplicate", "vertex type VERTEX_SE2 is provided already by .*libgraft_slam2d\\.so"},
      {"half", "invalid type: Bad: a callback is null"},
      {"tag", "invalid type: .*blanks"},
      {"undefined", "cannot load the plugin: .*undefined symbol: graft_test_nobody_has_this"},
  };
  for (const Misbehaviour& one : cases) {
    EXPECT_TRUE(std::regex_search(result.err, std::regex("libgraft_" + std::string(one.name) +
                                                         "\\.so: error: " + one.failure)))
        << one.name << "\n"
        << result.err;
  }
  EXPECT_NE(result.out.find("good fine"), std::string::npos) << result.out;
}

TEST(Doctor, ABrokenFileInATrustedFolderIsAnError) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string path = testing::writeTestFile(folder, "libgraft_text.so", "hello");
  const testing::CommandResult result =
      testing::runCommand("GRAFT_PLUGIN_PATH=" + folder + " " + testing::binaryDirectory() +
                          "/bin/graft plugins --doctor");
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_NE(result.err.find(path + ": error: not a plugin: it is no ELF file"), std::string::npos)
      << result.err;
}

TEST(PluginFolder, OneThatAnyoneMayWriteIsNotUsed) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string path = folder + "/libgraft_misbehaving.so";
  fs::copy_file(library(), path);
  const auto types = [&](const std::string& before, const std::string& arguments) {
    return testing::runCommand(before + testing::binaryDirectory() +
                               "/bin/graft types Misbehaving " + arguments);
  };
  const std::string environment = "GRAFT_PLUGIN_PATH=" + folder + " ";
  EXPECT_EQ(types(environment, "").exit_code, 0);
  fs::permissions(folder, fs::perms::all);
  testing::CommandResult result = types(environment, "");
  EXPECT_EQ(result.exit_code, 2) << result.out;
  EXPECT_NE(result.err.find(folder + ": warning: anyone may put files into this folder"),
            std::string::npos)
      << result.err;
  result = types("", "--plugin " + path);
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_NE(result.err.find(path + ": error: anyone may replace this file"), std::string::npos)
      << result.err;
  // As in /tmp: others may add files there, but not replace this one.
  fs::permissions(folder, fs::perms::sticky_bit, fs::perm_options::add);
  EXPECT_EQ(types("", "--plugin " + path).exit_code, 0);
}

}  // namespace
}  // namespace graft
