// SPDX-License-Identifier: BSD-3-Clause
#include <elf.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <regex>

#include "core/plugin/engine.hpp"
#include "core/plugin/plugin_library.hpp"
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
        BadCase{"older_size", "size_of_registrar is [0-9]+, this program has [0-9]+", false},
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

TEST(OlderPlugin, OfThisMajorVersionIsLoaded) {
  Engine engine;
  engine.plugins().addFile(badPlugin("older"));
  EXPECT_NE(engine.registry().kernel("Good_older"), nullptr);
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

/// A copy of a good plugin with one 16-bit or 8-bit field of its header set.
std::string withHeader(const std::string& folder, std::size_t offset, std::size_t size,
                       unsigned value) {
  std::string bytes = testing::readTestFile(badPlugin("fine"));
  for (std::size_t i = 0; i < size; ++i) bytes[offset + i] = char(value >> (8 * i) & 0xffu);
  return testing::writeTestFile(folder, "libgraft_patched.so", bytes);
}

TEST(NoPlugin, LibrariesOfOtherMachinesSayForWhich) {
  const std::string folder = testing::makeTemporaryDirectory();
  const auto expectSays = [](const std::string& path, const char* part) {
    const std::string text = failureOf(path);
    EXPECT_NE(text.find(std::string("libgraft_patched.so: error: not a plugin: ") + part),
              std::string::npos)
        << text;
  };
  // Of no machine that this could run on: the Tilera TILE-Gx.
  expectSays(withHeader(folder, offsetof(Elf64_Ehdr, e_machine), 2, EM_TILEGX),
             "it is for another processor (ELF machine 191, this program ");
  expectSays(withHeader(folder, EI_CLASS, 1, ELFCLASS32), "it is no 64-bit library");
  expectSays(withHeader(folder, EI_DATA, 1, ELFDATA2MSB), "it is for another byte order");
  expectSays(withHeader(folder, offsetof(Elf64_Ehdr, e_type), 2, ET_EXEC),
             "it is no shared library");
  expectSays(withHeader(folder, offsetof(Elf64_Ehdr, e_type), 2, ET_CORE),
             "it is no shared library");
}

TEST(NoPlugin, WhatIsNoRegularFileIsNotWaitedFor) {
  const std::string folder = testing::makeTemporaryDirectory();
  fs::create_directory(folder + "/libgraft_folder.so");
  ASSERT_EQ(::mkfifo((folder + "/libgraft_pipe.so").c_str(), 0600), 0);
  fs::create_symlink("nowhere", folder + "/libgraft_dangling.so");
  fs::create_symlink("libgraft_loop.so", folder + "/libgraft_loop.so");
  for (const char* name : {"folder", "pipe"}) {
    EXPECT_NE(failureOf(folder + "/libgraft_" + name + ".so").find("it is no regular file"),
              std::string::npos);
  }
  EXPECT_NE(failureOf("/dev/zero.so/").find("not a plugin: "), std::string::npos);
  EXPECT_NE(failureOf(folder + "/libgraft_dangling.so").find("No such file"), std::string::npos);
  EXPECT_NE(failureOf(folder + "/libgraft_loop.so").find("symbolic links"), std::string::npos);
  // In a folder that is searched, each is a warning and no more.
  PluginOptions options;
  options.folders = {folder};
  options.use_environment = false;
  Registry registry;
  PluginManager manager(registry, options);
  EXPECT_EQ(manager.diagnostics().warningCount(), 4u) << manager.diagnostics().text();
  EXPECT_TRUE(manager.known().empty());
}

TEST(NoPlugin, AFolderOfTenThousandFilesGivesFewMessagesAndTheOneThatFits) {
  constexpr int kFiles = 10000;
  const std::string folder = testing::makeTemporaryDirectory();
  for (int i = 0; i < kFiles; ++i) {
    const std::string name = std::to_string(i) + (i % 2 == 0 ? ".so" : ".txt");
    testing::writeTestFile(folder, (i % 4 < 2 ? "libgraft_" : "other_") + name, "text");
  }
  fs::copy_file(testing::binaryDirectory() + "/lib/graft/plugins/libgraft_kernels.so",
                folder + "/libgraft_kernels.so");
  PluginOptions options;
  options.folders = {folder};
  options.use_environment = false;
  Registry registry;
  PluginManager manager(registry, options);
  EXPECT_EQ(pluginCandidates(folder).size(), std::size_t(kFiles / 4 + 1));
  EXPECT_EQ(manager.diagnostics().warningCount(), std::size_t(kFiles / 4));
  EXPECT_EQ(manager.diagnostics().lines().size(), Diagnostics::kShown);
  EXPECT_NE(manager.diagnostics().text().find("and 2480 more warnings"), std::string::npos)
      << manager.diagnostics().text();
  ASSERT_EQ(manager.known().size(), 1u);
  EXPECT_NE(registry.kernel("Huber"), nullptr);
}

TEST(NoPlugin, AFolderThatIsMissingOrUnreadableIsAWarning) {
  PluginOptions options;
  options.folders = {testing::makeTemporaryDirectory() + "/missing"};
  options.use_environment = false;
  Registry registry;
  PluginManager manager(registry, options);
  EXPECT_EQ(manager.diagnostics().warningCount(), 1u);
  EXPECT_NE(manager.diagnostics().text().find("missing: warning: cannot list plugins: No such"),
            std::string::npos)
      << manager.diagnostics().text();
}

TEST(NoPlugin, AFileThatIsReplacedAfterItsCheckIsNotLoaded) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string path = folder + "/libgraft_fine.so";
  fs::copy_file(badPlugin("fine"), path);
  const PluginFile checked = readPluginFile(path);
  ASSERT_EQ(checked.refusal, "");
  fs::copy_file(badPlugin("undefined"), folder + "/other");
  fs::rename(folder + "/other", path);
  Registry registry;
  try {
    loadPluginLibrary(checked, registry);
    FAIL() << "was loaded";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kPlugin);
    EXPECT_NE(std::string(e.what()).find("was replaced while"), std::string::npos) << e.what();
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
