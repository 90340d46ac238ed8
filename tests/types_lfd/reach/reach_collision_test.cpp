// SPDX-License-Identifier: BSD-3-Clause
// A map of a robot that can hit itself: an arm beside a broad body.
#include <gtest/gtest.h>

#include <memory>

#include "tests/types_lfd/reach/small_map.hpp"
#include "types_lfd/reach/reach_verify.hpp"
#include "types_lfd/robot/self_collision.hpp"

namespace graft::lfd {
namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  text.replace(text.find(from), from.size(), to);
  return text;
}

std::string solid(const char* xyz, const char* geometry) {
  return std::string("<collision><origin xyz=\"") + xyz + "\"/><geometry>" + geometry +
         "</geometry></collision></link>";
}

/// The small robot with a cabinet under the arm (on the base), a head beside it (on
/// the torso), and a forearm and a hand to hit them.
UrdfModel solidRobot() {
  std::string text = testing::smallRobotText();
  text = replaced(text, R"(<link name="base"/>)",
                  "<link name=\"base\">" + solid("0.3 0 0.3", "<box size='0.5 0.8 0.5'/>"));
  text = replaced(text, R"(<link name="torso"/>)",
                  "<link name=\"torso\">" + solid("0 0.3 0.1", "<sphere radius='0.3'/>"));
  text = replaced(text, R"(<link name="wrist"/>)",
                  "<link name=\"wrist\">" + solid("0.15 0 0", "<box size='0.26 0.08 0.08'/>"));
  text = replaced(text, R"(<link name="palm"/>)",
                  "<link name=\"palm\">" + solid("0.06 0 0", "<sphere radius='0.05'/>"));
  Diagnostics diagnostics;
  UrdfModel model = readUrdfText("solid.urdf", text, diagnostics);
  diagnostics.throwIfErrors();
  return model;
}

TEST(ReachMap, CountsNoConfigurationInWhichTheRobotHitsItself) {
  const UrdfModel model = solidRobot();
  const Chain free(model, "base", "tool");
  Chain guarded = free;
  Diagnostics diagnostics;
  guarded.setSelfCollision(std::make_shared<SelfCollision>(model, Srdf(), guarded, diagnostics));
  ASSERT_NE(guarded.selfCollision(), nullptr);

  const ReachMap all = ReachMap::build(free, testing::smallOptions());
  const ReachMap map = ReachMap::build(guarded, testing::smallOptions());
  EXPECT_LT(map.reachableCells(), 0.97 * double(all.reachableCells()));
  EXPECT_GT(map.reachableCells(), 0.3 * double(all.reachableCells()));
  EXPECT_THROW(all.requireChain(guarded, "all.map"), Error);

  // Cells of 10 cm are coarse beside these solids.
  const ReachTrial trial = sampleReachTrial(guarded, ikOracle(guarded, 20), 150, 5);
  const ReachRates rates = measureRates(map, trial);
  EXPECT_GE(rates.true_positive, 0.8);
  EXPECT_GE(rates.true_negative, 0.93);
  // The map that knows no solids calls more of the unreachable poses reachable.
  EXPECT_LT(measureRates(all, trial).true_negative, rates.true_negative - 0.1);
}

}  // namespace
}  // namespace graft::lfd
