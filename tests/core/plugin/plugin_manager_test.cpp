// SPDX-License-Identifier: BSD-3-Clause
#include "core/plugin/plugin_manager.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "core/plugin/engine.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

namespace fs = std::filesystem;

std::string pluginFolder() { return testing::binaryDirectory() + "/lib/graft/plugins"; }
std::string badFolder() { return testing::binaryDirectory() + "/lib/graft/bad"; }

PluginOptions only(const std::string& folder) {
  PluginOptions options;
  options.folders = {folder};
  options.use_environment = false;
  return options;
}

TEST(PluginManager, KnowsWhatPluginsProvideWithoutLoadingThem) {
  Registry registry;
  const PluginManager manager(registry, only(pluginFolder()));
  EXPECT_TRUE(registry.plugins().empty());
  bool found = false;
  for (const PluginManager::Known& known : manager.known()) {
    EXPECT_FALSE(known.loaded);
    EXPECT_TRUE(known.file.has_metadata) << known.file.path;
    for (const Provided& one : known.file.provides) {
      found = found || one == Provided{Kind::kEdge, "EDGE_SE3:QUAT"};
    }
  }
  EXPECT_TRUE(found);
}

TEST(PluginManager, LoadsThePluginThatHasATagAndNoOther) {
  Registry registry;
  const PluginManager manager(registry, only(pluginFolder()));
  ASSERT_NE(registry.edge("EDGE_SE2"), nullptr);
  ASSERT_EQ(registry.plugins().size(), 1u);
  EXPECT_EQ(registry.plugins().front().name, "slam2d");
  EXPECT_EQ(registry.edge("NOTHING_HAS_THIS"), nullptr);
  EXPECT_EQ(registry.plugins().size(), 1u);
}

TEST(PluginManager, MetadataEqualsWhatIsRegistered) {
  Registry registry;
  PluginManager manager(registry, only(pluginFolder()));
  manager.loadAll();
  for (const PluginManager::Known& known : manager.known()) {
    ASSERT_TRUE(known.loaded) << known.file.path << manager.diagnostics().text();
    for (const PluginRecord& record : registry.plugins()) {
      if (record.name != known.file.name) continue;
      EXPECT_EQ(record.provides, known.file.provides);
    }
  }
}

TEST(PluginManager, AdviceNamesTheNearestTagOfPluginsNotLoaded) {
  Registry registry;
  const PluginManager manager(registry, only(pluginFolder()));
  EXPECT_NE(registry.advice({Kind::kEdge, "EDGE_SE3_QUAT"}).find("slam3d has EDGE_SE3:QUAT"),
            std::string::npos);
  EXPECT_NE(registry.advice({Kind::kEdge, "edge_se2"}).find("EDGE_SE2"), std::string::npos);
  EXPECT_NE(registry.advice({Kind::kVertex, "Huber"}).find("Huber is a robust kernel"),
            std::string::npos)
      << registry.advice({Kind::kVertex, "Huber"});
  EXPECT_EQ(registry.advice({Kind::kEdge, "COMPLETELY_DIFFERENT"}), "");
}

TEST(PluginManager, LoadsWhatAPluginRequiresFirst) {
  Registry registry;
  PluginManager manager(registry, only(pluginFolder()));
  manager.addFile(badFolder() + "/libgraft_fine.so");
  ASSERT_EQ(registry.plugins().size(), 2u);
  EXPECT_EQ(registry.plugins()[0].name, "slam2d");
  EXPECT_EQ(registry.plugins()[1].name, "fine");
}

TEST(PluginManager, ACircleOfRequirementsIsAnError) {
  Registry registry;
  PluginManager manager(registry, only(badFolder()));
  try {
    manager.loadByName("circle_a");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kPlugin);
    EXPECT_NE(std::string(e.what()).find("circle"), std::string::npos);
  }
  EXPECT_TRUE(registry.plugins().empty());
}

TEST(PluginManager, OneFileUnderManyPathsIsLoadedOnce) {
  const std::string folder = testing::makeTemporaryDirectory();
  fs::create_symlink(pluginFolder() + "/libgraft_slam2d.so", folder + "/libgraft_alias.so");
  Registry registry;
  PluginManager manager(registry, only(pluginFolder()));
  manager.addFile("slam2d");
  manager.addFile(pluginFolder() + "/libgraft_slam2d.so");
  manager.addFile(pluginFolder() + "/../plugins/libgraft_slam2d.so");
  manager.addFile(folder + "/libgraft_alias.so");
  EXPECT_EQ(registry.plugins().size(), 1u);
}

TEST(PluginManager, OfTwoPluginsWithOneNameTheFirstFolderWins) {
  const std::string folder = testing::makeTemporaryDirectory();
  fs::copy_file(pluginFolder() + "/libgraft_slam2d.so", folder + "/libgraft_slam2d.so");
  PluginOptions options = only(folder);
  options.folders.push_back(pluginFolder());
  Registry registry;
  PluginManager manager(registry, options);
  EXPECT_NE(manager.diagnostics().text().find("plugin slam2d is taken from " + folder),
            std::string::npos);
  registry.edge("EDGE_SE2");
  EXPECT_EQ(registry.plugins().front().file, folder + "/libgraft_slam2d.so");
}

TEST(PluginManager, BrokenFilesInAFolderAreReportedAndDoNoHarm) {
  const std::string folder = testing::makeTemporaryDirectory();
  testing::writeTestFile(folder, "libgraft_broken.so", "no library");
  testing::writeTestFile(folder, "readme.txt", "ignored");
  fs::copy_file(pluginFolder() + "/libgraft_kernels.so", folder + "/libgraft_kernels.so");
  Registry registry;
  PluginManager manager(registry, only(folder));
  EXPECT_EQ(manager.diagnostics().warningCount(), 1u);
  EXPECT_NE(registry.kernel("Huber"), nullptr);
}

TEST(PluginManager, TheEnvironmentAddsAbsoluteFolders) {
  const std::string folder = testing::makeTemporaryDirectory();
  fs::copy_file(pluginFolder() + "/libgraft_kernels.so", folder + "/libgraft_kernels.so");
  PluginOptions options = only(testing::makeTemporaryDirectory());
  options.use_environment = true;
  ::setenv("GRAFT_PLUGIN_PATH", ("relative/path::" + folder).c_str(), 1);
  Registry registry;
  const PluginManager manager(registry, options);
  ::unsetenv("GRAFT_PLUGIN_PATH");
  EXPECT_EQ(manager.folders().back(), folder);
  EXPECT_EQ(manager.folders().size(), 2u);
  EXPECT_NE(registry.kernel("Huber"), nullptr);
}

TEST(Engine, FindsThePluginsOfItsBuildTree) {
  Engine engine;
  EXPECT_NE(engine.registry().vertex("VERTEX_SE3:QUAT"), nullptr);
}

}  // namespace
}  // namespace graft
