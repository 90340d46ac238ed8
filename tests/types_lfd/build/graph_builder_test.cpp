// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/graph_builder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/support/test_data.hpp"
#include "types_lfd/build/base_start.hpp"
#include "types_lfd/build/grasp_modes.hpp"
#include "types_lfd/build/steadiness.hpp"
#include "types_lfd/teach/teacher.hpp"

namespace graft::lfd {
namespace {

using testing::makeTemporaryDirectory;

/// What the graph's size follows from, counted from the files by a reader of its
/// own: stamps inside the span that all tracks of a demonstration cover.
struct Expected {
  std::size_t demonstrations = 0;
  std::size_t tuples = 0;
  std::size_t measured = 0;
};

std::vector<double> stampsOf(const std::string& path) {
  std::ifstream file(path);
  std::vector<double> stamps;
  std::string line;
  while (std::getline(file, line)) {
    if (!line.empty() && line[0] != '#') stamps.push_back(std::stod(line));
  }
  return stamps;
}

void countDemonstration(const std::string& folder, Expected& expected) {
  std::vector<std::vector<double>> tracks;
  double first = -1e300;
  double last = 1e300;
  for (const char* name : {"/hand.tum", "/object.tum", "/torso.tum"}) {
    const std::vector<double> stamps = stampsOf(folder + name);
    if (stamps.empty()) continue;
    first = std::max(first, stamps.front());
    last = std::min(last, stamps.back());
    tracks.push_back(stamps);
  }
  std::set<double> all;
  for (const std::vector<double>& stamps : tracks) {
    for (const double stamp : stamps) {
      if (stamp < first || stamp > last) continue;
      all.insert(stamp);
      ++expected.measured;
    }
  }
  ++expected.demonstrations;
  expected.tuples += all.size();
}

/// Sum of the counts in notes "hand: 2 of 118 poses dropped (...)".
std::size_t droppedPoses(const std::string& notes) {
  std::istringstream words(notes);
  std::vector<std::string> all;
  for (std::string word; words >> word;) all.push_back(word);
  std::size_t dropped = 0;
  for (std::size_t i = 4; i < all.size(); ++i) {
    if (all[i] == "dropped" && all[i - 1] == "poses") dropped += std::stoul(all[i - 4]);
  }
  return dropped;
}

/// Numbers of vertices and edges by type against the formulas of the paper's
/// section IV: N tuples, D demonstrations, M manipulation tuples.
void expectCounts(const PreparedTask& prepared, const Expected& expected) {
  const std::size_t n = expected.tuples;
  const std::size_t d = expected.demonstrations;
  std::size_t m = 0;
  std::size_t contacts = 0;
  for (const PreparedDemonstration& demo : prepared.demonstrations) {
    m += demo.segments.release - demo.segments.grasp + 1;
    for (const std::size_t contact : {demo.segments.grasp, demo.segments.release}) {
      if (contact > 0 && contact + 1 < demo.size()) ++contacts;
    }
  }
  auto counts = buildGraph(prepared, {"grasps.csv", "reach.map", ""}).countsByTag();
  EXPECT_EQ(counts["VERTEX_SE3:QUAT"], 4 * n + 2 + d);  // h, o, t, g; V_HG, V_RG; V_gh
  EXPECT_EQ(counts["LFD_BASE"], n);
  EXPECT_EQ(counts["LFD_OBSERVATION"], expected.measured);    // E1
  EXPECT_EQ(counts["LFD_RELATIVE_MOTION"], 3 * (n - d));      // E2
  EXPECT_EQ(counts["LFD_GRIPPER_SMOOTH"], n - d);             // E3
  EXPECT_EQ(counts["LFD_BASE_SMOOTH"], n - d);                // E3
  EXPECT_EQ(counts["LFD_HUMAN_GRASP"], m);                    // E4
  EXPECT_EQ(counts["LFD_ROBOT_GRASP"], m);                    // E5
  EXPECT_EQ(counts["LFD_GRASP_QUALITY"], 1u);                 // E6
  EXPECT_EQ(counts["LFD_HAND_GRIPPER"], n);                   // E7
  EXPECT_EQ(counts["LFD_RESEMBLANCE"], d);                    // E8
  EXPECT_EQ(counts["LFD_REACHABILITY"], n);                   // E9
  EXPECT_EQ(counts["LFD_GRASP_AGREEMENT"], d * (d - 1) / 2);  // E10
  EXPECT_EQ(counts["LFD_BASE_PRIOR"], n);
  // Hand and object; the hand not across grasp and release.
  EXPECT_EQ(counts["LFD_STEADY_MOTION"], 2 * (n - 2 * d) - contacts);
  EXPECT_EQ(counts.size(), 15u);
}

TEST(BuildGraph, HasTheRoomDoorsVerticesAndEdges) {
  GRAFT_REQUIRE_DATA("tasks/room_door/task.xml");
  Diagnostics diagnostics;
  const PreparedTask prepared =
      prepareTask(testing::dataPath("tasks/room_door/task.xml"), diagnostics);
  Expected expected;
  for (const DemonstrationSpec& spec : prepared.task.demonstrations) {
    countDemonstration(testing::dataPath("tasks/room_door/" + spec.name), expected);
  }
  ASSERT_EQ(expected.demonstrations, 10u);
  // Cleaning may drop one, and says so.
  expected.measured -= droppedPoses(diagnostics.text());
  expectCounts(prepared, expected);
}

TEST(BuildGraph, HasATaughtTasksVerticesAndEdges) {
  const std::string folder = makeTemporaryDirectory() + "/swivel";
  teach("swivel_door", folder, 5);
  Diagnostics diagnostics;
  const PreparedTask prepared = prepareTask(folder + "/task.xml", diagnostics);
  ASSERT_EQ(diagnostics.text().find("dropped"), std::string::npos)
      << "the formulas below count every pose of the files";
  Expected expected;
  for (const DemonstrationSpec& spec : prepared.task.demonstrations) {
    countDemonstration(folder + "/" + spec.name, expected);
  }
  expectCounts(prepared, expected);
}

/// sqrt(1 / information(0, 0)) of every edge of a type.
std::vector<double> sigmasOf(const GraphDescription& graph, const std::string& tag) {
  std::vector<double> sigmas;
  for (const auto& edge : graph.edges) {
    if (edge.tag == tag) sigmas.push_back(1 / std::sqrt(edge.information[0]));
  }
  return sigmas;
}

TEST(BuildGraph, StepsOfTheRobotScaleWithSpeedAndTimeAndNotWithNoise) {
  PreparedTask prepared;
  prepared.demonstrations.resize(1);
  PreparedDemonstration& demo = prepared.demonstrations[0];
  demo.accuracy.hand = demo.accuracy.object = demo.accuracy.torso = {0.01, 0.01};
  constexpr double kSpeed = 0.6;  // m/s
  constexpr int kPoses = 60;
  double time = 0;
  for (int i = 0; i < kPoses; ++i) {
    time += i == 30 ? 0.2 : 0.1;
    const double noise = i % 2 == 0 ? 0.012 : -0.012;  // single steps are 3.6 or 8.4 cm
    const Pose pose(Vec<double, 3>(kSpeed * time + noise, 0, 0), Eigen::Quaterniond::Identity());
    demo.matched.times.push_back(time);
    for (MatchedTrack* track : {&demo.matched.hand, &demo.matched.object, &demo.matched.torso}) {
      track->poses.push_back(pose);
      track->measured.push_back(1);
    }
  }
  demo.segments.grasp = 20;
  demo.segments.release = 40;
  const GraphDescription graph = buildGraph(prepared, {"grasps.csv", "reach.map", ""});
  for (const char* tag : {"LFD_GRIPPER_SMOOTH", "LFD_BASE_SMOOTH"}) {
    const std::vector<double> sigmas = sigmasOf(graph, tag);
    ASSERT_EQ(sigmas.size(), std::size_t(kPoses - 1));
    for (std::size_t i = 0; i < sigmas.size(); ++i) {
      const double step = kSpeed * (demo.matched.times[i + 1] - demo.matched.times[i]);
      EXPECT_NEAR(sigmas[i], step, 0.15 * step) << tag << " " << i;
    }
  }
}

/// The longest steps of the bases that begin a task, and of those nearest to the torso.
struct LongestSteps {
  double start = 0;
  double by_torso = 0;
};

struct Free : BaseFilter {
  explicit Free(const FootprintChecker& checker) : footprint(&checker) {}
  bool isFree(const Pose2& base) const override { return !footprint->inCollision(base); }
  const FootprintChecker* footprint;
};

/// Every base is the nearest to its neighbour's that reaches and is free, from the grasp on.
LongestSteps checkStarts(const std::string& task) {
  Diagnostics diagnostics;
  const PreparedTask prepared = prepareTask(task, diagnostics);
  const TaskScene scene = loadScene(prepared.task, diagnostics);
  const auto starts = startBases(prepared, scene);
  EXPECT_EQ(starts.size(), prepared.demonstrations.size());
  const Sigma& metric = prepared.weights.reachability;
  const auto way = [](const Pose2& a, const Pose2& b) { return std::hypot(b.x - a.x, b.y - a.y); };
  const auto numbersOf = [](const Pose2& p) { return std::vector<double>{p.x, p.y, p.theta}; };
  const Free free(*scene.footprint);
  LongestSteps longest;
  for (std::size_t d = 0; d < starts.size(); ++d) {
    const PreparedDemonstration& demo = prepared.demonstrations[d];
    EXPECT_EQ(starts[d].size(), demo.size());
    Pose2 last;
    for (std::size_t i = 0; i < demo.size(); ++i) {
      const Pose gripper = demo.gripperLikeHand(i);
      EXPECT_TRUE(scene.reach->contains(gripper, starts[d][i])) << demo.matched.name << " " << i;
      EXPECT_FALSE(scene.footprint->inCollision(starts[d][i])) << demo.matched.name << " " << i;
      const Pose2 torso = uprightBase(demo.matched.torso.poses[i]);
      const std::size_t grasp = demo.segments.grasp;
      const Pose2& to = i == grasp ? torso : starts[d][i < grasp ? i + 1 : i - 1];
      const Pose2 expected = scene.reach->nearest(gripper, to, metric.t, metric.r, &free).base;
      EXPECT_EQ(numbersOf(starts[d][i]), numbersOf(expected)) << demo.matched.name << " " << i;
      const Pose2 nearest = scene.reach->nearest(gripper, torso, metric.t, metric.r).base;
      if (i > 0) {
        longest.start = std::max(longest.start, way(starts[d][i - 1], starts[d][i]));
        longest.by_torso = std::max(longest.by_torso, way(last, nearest));
      }
      last = nearest;
    }
  }
  return longest;
}

TEST(StartBases, ReachAndStandFree) {
  const std::string folder = makeTemporaryDirectory() + "/door";
  teach("room_door", folder, 5);
  EXPECT_LT(checkStarts(folder + "/task.xml").start, 0.2);
}

/// Where people walk past the handle the base nearest to the torso changes sides.
TEST(StartBases, KeepToOneSideOfTheHandle) {
  GRAFT_REQUIRE_DATA("tasks/room_door/task.xml");
  const LongestSteps longest = checkStarts(testing::dataPath("tasks/room_door/task.xml"));
  EXPECT_GT(longest.by_torso, 0.45) << "nobody walks past the handle: nothing was tested";
  EXPECT_LT(longest.start, 0.2);
}

TEST(MeanPose, IsTheMidpointOfTwo) {
  const Pose a(Vec<double, 3>(1, 0, 0), expSO3<double>(Vec<double, 3>(0, 0, 0.2)));
  const Pose b(Vec<double, 3>(3, 2, 0), expSO3<double>(Vec<double, 3>(0, 0, 1.0)));
  const Pose mean = meanPose({a, b});
  EXPECT_LT((mean.translation - Vec<double, 3>(2, 1, 0)).norm(), 1e-15);
  EXPECT_NEAR(logSO3(mean.rotation)[2], 0.6, 1e-12);
}

TEST(UprightBase, KeepsThePlaceAndTheHeadingOnly) {
  const Pose torso(Vec<double, 3>(1, 2, 1.1), expSO3<double>(Vec<double, 3>(0, 0, 0.7)) *
                                                  expSO3<double>(Vec<double, 3>(0, 0.3, 0)) *
                                                  expSO3<double>(Vec<double, 3>(0.2, 0, 0)));
  const Pose2 base = uprightBase(torso);
  EXPECT_DOUBLE_EQ(base.x, 1);
  EXPECT_DOUBLE_EQ(base.y, 2);
  EXPECT_NEAR(base.theta, 0.7, 1e-15);
  EXPECT_NEAR(floorPose(base).translation[2], 0, 0);
}

TEST(WeightsFor, TakesNamesAndThePapersNumbers) {
  Task task;
  task.weights.push_back({"E6", 0.5, 0.25, {"t", 3, 0}});
  task.weights.push_back({"resemblance", 0.1, 0.2, {"t", 4, 0}});
  Diagnostics diagnostics;
  const Weights weights = weightsFor(task, diagnostics);
  EXPECT_EQ(weights.grasp_quality.t, 0.5);
  EXPECT_EQ(weights.resemblance.r, 0.2);
  EXPECT_EQ(diagnostics.errorCount(), 0u);
  task.weights.push_back({"E66", 0.5, 0.25, {"t.xml", 5, 0}});
  weightsFor(task, diagnostics);
  ASSERT_EQ(diagnostics.errorCount(), 1u);
  EXPECT_NE(diagnostics.text().find("t.xml:5: error: unknown edge 'E66'"), std::string::npos);
}

TEST(FindSteadiness, KeepsWhatTheTaskGives) {
  PreparedTask prepared;
  prepared.demonstrations.resize(1);
  PreparedDemonstration& demo = prepared.demonstrations[0];
  demo.accuracy.hand = demo.accuracy.object = {0.001, 0.001};
  // Standing still, so that what is estimated is far below the default.
  for (int i = 0; i < 200; ++i) {
    demo.matched.times.push_back(0.05 * i);
    for (MatchedTrack* track : {&demo.matched.hand, &demo.matched.object}) {
      track->poses.emplace_back();
      track->measured.push_back(1);
    }
  }
  demo.segments.grasp = 60;
  demo.segments.release = 140;
  const Weights usual;
  prepared.task.weights.push_back({"steady_hand_free", 0.05, 0.2, {"t", 3, 0}});
  findSteadiness(prepared);
  EXPECT_EQ(prepared.weights.steady_hand_free.t, usual.steady_motion.t);
  EXPECT_LT(prepared.weights.steady_hand_held.t, usual.steady_motion.t);
  EXPECT_LT(prepared.weights.steady_object_free.r, usual.steady_motion.r);
  prepared.weights = usual;
  prepared.task.weights[0].edge = "steady_motion";
  findSteadiness(prepared);
  EXPECT_EQ(prepared.weights.steady_hand_held.t, usual.steady_motion.t);
  EXPECT_EQ(prepared.weights.steady_object_free.r, usual.steady_motion.r);
}

TEST(GraspSpread, FindsTheHandsThatHoldElsewhere) {
  std::vector<PreparedDemonstration> demos(2);
  for (int d = 0; d < 2; ++d) {
    MatchedDemonstration& m = demos[d].matched;
    m.times = {0, 1, 2};
    m.object.poses.assign(3, Pose());
    m.hand.poses.assign(3, Pose(Vec<double, 3>(0.3 * d, 0, 0), Eigen::Quaterniond::Identity()));
    demos[d].segments = {0, 2};
  }
  const GraspSpread spread = graspSpread(demos);
  EXPECT_NEAR(spread.distance, 0.3, 1e-14);
  EXPECT_NEAR(spread.angle, 0, 1e-14);
}

Pose hold(double x, const Vec<double, 3>& turn) {
  return Pose(Vec<double, 3>(x, 0, 0), expSO3<double>(turn));
}

TEST(FindGraspModes, HalfATurnAboutTheApproachIsTheSameHold) {
  const double pi = 3.14159265358979323846;
  const Pose one = hold(0, {0.1, 0.2, 0.3});
  const Pose near = one * hold(0, {0.05, -0.04, 0.03});
  const HoldGap turned = holdGap(one, flippedGrasp(near));
  EXPECT_TRUE(turned.turned);
  EXPECT_NEAR(turned.angle, holdGap(one, near).angle, 1e-12);
  EXPECT_FALSE(holdGap(one, near).turned);
  // Half a turn about another axis is another hold, and so is a quarter turn.
  EXPECT_NEAR(holdGap(one, one * hold(0, {0, pi, 0})).angle, pi, 1e-7);
  EXPECT_NEAR(holdGap(one, one * hold(0, {pi / 2, 0, 0})).angle, pi / 2, 1e-12);

  RecordedHolds holds;
  holds.spread.object_T_hand = {flippedGrasp(one), near, one, flippedGrasp(hold(0.5, {0, 0, 0})),
                                one * hold(0.01, {0, 0, 0.02})};
  holds.modes = findGraspModes(holds.spread);
  ASSERT_EQ(holds.modes.size(), 2u);
  EXPECT_EQ(holds.modes[0].demonstrations, (std::vector<std::size_t>{0, 1, 2, 4}));
  EXPECT_LT(holds.modes[0].angle, 0.1);
  // The majority stays as it is recorded; with two against two the first does.
  EXPECT_EQ(turnedHands({flippedGrasp(one), near, one}), (std::vector<char>{1, 0, 0}));
  EXPECT_EQ(turnedHands({one, flippedGrasp(near)}), (std::vector<char>{0, 1}));
}

TEST(FindGraspModes, SortsBySizeThenSpreadThenOrder) {
  GraspSpread spread;
  for (const double x : {9.0, 0.0, 0.05, 5.0, 1.0, 1.02, 7.0}) {
    spread.object_T_hand.push_back(hold(x, {0, 0, 0}));
  }
  const std::vector<GraspMode> modes = findGraspModes(spread);
  std::vector<std::vector<std::size_t>> members;
  for (const GraspMode& mode : modes) members.push_back(mode.demonstrations);
  EXPECT_EQ(members, (std::vector<std::vector<std::size_t>>{{4, 5}, {1, 2}, {0}, {3}, {6}}));
}

TEST(FindGraspModes, GroupsByCompleteLinkage) {
  // A chain of holds 8 cm apart: neighbours agree, the ends do not, so one mode
  // may not swallow all three.
  GraspSpread spread;
  for (const double x : {0.0, 0.08, 0.16, 1.0}) {
    spread.object_T_hand.emplace_back(Vec<double, 3>(x, 0, 0), Eigen::Quaterniond::Identity());
  }
  // The same place held with the hand turned by a right angle is another way.
  spread.object_T_hand.emplace_back(Vec<double, 3>(1.0, 0, 0),
                                    expSO3<double>(Vec<double, 3>(1.57, 0, 0)));
  const std::vector<GraspMode> modes = findGraspModes(spread);
  ASSERT_EQ(modes.size(), 4u);
  EXPECT_EQ(modes[0].demonstrations.size(), 2u);
  EXPECT_NEAR(modes[0].distance, 0.08, 1e-14);
  for (const GraspMode& mode : modes) {
    for (const std::size_t a : mode.demonstrations) {
      for (const std::size_t b : mode.demonstrations) {
        EXPECT_TRUE(holdGap(spread.object_T_hand[a], spread.object_T_hand[b]).same());
      }
    }
  }
}

}  // namespace
}  // namespace graft::lfd
