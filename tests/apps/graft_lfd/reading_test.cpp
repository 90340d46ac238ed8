// SPDX-License-Identifier: BSD-3-Clause
// Other ways to record the same thing give the same result.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "tests/apps/graft_lfd/taught_task.hpp"

namespace graft::lfd {
namespace {

namespace fs = std::filesystem;
using testing::CommandResult;
using testing::graftLfd;
using testing::resultTrack;
using testing::TaughtTask;

std::string text(const Pose& pose) {
  double v[7];
  pose.toArray(v);
  std::string out;
  for (const double x : v) out += (out.empty() ? "" : " ") + formatDouble(x);
  return out;
}

/// Learns a task; the folder of the result.
std::string learned(const TaughtTask& task) {
  const std::string out = testing::makeTemporaryDirectory() + "/out";
  const CommandResult run = graftLfd("learn " + task.task() + " -o " + out);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return out;
}

/// Largest difference of two results' poses, m and rad.
double largestDifference(const std::string& a, const std::string& b) {
  double largest = 0;
  std::size_t poses = 0;
  for (const auto& demo : fs::directory_iterator(a + "/optimized")) {
    for (const char* name : {"hand", "object", "torso", "gripper", "base"}) {
      const std::string file =
          "/optimized/" + demo.path().filename().string() + "/" + name + ".tum";
      const Trajectory one = resultTrack(a + file);
      const Trajectory other = resultTrack(b + file);
      EXPECT_EQ(one.times, other.times);
      for (std::size_t i = 0; i < std::min(one.size(), other.size()); ++i, ++poses) {
        largest = std::max(
            largest, poseError(one.poses[i].inverse() * other.poses[i]).lpNorm<Eigen::Infinity>());
      }
    }
  }
  EXPECT_GT(poses, 1000u);
  return largest;
}

TEST(Reading, AMarkerOffThePalmWithItsOffsetIsThePalm) {
  const TaughtTask plain;
  TaughtTask marker;
  const Pose marker_T_palm(Vec<double, 3>(0.04, -0.03, 0.09),
                           expSO3<double>(Vec<double, 3>(0.4, -1.1, 0.7)));
  marker.forEachPose("hand", [&](double&, Pose& pose) { pose = pose * marker_T_palm.inverse(); });
  const std::string wrong = testing::makeTemporaryDirectory() + "/wrong";
  ASSERT_EQ(graftLfd("learn " + marker.task() + " -o " + wrong).exit_code, 0);
  for (int d = 1; d <= 6; ++d) {
    marker.attribute("demo_0" + std::to_string(d), "hand_offset", text(marker_T_palm));
  }
  const std::string a = learned(plain);
  EXPECT_LT(largestDifference(a, learned(marker)), 1e-9);
  EXPECT_GT(largestDifference(a, wrong), 1e-3) << "the offset must matter";
}

TEST(Reading, AToolThatTheGraspsKnowMovesTheTipOnly) {
  // The same gripper, described by a tip further back and the tool that leads to
  // it: reach and arm differ in nothing.
  const TaughtTask plain;
  TaughtTask tool;
  const std::string urdf = testing::readTestFile(tool.folder() + "/robot.urdf");
  const Pose back_T_tip(Vec<double, 3>(0.1, 0, 0.02), Eigen::Quaterniond::Identity());
  std::string xml = testing::readTestFile(tool.task());
  const std::size_t at = xml.find("tip_link=\"") + 10;
  const std::string tip = xml.substr(at, xml.find('"', at) - at);
  std::string longer = urdf;
  longer.insert(longer.rfind("</robot>"),
                "<link name=\"back\"/><joint name=\"back_joint\" type=\"fixed\"><parent link=\"" +
                    tip + "\"/><child link=\"back\"/><origin xyz=\"-0.1 0 -0.02\"/></joint>");
  std::ofstream(tool.folder() + "/robot.urdf", std::ios::binary) << longer;
  tool.replace("tip_link=\"" + tip + "\"", "tip_link=\"back\" tool=\"" + text(back_T_tip) + "\"");
  const std::string a = learned(plain);
  const std::string b = learned(tool);
  EXPECT_LT(largestDifference(a, b), 1e-9);
  const auto read = [](const std::string& path) {
    return nlohmann::json::parse(testing::readTestFile(path)).at("table1").at("after");
  };
  EXPECT_EQ(read(a + "/metrics.json").at("ik_achievable"),
            read(b + "/metrics.json").at("ik_achievable"));
}

TEST(Reading, TracksMayBeCsvWithNamedColumns) {
  const TaughtTask plain;
  TaughtTask csv;
  const Trajectory hand = csv.track("demo_02/hand.tum");
  std::string out = "frame,qw,qx,qy,qz,timestamp,z,y,x\n";
  for (std::size_t i = 0; i < hand.size(); ++i) {
    const Pose& p = hand.poses[i];
    out += "map";
    for (const double v : {p.rotation.w(), p.rotation.x(), p.rotation.y(), p.rotation.z(),
                           hand.times[i], p.translation[2], p.translation[1], p.translation[0]}) {
      out += "," + formatDouble(v);
    }
    out += "\n";
  }
  testing::writeTestFile(csv.folder() + "/demo_02", "hand.csv", out);
  csv.replace("demo_02/hand.tum", "demo_02/hand.csv");
  fs::remove(csv.folder() + "/demo_02/hand.tum");
  const std::string a = learned(plain);
  EXPECT_LT(largestDifference(a, learned(csv)), 1e-9);
  const CommandResult check = graftLfd("check " + csv.task());
  EXPECT_NE(check.err.find("hand.csv:1: note: columns that are not read: 'frame'"),
            std::string::npos)
      << check.err;
}

}  // namespace
}  // namespace graft::lfd
