// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <regex>

#include "core/plugin/engine.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

namespace fs = std::filesystem;

std::string badPlugin(const std::string& name) {
  return testing::binaryDirectory() + "/lib/graft/bad/libgraft_" + name + ".so";
}

struct BadCase {
  const char* name;
  const char* message;  ///< regular expression
  bool runs;            ///< whether code of the file may run
};

class BadPlugin : public ::testing::TestWithParam<BadCase> {};

TEST_P(BadPlugin, IsRefusedWithTheReasonAndLeavesNoTrace) {
  const BadCase& one = GetParam();
  const std::string marker = testing::makeTemporaryDirectory() + "/marker";
  ::setenv("GRAFT_TEST_MARKER", marker.c_str(), 1);
  Engine engine;
  ASSERT_NE(engine.registry().vertex("VERTEX_SE2"), nullptr);
  const std::vector<Provided> before = engine.registry().provided();
  try {
    engine.plugins().addFile(badPlugin(one.name));
    FAIL() << "was loaded";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kPlugin);
    EXPECT_TRUE(std::regex_search(e.formatted(), std::regex(one.message))) << e.formatted();
    EXPECT_NE(e.formatted().find(std::string("libgraft_") + one.name), std::string::npos);
  }
  ::unsetenv("GRAFT_TEST_MARKER");
  EXPECT_EQ(engine.registry().provided(), before);
  if (!one.runs) {
    EXPECT_FALSE(fs::exists(marker)) << "its constructors ran";
  }
}

INSTANTIATE_TEST_SUITE_P(
    , BadPlugin,
    ::testing::Values(
        BadCase{"major", "plugin ABI mismatch: abi_major is 99, this program has 1", false},
        BadCase{"minor", "abi_minor is [0-9]+, this program has [0-9]+ \\(it is newer\\)", false},
        BadCase{"size", "size_of_edge_type is [0-9]+, this program has [0-9]+", false},
        BadCase{"sanitizer", "sanitizers is [0-9], this program has [0-9]", false},
        BadCase{"isa", "needs a processor with unknown features", false},
        BadCase{"magic", "not a plugin: its stamp has the wrong magic number", false},
        BadCase{"nostamp", "not a plugin: it has no section \\.graft\\.stamp", false},
        BadCase{"lonely", "requires the plugin nowhere, which is not found", false},
        BadCase{"noentry", "it has no function graft_plugin_register", true},
        BadCase{"fails", "registration failed: no licence key", true},
        BadCase{"throws", "threw an exception: thrown through the boundary", true},
        BadCase{"duplicate", "vertex type VERTEX_SE2 is provided already by .*libgraft_slam2d\\.so",
                true},
        BadCase{"half", "invalid type: Bad: a callback is null", true},
        BadCase{"tag", "the name is empty, too long, or has blanks", true},
        BadCase{"undefined", "cannot load the plugin: .*graft_test_nobody_has_this", false}),
    [](const auto& info) { return std::string(info.param.name); });

std::string failureOf(const std::string& file) {
  Engine engine;
  try {
    engine.plugins().addFile(file);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kPlugin);
    return e.formatted();
  }
  return "was loaded";
}

TEST(NoPlugin, FilesOfOtherKindsSayWhy) {
  const std::string folder = testing::makeTemporaryDirectory();
  const auto contains = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  contains(failureOf(testing::writeTestFile(folder, "text.so", "hello\n")), "it is no ELF file");
  contains(failureOf(testing::writeTestFile(folder, "long.so", std::string(5000, 'x'))),
           "it is no ELF file");
  contains(failureOf(testing::writeTestFile(folder, "empty.so", "")), "it is no ELF file");
  contains(failureOf(folder + "/missing.so"), "No such file or directory");
  contains(failureOf(folder + "/"), "it is no regular file");
  contains(failureOf(testing::binaryDirectory() + "/lib/libgraft_core.a"), "it is no ELF file");
  contains(failureOf("no_such_name"), "there is no plugin named 'no_such_name' (known: ");
}

TEST(NoPlugin, ATruncatedLibraryIsRefusedWhereverItIsCut) {
  const std::string whole = testing::readTestFile(badPlugin("fine"));
  const std::string folder = testing::makeTemporaryDirectory();
  for (std::size_t size = 0; size < whole.size(); size += 1024) {
    const std::string path =
        testing::writeTestFile(folder, "libgraft_cut.so", whole.substr(0, size));
    EXPECT_NE(failureOf(path).find("error: not a plugin: "), std::string::npos) << size;
  }
}

TEST(NoPlugin, DamagedHeadersNeverCrashTheReader) {
  const std::string whole = testing::readTestFile(badPlugin("major"));
  const std::string folder = testing::makeTemporaryDirectory();
  // The ELF header and the table of sections at the end, byte by byte.
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < 64; ++i) places.push_back(i);
  for (std::size_t i = whole.size() - 64 * 30; i < whole.size(); i += 13) places.push_back(i);
  for (const std::size_t place : places) {
    for (const char value : {'\x00', '\x7f', '\xff'}) {
      std::string damaged = whole;
      damaged[place] = value;
      const std::string path = testing::writeTestFile(folder, "libgraft_damaged.so", damaged);
      EXPECT_NE(failureOf(path), "was loaded");
    }
  }
}

TEST(NoPlugin, AFileThatAnyoneMayChangeIsNotLoaded) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string path = folder + "/libgraft_fine.so";
  fs::copy_file(badPlugin("fine"), path);
  fs::permissions(path, fs::perms::others_write, fs::perm_options::add);
  EXPECT_NE(failureOf(path).find("anyone may change this file"), std::string::npos);
}

}  // namespace
}  // namespace graft
