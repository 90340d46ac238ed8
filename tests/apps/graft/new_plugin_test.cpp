// SPDX-License-Identifier: BSD-3-Clause
// What new-plugin refuses; that what it writes builds and passes is tested
// against the installed package (tests/install).
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

namespace fs = std::filesystem;

testing::CommandResult newPlugin(const std::string& folder, const std::string& arguments) {
  return testing::runCommand("cd " + folder + "\n" + testing::binaryDirectory() +
                             "/bin/graft new-plugin " + arguments);
}

TEST(NewPlugin, WritesAFolder) {
  const std::string folder = testing::makeTemporaryDirectory();
  const testing::CommandResult result = newPlugin(folder, "my_edges");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_NE(result.out.find("cmake -S my_edges -B my_edges/build"), std::string::npos);
  for (const char* file :
       {"CMakeLists.txt", "plugin.cpp", "test.cpp", "example.g2o", "README.md", ".gitignore"}) {
    const std::string text = testing::readTestFile(folder + "/my_edges/" + file);
    EXPECT_NE(text, "") << file;
    EXPECT_EQ(text.find('@'), std::string::npos) << file;
  }
  const std::string source = testing::readTestFile(folder + "/my_edges/plugin.cpp");
  EXPECT_NE(source.find("struct MyEdgesPrior"), std::string::npos);
  EXPECT_NE(source.find("\"VERTEX_MY_EDGES\""), std::string::npos);
  EXPECT_NE(source.find("GRAFT_PLUGIN(my_edges, registry)"), std::string::npos);
}

TEST(NewPlugin, DoesNotTouchWhatExists) {
  const std::string folder = testing::makeTemporaryDirectory();
  testing::writeTestFile(folder, "ranging/plugin.cpp", "mine");
  testing::CommandResult result = newPlugin(folder, "ranging");
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_EQ(result.err, "ranging: error: exists already; nothing was written\n");
  EXPECT_EQ(testing::readTestFile(folder + "/ranging/plugin.cpp"), "mine");
  EXPECT_FALSE(fs::exists(folder + "/ranging/test.cpp"));
  testing::writeTestFile(folder, "file", "mine");
  EXPECT_EQ(newPlugin(folder, "ranging -o file").exit_code, 5);
  EXPECT_EQ(testing::readTestFile(folder + "/file"), "mine");
  // A link to nowhere is something, too.
  fs::create_symlink("nowhere", folder + "/link");
  EXPECT_EQ(newPlugin(folder, "ranging -o link").exit_code, 5);
  EXPECT_FALSE(fs::exists(folder + "/nowhere"));
  EXPECT_EQ(newPlugin(folder, "ranging -o file/below").exit_code, 5);
}

TEST(NewPlugin, RefusesBadNames) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string names[] = {"''",      "Ranging",    "2d", "my-edges", "'my edges'",
                               "../evil", "a/b",        "_a", "'a;b'",    std::string(41, 'a'),
                               "slam2d",  "'r\xc3\xa4'"};
  for (const std::string& name : names) {
    const testing::CommandResult result = newPlugin(folder, name);
    EXPECT_EQ(result.exit_code, 2) << name << result.err;
    EXPECT_NE(result.err.find("error: "), std::string::npos) << name;
  }
  EXPECT_TRUE(fs::is_empty(folder));
  EXPECT_NE(newPlugin(folder, "slam2d").err.find("there is a plugin named slam2d already: "),
            std::string::npos);
}

}  // namespace
}  // namespace graft
