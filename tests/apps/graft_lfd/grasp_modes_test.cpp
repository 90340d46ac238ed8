// SPDX-License-Identifier: BSD-3-Clause
// Tasks whose demonstrations hold the object in several ways.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/apps/graft_lfd/taught_task.hpp"

namespace graft::lfd {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::CommandResult;
using testing::graftLfd;
using testing::graftProgram;
using testing::resultTrack;
using testing::TaughtTask;

json readJson(const std::string& path) { return json::parse(testing::readTestFile(path)); }

std::set<std::string> entriesOf(const std::string& directory) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(directory)) names.insert(entry.path().filename());
  return names;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// The hand of a demonstration is seen 30 cm further on: it holds the object
/// elsewhere.
void moveHand(TaughtTask& task, const std::string& demo) {
  task.attribute(demo, "hand_offset", "0 0 0.3 0 0 0 1");
}

TEST(GraspModes, LearnsTheUsualWayAsIfTheOthersWereNotThere) {
  TaughtTask mixed;
  moveHand(mixed, "demo_02");
  TaughtTask without;
  without.remove("demo_02");
  const std::string out = testing::makeTemporaryDirectory();
  const CommandResult run = graftLfd("learn " + mixed.task() + " -o " + out + "/a");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  ASSERT_EQ(graftLfd("learn " + without.task() + " -o " + out + "/b").exit_code, 0);
  EXPECT_NE(run.err.find("warning: demo_02 is left out: it holds the object up to 3"),
            std::string::npos)
      << run.err;
  for (const char* name : {"graph.g2o", "graph_optimized.g2o", "segments.csv", "grasp.json",
                           "model.json", "optimized/demo_06/joints.csv"}) {
    EXPECT_EQ(testing::readTestFile(out + "/a/" + name), testing::readTestFile(out + "/b/" + name))
        << name;
  }
  EXPECT_EQ(entriesOf(out + "/a/optimized"), entriesOf(out + "/b/optimized"));
  const json metrics = readJson(out + "/a/metrics.json");
  EXPECT_EQ(metrics.at("tuples"), readJson(out + "/b/metrics.json").at("tuples"));
  ASSERT_EQ(metrics.at("grasp_modes").size(), 2u);
  EXPECT_EQ(metrics.at("grasp_mode"), 0);
  EXPECT_EQ(metrics.at("grasp_modes").at(0).at("demonstrations").size(), 5u);
  EXPECT_EQ(metrics.at("grasp_modes").at(0).at("grasp"),
            readJson(out + "/a/grasp.json").at("grasp_row"));
  EXPECT_TRUE(metrics.at("grasp_modes").at(1).at("grasp").is_null());
  EXPECT_NE(testing::readTestFile(out + "/a/report.html").find("demo_02 is left out"),
            std::string::npos);

  // The generic program takes the same way of a task file, and says so.
  const CommandResult generic =
      graftProgram("optimize " + mixed.task() + " --json " + out + "/task.json");
  ASSERT_EQ(generic.exit_code, 0) << generic.err;
  EXPECT_NE(generic.err.find("demo_02 is left out"), std::string::npos) << generic.err;
  ASSERT_EQ(
      graftProgram("optimize " + out + "/a/graph.g2o --json " + out + "/graph.json").exit_code, 0);
  const double wanted = readJson(out + "/graph.json").at("chi2_final").get<double>();
  EXPECT_NEAR(readJson(out + "/task.json").at("chi2_final").get<double>(), wanted, 1e-9 * wanted);

  // The other way, asked for by its number, into the same folder.
  const CommandResult other =
      graftLfd("learn " + mixed.task() + " --grasp-mode 1 -o " + out + "/a");
  ASSERT_EQ(other.exit_code, 0) << other.err;
  EXPECT_EQ(entriesOf(out + "/a/optimized"), (std::set<std::string>{"demo_02"}));
  EXPECT_EQ(readJson(out + "/a/metrics.json").at("grasp_mode"), 1);
  EXPECT_EQ(count(other.err, "is left out"), 5u) << other.err;
}

