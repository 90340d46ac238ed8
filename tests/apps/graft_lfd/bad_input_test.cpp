// SPDX-License-Identifier: BSD-3-Clause
// Defective task folders into the learner: how it ends, what it says, and that
// earlier results are left alone.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>

#include "tests/apps/graft_lfd/program.hpp"

namespace graft::lfd {
namespace {

namespace fs = std::filesystem;
using testing::CommandResult;
using testing::graftLfd;

/// One change to a good task folder.
struct BadCase {
  const char* name;
  const char* file;  ///< relative to the task folder; empty = no change to files
  const char* find;
  const char* replacement;  ///< null: the file is deleted
  int exit_code;
  const char* message;  ///< regular expression on standard error
};

const BadCase kCases[] = {
    {"not_xml", "task.xml", "<task ", "<task <", 3, "task\\.xml:\\d+: error: not valid XML"},
    {"missing_task", "task.xml", "", nullptr, 3, "task\\.xml: error: No such file"},
    {"unknown_attribute", "task.xml", "name=\"drawer\"", "name=\"drawer\" speed=\"9\"", 3,
     "task\\.xml:\\d+: error: .*speed"},
    {"unknown_element", "task.xml", "</task>", "<colour/></task>", 3,
     "task\\.xml:\\d+: error: .*colour"},
    {"newer_version", "task.xml", "version=\"1\"", "version=\"2\"", 3,
     "task\\.xml:\\d+: error: .*version"},
    {"no_track", "demo_02/hand.tum", "", nullptr, 3, "demo_02/hand\\.tum: error: No such file"},
    {"nan_in_track", "demo_02/hand.tum", "\n1", "\nnan 1", 3,
     "hand\\.tum:2:1: error: 'nan' is not a finite"},
    {"no_grasps", "grasps.csv", "", nullptr, 3, "grasps\\.csv: error: No such file"},
    {"grasp_header", "grasps.csv", "quality", "goodness", 3, "grasps\\.csv:1: error"},
    {"no_good_grasp", "task.xml", "min_quality=\"0.5\"", "min_quality=\"1\"", 3, "quality"},
    {"no_map", "map.yaml", "", nullptr, 3, "map\\.yaml: error: No such file"},
    {"map_resolution", "map.yaml", "resolution: 0.05", "resolution: -1", 3,
     "map\\.yaml:\\d+:?\\d*: error"},
    {"no_robot", "robot.urdf", "", nullptr, 3, "robot\\.urdf: error: No such file"},
    {"robot_cut", "robot.urdf", "</robot>", "", 3, "robot\\.urdf:\\d+: error"},
    {"unknown_tip", "task.xml", "tip_link=\"", "tip_link=\"no_", 3, "no_"},
    {"unknown_weight", "task.xml", "</task>",
     "<weights edge=\"E77\" sigma_t=\"1\" sigma_r=\"1\"/></task>", 3,
     "task\\.xml:\\d+: error: unknown edge 'E77'"},
};

class BadTask : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = testing::makeTemporaryDirectory();
    ASSERT_EQ(graftLfd("teach drawer --seed 2 -o " + folder_ + "/good").exit_code, 0);
  }
  static std::string folder_;
};
std::string BadTask::folder_;

TEST_F(BadTask, IsRefusedWithItsPlaceAndLeavesResultsAlone) {
  for (const BadCase& bad : kCases) {
    SCOPED_TRACE(bad.name);
    const std::string task = folder_ + "/" + bad.name;
    fs::copy(folder_ + "/good", task, fs::copy_options::recursive);
    const std::string file = task + "/" + bad.file;
    if (bad.replacement == nullptr) {
      fs::remove(file);
    } else {
      std::string content = testing::readTestFile(file);
      const std::size_t at = content.find(bad.find);
      ASSERT_NE(at, std::string::npos) << "the case does not apply";
      content.replace(at, std::string(bad.find).size(), bad.replacement);
      std::ofstream(file, std::ios::binary) << content;
    }
    const std::string out = testing::makeTemporaryDirectory();
    testing::writeTestFile(out, "metrics.json", "old");
    const CommandResult run = graftLfd("learn " + task + "/task.xml -o " + out);
    EXPECT_EQ(run.exit_code, bad.exit_code) << run.err;
    EXPECT_TRUE(std::regex_search(run.err, std::regex(bad.message))) << run.err;
    EXPECT_EQ(testing::readTestFile(out + "/metrics.json"), "old");
    std::size_t entries = 0;
    for ([[maybe_unused]] const auto& entry : fs::directory_iterator(out)) ++entries;
    EXPECT_EQ(entries, 1u) << "something was written";
  }
}

TEST(LearnerUsage, ErrorsEndWithTwo) {
  for (const char* arguments :
       {"", "learn", "nonsense", "learn x.xml", "learn x.xml -o y --speed 3",
        "learn x.xml -o y --iterations abc", "teach nosuchtask -o /tmp/x"}) {
    EXPECT_EQ(graftLfd(arguments).exit_code, 2) << arguments;
  }
}

TEST(LearnerUsage, HelpOfEveryCommandSuffices) {
  for (const char* command : {"learn", "check", "match", "segment", "build", "fit", "teach",
                              "reach", "reproduce", "evaluate", "report"}) {
    const CommandResult help = graftLfd(std::string(command) + " --help");
    EXPECT_EQ(help.exit_code, 0) << command;
    EXPECT_NE(help.out.find("Usage: graft-lfd " + std::string(command)), std::string::npos);
  }
}

TEST(LearnerOutput, UnwritableFolderIsFive) {
  const std::string folder = testing::makeTemporaryDirectory();
  testing::writeTestFile(folder, "file", "x");
  EXPECT_EQ(graftLfd("teach drawer -o " + folder + "/file/sub").exit_code, 5);
  EXPECT_EQ(graftLfd("learn task.xml -o " + folder + "/file/sub").exit_code, 5);
}

}  // namespace
}  // namespace graft::lfd
