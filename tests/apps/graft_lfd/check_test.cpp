// SPDX-License-Identifier: BSD-3-Clause
// What `check` says of good recordings, and of each fault planted into one.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <regex>

#include "tests/apps/graft_lfd/taught_task.hpp"

namespace graft::lfd {
namespace {

using testing::CommandResult;
using testing::graftLfd;
using testing::TaughtTask;

const Eigen::Quaterniond kYUp(std::sqrt(0.5), -std::sqrt(0.5), 0, 0);  // z becomes y

void scaleLengths(const TaughtTask& task, const std::string& entity, double factor) {
  task.forEachPose(entity, [&](double&, Pose& pose) { pose.translation *= factor; });
}

void scaleStamps(const TaughtTask& task, const std::string& entity, double factor) {
  task.forEachPose(entity, [&](double& time, Pose&) { time *= factor; });
}

void everyTrack(const std::function<void(const std::string&)>& change) {
  for (const char* entity : {"hand", "object", "torso"}) change(entity);
}

void swapTracks(const TaughtTask& task, const std::string& a, const std::string& b) {
  for (const auto& entry : std::filesystem::directory_iterator(task.folder())) {
    const std::string demo = entry.path().filename().string();
    if (demo.rfind("demo_", 0) != 0) continue;
    const Trajectory kept = task.track(demo + "/" + a + ".tum");
    task.setTrack(demo + "/" + a + ".tum", task.track(demo + "/" + b + ".tum"));
    task.setTrack(demo + "/" + b + ".tum", kept);
  }
}

struct Fault {
  const char* name;
  const char* task;
  std::function<void(TaughtTask&)> plant;
  int exit_code;        ///< -1: whatever later stages make of it
  const char* message;  ///< regular expression on standard error
};

const Fault kFaults[] = {
    {"millimetres", "room_door",
     [](TaughtTask& t) { everyTrack([&](const std::string& e) { scaleLengths(t, e, 1000); }); }, 3,
     "task\\.xml:\\d+.*: error: demo_01: the positions of the hand .*millimetres; divide them by "
     "1000"},
    {"object in millimetres", "drawer", [](TaughtTask& t) { scaleLengths(t, "object", 1000); }, 3,
     "error: demo_03: the positions of the object .*millimetres"},
    {"centimetres", "drawer",
     [](TaughtTask& t) { everyTrack([&](const std::string& e) { scaleLengths(t, e, 100); }); }, 3,
     "error: demo_01: the positions of the hand .*centimetres; divide them by 100"},
    {"y up", "room_door",
     [](TaughtTask& t) {
       everyTrack([&](const std::string& e) {
         t.forEachPose(e, [](double&, Pose& p) { p = Pose({0, 0, 0}, kYUp) * p; });
       });
     },
     3, "error: demo_01: the torso stands along y, .*turn the tracks so that z is"},
    {"y up without a torso", "drawer",
     [](TaughtTask& t) {
       // The room lies on one side of the camera, as rooms do.
       everyTrack([&](const std::string& e) {
         t.forEachPose(e, [](double&, Pose& p) { p = Pose({0, 0, -9}, kYUp) * p; });
       });
     },
     3, "error: demo_01: the hand is at -.*y seems to be up"},
    {"below the floor", "room_door",
     [](TaughtTask& t) {
       everyTrack([&](const std::string& e) {
         t.forEachPose(e, [](double&, Pose& p) { p.translation[2] -= 1.6; });
       });
     },
     3, "error: demo_01: the hand is at -.* below the floor"},
    {"hand and object swapped", "drawer", [](TaughtTask& t) { swapTracks(t, "hand", "object"); }, 3,
     "error: demo_01: .*hand and object seem to be swapped"},
    {"hand and torso swapped", "room_door", [](TaughtTask& t) { swapTracks(t, "hand", "torso"); },
     3, "error: demo_0\\d: .*hand and torso seem to be swapped"},
    {"one track twice", "drawer",
     [](TaughtTask& t) { t.setTrack("demo_02/hand.tum", t.track("demo_02/object.tum")); }, 3,
     "error: demo_02: hand and object are the same track"},
    {"milliseconds", "drawer",
     [](TaughtTask& t) { everyTrack([&](const std::string& e) { scaleStamps(t, e, 1e3); }); }, 3,
     "error: demo_01: the stamps of the hand are .* s apart .*milliseconds; divide them by "
     "1e\\+03"},
    {"nanoseconds", "room_door",
     [](TaughtTask& t) { everyTrack([&](const std::string& e) { scaleStamps(t, e, 1e9); }); }, 3,
     "error: demo_01: the stamps of the torso .*nanoseconds"},
    {"one clock in milliseconds", "drawer", [](TaughtTask& t) { scaleStamps(t, "object", 1e3); }, 3,
     "stamps of the object|do not overlap"},
    {"clocks apart", "drawer",
     [](TaughtTask& t) {
       t.forEachPose(
           "object", [](double& time, Pose&) { time += 3600; }, "demo_04");
     },
     3,
     "task\\.xml:\\d+.*: error: demonstration 'demo_04': the tracks do not overlap in time: hand "
     "covers .*one clock"},
    {"clocks half apart", "drawer",
     [](TaughtTask& t) {
       t.forEachPose(
           "object", [](double& time, Pose&) { time += 6; }, "demo_04");
     },
     -1, "demo_04: the tracks cover only .* are the clocks the same"},
    {"frozen hand", "drawer",
     [](TaughtTask& t) {
       const Pose first = t.track("demo_05/hand.tum").poses[0];
       t.forEachPose(
           "hand", [&](double&, Pose& p) { p = first; }, "demo_05");
     },
     3, "error: demo_05: the hand never moves"},
    {"object at rest", "drawer",
     [](TaughtTask& t) {
       const Pose first = t.track("demo_05/object.tum").poses[0];
       t.forEachPose(
           "object", [&](double&, Pose& p) { p = first; }, "demo_05");
     },
     3, "task\\.xml:\\d+: error: demonstration 'demo_05': the object never moves"},
    {"accuracy in degrees", "drawer",
     [](TaughtTask& t) {
       const std::string xml = testing::readTestFile(t.task());
       const std::size_t at = xml.find("sigma_r=\"");
       t.replace(xml.substr(at, xml.find('"', at + 9) + 1 - at), "sigma_r=\"11.5\"");
     },
     0, "warning: <tracker> for '\\w+': sigma_r is 11.5 rad; is it in degrees"},
    {"angles for a quaternion", "drawer",
     [](TaughtTask& t) {
       std::string text = testing::readTestFile(t.folder() + "/demo_01/hand.tum");
       text += "1e6 0 0 1 0 0 90 0\n";
       std::ofstream(t.folder() + "/demo_01/hand.tum") << text;
     },
     3, "hand\\.tum:\\d+: error: the quaternion has length 90, expected 1"},
    {"frame numbers", "drawer",
     [](TaughtTask& t) {
       everyTrack([&](const std::string& e) {
         int frame = 0;
         t.forEachPose(e, [&](double& time, Pose&) { time = frame++; });
       });
     },
     -1, "the stamps of the hand rise by 1 each: they look like numbers of frames"},
};

TEST(Check, FindsEachPlantedFault) {
  for (const Fault& fault : kFaults) {
    SCOPED_TRACE(fault.name);
    TaughtTask task(fault.task, 3);
    fault.plant(task);
    const CommandResult check = graftLfd("check " + task.task());
    if (fault.exit_code >= 0) {
      EXPECT_EQ(check.exit_code, fault.exit_code) << check.err;
    }
    EXPECT_TRUE(std::regex_search(check.err, std::regex(fault.message))) << check.err;
  }
}

TEST(Check, SaysOfEveryBadDemonstrationWhatIsWrong) {
  const TaughtTask task;
  for (const char* demo : {"demo_02", "demo_05"}) {
    const Pose first = task.track(std::string(demo) + "/object.tum").poses[0];
    task.forEachPose(
        "object", [&](double&, Pose& p) { p = first; }, demo);
  }
  const CommandResult check = graftLfd("check " + task.task());
  EXPECT_EQ(check.exit_code, 3);
  for (const char* demo : {"'demo_02': the object never", "'demo_05': the object never"}) {
    EXPECT_NE(check.err.find(demo), std::string::npos) << check.err;
  }
}

TEST(Check, HasNothingToSayAgainstTaughtTasks) {
  for (const char* name : {"room_door", "swivel_door", "drawer", "sliding_door"}) {
    for (int seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE(std::string(name) + " seed " + std::to_string(seed));
      const TaughtTask task(name, seed);
      const CommandResult check = graftLfd("check " + task.task());
      EXPECT_EQ(check.exit_code, 0) << check.err;
      EXPECT_EQ(check.err.find("warning"), std::string::npos) << check.err;
      EXPECT_NE(check.out.find("\nusable\n"), std::string::npos) << check.out;
    }
  }
}

TEST(Check, NamesTheTuplesThatNoBaseCouldReach) {
  // The scene lifted by a metre and a half: the drawer is above every arm.
  const TaughtTask high;
  const auto lift = [](double&, Pose& p) { p.translation[2] += 1.5; };
  high.forEachPose("hand", lift, "demo_02");
  high.forEachPose("object", lift, "demo_02");
  const CommandResult part = graftLfd("check " + high.task());
  EXPECT_EQ(part.exit_code, 0) << part.err;
  EXPECT_TRUE(std::regex_search(
      part.out,
      std::regex("  demo_02: 0\\.00 to [\\d.]+ s \\(\\d+ tuples\\): the gripper is up to "
                 "[\\d.]+ m too high for the arm \\(at most [\\d.]+ m over the floor\\)")))
      << part.out;
  EXPECT_EQ(part.out.find("demo_01: 0.00 to"), std::string::npos) << part.out;
  EXPECT_NE(part.out.find("usable, with what is said above"), std::string::npos);
  high.forEachPose("hand", [](double&, Pose& p) { p.translation[2] += 1.5; });
  high.forEachPose("object", [](double&, Pose& p) { p.translation[2] += 1.5; });
  const CommandResult all = graftLfd("check " + high.task());
  EXPECT_EQ(all.exit_code, 4) << all.out;
  EXPECT_NE(all.out.find("not usable: no base reaches any tuple"), std::string::npos);
}

TEST(Check, OfRealMotionCaptureFindsWaysAndReach) {
  GRAFT_REQUIRE_DATA("tasks/mocap_largetable_many_grasps/task.xml");
  const CommandResult suitcase =
      graftLfd("check " + testing::dataPath("tasks/mocap_suitcase/task.xml"));
  EXPECT_EQ(suitcase.exit_code, 0);
  EXPECT_NE(suitcase.out.find("1346 of 1346 tuples are in reach"), std::string::npos);
  const CommandResult table =
      graftLfd("check " + testing::dataPath("tasks/mocap_largetable_many_grasps/task.xml"));
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_TRUE(std::regex_search(
      table.out, std::regex("demo_07: .*the gripper is up to 0\\.\\d+ m too high for the arm")))
      << table.out;
  EXPECT_EQ(table.out.find("inf degrees"), std::string::npos) << table.out;
  EXPECT_NE(table.out.find("usable in part: learn takes mode 0"), std::string::npos);
}

}  // namespace
}  // namespace graft::lfd