TEST(GraspModes, AHandTurnedByHalfATurnIsTheSameGrasp) {
  const TaughtTask plain;
  const TaughtTask turned;
  turned.forEachPose(
      "hand",
      [](double&, Pose& pose) { pose.rotation = pose.rotation * Eigen::Quaterniond(0, 1, 0, 0); },
      "demo_03");
  const std::string out = testing::makeTemporaryDirectory();
  ASSERT_EQ(graftLfd("learn " + plain.task() + " -o " + out + "/plain").exit_code, 0);
  const CommandResult run = graftLfd("learn " + turned.task() + " -o " + out + "/turned");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("note: demo_03: the hand is turned by half a turn"), std::string::npos);
  EXPECT_EQ(readJson(out + "/turned/metrics.json").at("grasp_modes").size(), 1u);
  // The same problem, so the same robot; and the hand as it was recorded.
  const Pose half(Vec<double, 3>::Zero(), Eigen::Quaterniond(0, 1, 0, 0));
  for (const char* demo : {"demo_01", "demo_03"}) {
    const std::string a = out + "/plain/optimized/" + demo;
    const std::string b = out + "/turned/optimized/" + demo;
    const Trajectory hand_a = resultTrack(a + "/hand.tum");
    const Trajectory hand_b = resultTrack(b + "/hand.tum");
    const Trajectory gripper_a = resultTrack(a + "/gripper.tum");
    const Trajectory gripper_b = resultTrack(b + "/gripper.tum");
    ASSERT_EQ(hand_a.times, hand_b.times);
    const Pose turn = std::string(demo) == "demo_03" ? half : Pose();
    for (std::size_t i = 0; i < hand_a.size(); ++i) {
      EXPECT_LT(poseError(hand_a.poses[i].inverse() * (hand_b.poses[i] * turn)).norm(), 1e-6);
      EXPECT_LT(poseError(gripper_a.poses[i].inverse() * gripper_b.poses[i]).norm(), 1e-6);
    }
  }
  const json after_a = readJson(out + "/plain/metrics.json").at("table1");
  const json after_b = readJson(out + "/turned/metrics.json").at("table1");
  for (const char* part : {"before", "after"}) {
    for (const auto& [row, value] : after_a.at(part).items()) {
      if (value.is_null()) continue;
      EXPECT_NEAR(value.get<double>(), after_b.at(part).at(row).get<double>(), 1e-6) << row;
    }
  }
  const CommandResult evaluated = graftLfd("evaluate " + out + "/turned --json");
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  EXPECT_NEAR(json::parse(evaluated.out).at("hand_object_sd_rad").get<double>(),
              after_b.at("after").at("hand_object_sd_rad").get<double>(), 1e-9);
  const auto offset = readJson(out + "/turned/grasp.json").at("hand_T_gripper");
  EXPECT_GT(std::abs(offset.at("demo_03").at(3).get<double>()), 0.9);
  EXPECT_LT(std::abs(offset.at("demo_01").at(3).get<double>()), 0.5);
  // What was written is a graph of its own.
  const CommandResult again =
      graftProgram("optimize " + out + "/turned/graph.g2o --json " + out + "/again.json");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NEAR(readJson(out + "/again.json").at("chi2_final").get<double>(),
              readJson(out + "/turned/metrics.json").at("chi2_final").get<double>(), 1e-6);
}

TEST(GraspModes, EndsWithFourWhereNoTwoAgree) {
  TaughtTask task;
  for (const char* demo : {"demo_02", "demo_03", "demo_05", "demo_06"}) task.remove(demo);
  moveHand(task, "demo_04");
  const std::string out = testing::makeTemporaryDirectory();
  testing::writeTestFile(out, "graph.g2o", "old");
  for (const char* mode : {"", " --grasp-mode 0", " --grasp-mode all"}) {
    const CommandResult run = graftLfd("learn " + task.task() + mode + " -o " + out);
    EXPECT_EQ(run.exit_code, 4) << mode;
    EXPECT_NE(run.err.find("demo_01 and demo_04 hold the object"), std::string::npos) << run.err;
    EXPECT_EQ(entriesOf(out), (std::set<std::string>{"metrics.json", "segments.csv"}));
  }
  EXPECT_EQ(readJson(out + "/metrics.json").at("grasp_modes").size(), 2u);
  EXPECT_EQ(count(testing::readTestFile(out + "/segments.csv"), "\ndemo_"), 2u);
  EXPECT_NE(graftProgram("optimize " + task.task()).exit_code, 0);
  // One demonstration alone has nothing to disagree with.
  task.remove("demo_04");
  EXPECT_EQ(graftLfd("learn " + task.task() + " -o " + out).exit_code, 0);
}

