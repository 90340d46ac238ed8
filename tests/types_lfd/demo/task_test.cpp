// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/task.hpp"

#include <gtest/gtest.h>

#include "tests/support/test_data.hpp"
#include "types_lfd/demo/demonstration.hpp"

namespace graft::lfd {
namespace {

using testing::makeTemporaryDirectory;
using testing::writeTestFile;

const char* const kRobot =
    "<robot urdf='../r.urdf' base_link='base' tip_link='tip' footprint='1 1 -1 1 -1 -1 1 -1'/>\n";
const char* const kGrasps = "<grasps file='grasps.csv'/>\n";
const char* const kDemo = "<demonstration name='a' hand='a/h.tum' object='a/o.tum'/>\n";

std::string task(const std::string& body) {
  return "<?xml version='1.0'?>\n<task name='t' version='1'>\n" + body + "</task>\n";
}

TEST(ReadTask, ReadsEverythingTheFormatNames) {
  const std::string directory = makeTemporaryDirectory();
  const std::string path = writeTestFile(
      directory, "task.xml",
      task("<!-- comment -->"
           "<robot urdf='../r/pr2.urdf' base_link='base' tip_link='tip' srdf='pr2.srdf'\n"
           " footprint='0 0\n 1 0\n 0 1' tool='0.1 0 0 0 0 0 1'/>\n"
           "<grasps file='g.csv' min_quality='0.5'/>\n<map file='/abs/map.yaml'/>\n"
           "<tracker entity='hand' sigma_t='0.01' sigma_r='0.2'/>\n"
           "<weights edge='E6' sigma_t='0.1' sigma_r='0.2'/>\n"
           "<demonstration name='a-1_B' hand='h.tum' object='o.tum' torso='t.tum'\n"
           " grasp_time='12.5' release_time='14' hand_offset='0 0 0.1 0 0 1 0'/>\n"));
  Diagnostics diagnostics;
  const Task read = readTask(path, diagnostics);
  EXPECT_EQ(diagnostics.text(), "");
  EXPECT_EQ(read.name, "t");
  EXPECT_EQ(read.directory, directory);
  EXPECT_EQ(read.robot.urdf, directory.substr(0, directory.rfind('/')) + "/r/pr2.urdf");
  EXPECT_EQ(read.robot.srdf, directory + "/pr2.srdf");
  EXPECT_EQ(read.robot.footprint.size(), 3U);
  EXPECT_EQ(read.robot.tip_T_gripper.translation.x(), 0.1);
  EXPECT_EQ(read.min_quality, 0.5);
  EXPECT_EQ(read.map, "/abs/map.yaml");
  EXPECT_EQ(read.trackers.at("hand").sigma_r, 0.2);
  ASSERT_EQ(read.weights.size(), 1U);
  EXPECT_EQ(read.weights[0].edge, "E6");
  ASSERT_EQ(read.demonstrations.size(), 1U);
  const DemonstrationSpec& demo = read.demonstrations[0];
  EXPECT_EQ(demo.name, "a-1_B");
  EXPECT_EQ(demo.torso, directory + "/t.tum");
  EXPECT_EQ(demo.grasp_time, 12.5);
  EXPECT_EQ(demo.release_time, 14);
  EXPECT_EQ(demo.hand_offset->rotation.z(), 1);
  EXPECT_EQ(demo.where.line, 11);
}

struct BadTask {
  const char* what;
  std::string body;
  const char* message;  // as printed, after the path
};

TEST(ReadTask, NamesLineAndDefectOfBadInput) {
  const std::string good = std::string(kRobot) + kGrasps + kDemo;
  const auto robot = [](const std::string& footprint) {
    return "<robot urdf='r' base_link='b' tip_link='t' footprint='" + footprint + "'/>\n" +
           kGrasps + kDemo;
  };
  const BadTask cases[] = {
      {"unknown element", good + "<camera/>\n", ":6: error: unknown element <camera>"},
      {"unknown attribute", std::string(kRobot) + "<grasps file='g' quality='1'/>\n" + kDemo,
       ":4: error: unknown attribute 'quality' of <grasps>"},
      {"text", good + "hello\n", "error: unexpected text in <task>"},
      {"content",
       std::string(kRobot) + kGrasps +
           "<demonstration name='a' hand='h' object='o'>x"
           "</demonstration>\n",
       "error: <demonstration> has no content"},
      {"no robot", std::string(kGrasps) + kDemo, ":2: error: <task> needs a <robot> element"},
      {"no demonstration", std::string(kRobot) + kGrasps, "needs a <demonstration> element"},
      {"two maps", good + "<map file='a'/>\n<map file='b'/>\n", ":7: error: a second <map>"},
      {"missing attribute", std::string(kRobot) + "<grasps/>\n" + kDemo,
       ":4: error: <grasps> needs the attribute 'file'"},
      {"empty path", std::string(kRobot) + "<grasps file=''/>\n" + kDemo,
       ":4: error: attribute 'file' of <grasps> is empty"},
      {"quality", std::string(kRobot) + "<grasps file='g' min_quality='1.5'/>\n" + kDemo,
       "'min_quality' of <grasps> must be from 0 to 1, got 1.5"},
      {"quality nan", std::string(kRobot) + "<grasps file='g' min_quality='nan'/>\n" + kDemo,
       ":4: error: attribute 'min_quality'"},
      {"two corners", robot("0 0 1 1"), "needs at least 3 corners, got 2"},
      {"odd numbers", robot("0 0 1 1 2"), "expected x y pairs, got 5 numbers"},
      {"bow tie", robot("0 0 1 1 1 0 0 1"), "the edges 1-2 and 3-4 cross"},
      {"repeated corner", robot("0 0 0 0 1 0 0 1"), "corner 2 repeats the one before"},
      {"no area", robot("0 0 1 0 2 0"), "folds back"},
      {"entity", good + "<tracker entity='foot' sigma_t='1' sigma_r='1'/>\n",
       ":6: error: unknown entity 'foot'; known: hand, object, torso"},
      {"sigma", good + "<tracker entity='hand' sigma_t='0' sigma_r='1'/>\n",
       "'sigma_t' of <tracker> must be positive, got 0"},
      {"two trackers",
       good + "<tracker entity='hand' sigma_t='1' sigma_r='1'/>\n"
              "<tracker entity='hand' sigma_t='1' sigma_r='1'/>\n",
       ":7: error: a second <tracker>"},
      {"weights", good + "<weights edge='E1' sigma_t='-1' sigma_r='1'/>\n", "must be positive"},
      {"name", std::string(kRobot) + kGrasps + "<demonstration name='a/b' hand='h' object='o'/>\n",
       ":5: error: the name 'a/b' may hold only letters, digits, '_' and '-'"},
      {"same name", good + kDemo, ":6: error: a second demonstration named 'a'"},
      {"times",
       std::string(kRobot) + kGrasps +
           "<demonstration name='a' hand='h' object='o'"
           " grasp_time='2' release_time='1'/>\n",
       "grasp_time must be before release_time"},
      {"offset",
       std::string(kRobot) + kGrasps +
           "<demonstration name='a' hand='h' object='o'"
           " hand_offset='0 0 0 0 0 0'/>\n",
       "expected 7 numbers, got 6"},
      {"offset quaternion",
       std::string(kRobot) + kGrasps +
           "<demonstration name='a' hand='h'"
           " object='o' hand_offset='0 0 0 0 0 0 2'/>\n",
       "the quaternion is not unit"}};
  const std::string directory = makeTemporaryDirectory();
  for (const BadTask& bad : cases) {
    const std::string path = writeTestFile(directory, "task.xml", task(bad.body));
    Diagnostics diagnostics;
    readTask(path, diagnostics);
    EXPECT_GE(diagnostics.errorCount(), 1U) << bad.what;
    EXPECT_NE(diagnostics.text().find(bad.message), std::string::npos)
        << bad.what << ": " << diagnostics.text();
  }
}

TEST(ReadTask, RefusesOtherRootsAndVersions) {
  const std::string directory = makeTemporaryDirectory();
  const std::pair<const char*, const char*> cases[] = {
      {"<graph name='t' version='1'/>", "expected <task>, got <graph>"},
      {"<task name='t' version='2'/>", "version '2' is not known; this program reads 1"},
      {"<task name='t'/>", "<task> needs the attribute 'version'"},
      {"<task version='1'/>", "<task> needs the attribute 'name'"},
      {"<task name='t' version='1'", "not valid XML"}};
  for (const auto& [content, message] : cases) {
    const std::string path = writeTestFile(directory, "task.xml", content);
    Diagnostics diagnostics;
    try {
      readTask(path, diagnostics);
      FAIL() << content;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      EXPECT_EQ(error.where().line, 1);
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
}

TEST(ReadTask, ReportsAllElementsInOneRun) {
  const std::string directory = makeTemporaryDirectory();
  const std::string path =
      writeTestFile(directory, "task.xml", task(std::string(kRobot) + "<grasps/>\n<demo/>\n"));
  Diagnostics diagnostics;
  readTask(path, diagnostics);
  EXPECT_EQ(diagnostics.errorCount(), 3U) << diagnostics.text();
}

class ReadDemonstrations : public ::testing::Test {
 protected:
  /// One demonstration whose hand and object files have the given contents.
  std::vector<Demonstration> read(const std::string& hand, const std::string& object,
                                  const std::string& more = "") {
    directory_ = makeTemporaryDirectory();
    if (!hand.empty()) writeTestFile(directory_, "h.tum", hand);
    writeTestFile(directory_, "o.tum", object);
    const std::string path =
        writeTestFile(directory_, "task.xml",
                      task(std::string(kRobot) + kGrasps +
                           "<demonstration name='a' hand='h.tum' object='o.tum'" + more + "/>\n"));
    const Task task = readTask(path, diagnostics_);
    EXPECT_EQ(diagnostics_.errorCount(), 0U) << diagnostics_.text();
    return readDemonstrations(task, diagnostics_);
  }

  std::string directory_;
  Diagnostics diagnostics_;
};

const char* const kTwoPoses = "0 1 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n";

TEST_F(ReadDemonstrations, AppliesTheOffsetInTheMarkersFrame) {
  // The marker is turned by 90 degrees about z, so its x axis is the map's y.
  const std::string hand =
      "0 1 2 3 0 0 0.7071067811865476 0.7071067811865476\n"
      "1 1 2 3 0 0 0.7071067811865476 0.7071067811865476\n";
  const auto demos = read(hand, kTwoPoses, " hand_offset='0.5 0 0 0 0 0 1'");
  EXPECT_EQ(diagnostics_.text(), "");
  ASSERT_EQ(demos.size(), 1U);
  EXPECT_NEAR((demos[0].hand.poses[0].translation - Eigen::Vector3d(1, 2.5, 3)).norm(), 0, 1e-15);
}

TEST_F(ReadDemonstrations, NamesMissingFiles) {
  read("", kTwoPoses);
  EXPECT_EQ(diagnostics_.errorCount(), 1U);
  EXPECT_NE(diagnostics_.text().find(directory_ + "/h.tum: error: No such file"), std::string::npos)
      << diagnostics_.text();
}

TEST_F(ReadDemonstrations, ReportsEveryBadFile) {
  read("# nothing\n", "0 1 2 3 0 0 0 1\n");
  EXPECT_NE(diagnostics_.text().find("h.tum: error: a track needs at least 2 poses, this has 0"),
            std::string::npos);
  EXPECT_NE(diagnostics_.text().find("o.tum: error: a track needs at least 2 poses, this has 1"),
            std::string::npos);
}

TEST_F(ReadDemonstrations, NamesIntervalsThatDoNotOverlap) {
  read(kTwoPoses, "5 1 2 3 0 0 0 1\n7.5 1 2 3 0 0 0 1\n");
  EXPECT_NE(
      diagnostics_.text().find(":5: error: demonstration 'a': the tracks do not overlap in time: "
                               "hand covers 0 to 1 s, object covers 5 to 7.5 s"),
      std::string::npos)
      << diagnostics_.text();
}

TEST_F(ReadDemonstrations, WarnsOfLongGaps) {
  std::string hand = "0 1 2 3 0 0 0 1\n";
  for (int i = 0; i < 9; ++i) hand += std::to_string(9 + i) + " 1 2 3 0 0 0 1\n";
  read(hand, "0 1 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n");
  EXPECT_EQ(diagnostics_.text(),
            directory_ + "/h.tum: warning: no pose for 9 s after 0; tuples there are interpolated");
}

}  // namespace
}  // namespace graft::lfd