TEST(GraspModes, RefusesNumbersThatAreNone) {
  const TaughtTask task;
  const std::string out = testing::makeTemporaryDirectory();
  for (const char* mode : {"1", "7", "-1", "x", "1.5", "99999999999999999999"}) {
    const CommandResult run =
        graftLfd("learn " + task.task() + " --grasp-mode=" + mode + " -o " + out);
    EXPECT_EQ(run.exit_code, 2) << mode;
    EXPECT_TRUE(entriesOf(out).empty()) << mode;
  }
  EXPECT_NE(
      graftLfd("learn " + task.task() + " --grasp-mode=7 -o " + out).err.find("in 1 way, number 0"),
      std::string::npos);
}

TEST(GraspModes, OfRealMotionCaptureAreLearnedOneByOne) {
  GRAFT_REQUIRE_DATA("tasks/mocap_largetable_many_grasps/task.xml");
  const std::string task = testing::dataPath("tasks/mocap_largetable_many_grasps/task.xml");
  const std::string out = testing::makeTemporaryDirectory();
  const CommandResult usual = graftLfd("learn " + task + " -o " + out + "/usual");
  ASSERT_EQ(usual.exit_code, 0) << usual.err;
  const json metrics = readJson(out + "/usual/metrics.json");
  const json& modes = metrics.at("grasp_modes");
  ASSERT_GT(modes.size(), 1u);
  std::set<std::string> members;
  for (const json& name : modes.at(0).at("demonstrations")) members.insert(name);
  EXPECT_GE(members.size(), 2u);
  EXPECT_EQ(entriesOf(out + "/usual/optimized"), members);
  std::set<std::string> all;
  for (std::size_t m = 0; m < modes.size(); ++m) {
    // Most demonstrations first, ties by spread.
    const std::size_t size = modes[m].at("demonstrations").size();
    if (m > 0) {
      const std::size_t before = modes[m - 1].at("demonstrations").size();
      EXPECT_GE(before, size);
      if (before == size) {
        EXPECT_LE(modes[m - 1].at("spread_m").get<double>(), modes[m].at("spread_m").get<double>());
      }
    }
    for (const json& name : modes[m].at("demonstrations")) all.insert(name);
  }
  EXPECT_EQ(all.size(), 8u);
  EXPECT_EQ(count(usual.err, "is left out"), 8 - members.size()) << usual.err;
  EXPECT_LE(metrics.at("table1").at("after").at("gripper_grasp_m").get<double>(), 0.003);

  const CommandResult each = graftLfd("learn " + task + " --grasp-mode all -o " + out + "/all");
  ASSERT_EQ(each.exit_code, 0) << each.err;
  EXPECT_EQ(entriesOf(out + "/all").size(), modes.size());
  EXPECT_EQ(testing::readTestFile(out + "/all/mode_0/graph_optimized.g2o"),
            testing::readTestFile(out + "/usual/graph_optimized.g2o"));
  for (std::size_t m = 0; m < modes.size(); ++m) {
    const std::string folder = out + "/all/mode_" + std::to_string(m);
    EXPECT_EQ(entriesOf(folder), entriesOf(out + "/usual"));
    EXPECT_EQ(readJson(folder + "/metrics.json").at("grasp_mode"), m);
    EXPECT_EQ(graftLfd("evaluate " + folder).exit_code, 0);
    const std::string report = testing::readTestFile(folder + "/report.html");
    EXPECT_EQ(graftLfd("report " + folder).exit_code, 0);
    EXPECT_TRUE(testing::readTestFile(folder + "/report.html") == report) << folder;
    EXPECT_EQ(graftProgram("check " + folder + "/graph.g2o").exit_code, 0);
  }
  const CommandResult several = graftLfd("report " + out + "/all");
  EXPECT_EQ(several.exit_code, 3);
  EXPECT_NE(several.err.find("/all/mode_0"), std::string::npos) << several.err;
  // A run with one result clears those of the run before.
  ASSERT_EQ(graftLfd("learn " + task + " --grasp-mode 1 -o " + out + "/all").exit_code, 0);
  EXPECT_EQ(entriesOf(out + "/all"), entriesOf(out + "/usual"));
  const CommandResult none = graftLfd("learn " + task + " --grasp-mode 99 -o " + out + "/none");
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("in " + std::to_string(modes.size()) + " ways"), std::string::npos);
  EXPECT_FALSE(fs::exists(out + "/none"));
}

}  // namespace
}  // namespace graft::lfd
