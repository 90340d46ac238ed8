// SPDX-License-Identifier: BSD-3-Clause
// Maps of real robots against inverse kinematics. That of KDL, where it was found
// when this was built, is asked about a few of the poses only: it is slow.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/support/test_data.hpp"
#include "tests/types_lfd/reach/small_map.hpp"
#include "types_lfd/reach/reach_verify.hpp"
#ifdef GRAFT_HAS_KDL
#include "tests/types_lfd/reach/kdl_oracle.hpp"
#endif

namespace graft::lfd {
namespace {

using testing::onFloor;
using testing::uniform;

constexpr double kRate = 0.96;
constexpr int kCount = 2000;

void check(const char* file, const char* tip) {
  const std::string path = graft::testing::dataPath(file);
  Diagnostics diagnostics;
  const Chain chain(readUrdf(path, diagnostics), "base_footprint", tip);
  ReachOptions options;
  options.max_samples = std::uint64_t{1} << 20;  // half of the default, for speed
  const ReachMap map = ReachMap::build(chain, options);
  const ReachOracle oracle = ikOracle(chain, 30);
  const ReachTrial trial = sampleReachTrial(chain, oracle, kCount, 5);
  const ReachRates rates = measureRates(map, trial);
  EXPECT_GE(rates.true_positive, kRate);
  EXPECT_GE(rates.true_negative, kRate);

#ifdef GRAFT_HAS_KDL
  const testing::KdlOracle kdl(path, "base_footprint", tip, 5);
  int reached_by_kdl = 0;
  for (std::size_t i = 0; i < 8; ++i) reached_by_kdl += kdl(trial.unreachable[i]) ? 1 : 0;
  EXPECT_EQ(reached_by_kdl, 0);
  for (std::size_t i = 0; i < 8; ++i) reached_by_kdl += kdl(trial.reachable[i]) ? 1 : 0;
  EXPECT_GE(reached_by_kdl, 5);
#endif

  // The other direction: bases that are proposed reach the gripper's pose.
  std::mt19937_64 random(6);
  int proposed = 0;
  int reached = 0;
  for (int n = 0; n < 250; ++n) {
    const Pose gripper = chain.forward(sampleJoints(chain, random));
    const Pose2 base(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -3, 3));
    const NearestBase nearest = map.nearest(gripper, base, 0.05, 0.2);
    if (!nearest.found || nearest.inside) continue;
    ++proposed;
    reached += oracle(onFloor(nearest.base).inverse() * gripper) ? 1 : 0;
  }
  EXPECT_GT(proposed, 100);
  EXPECT_GE(reached, kRate * proposed);
  std::printf("%s: true positive rate %.4f, true negative rate %.4f, bases reached %d of %d\n",
              file, rates.true_positive, rates.true_negative, reached, proposed);
}

TEST(ReachAccuracy, Pr2) {
  GRAFT_REQUIRE_DATA("robots/pr2/pr2_moveit_resources.urdf");
  check("robots/pr2/pr2_moveit_resources.urdf", "r_gripper_tool_frame");
}

TEST(ReachAccuracy, Tiago) {
  GRAFT_REQUIRE_DATA("robots/tiago/tiago_no_hand.urdf");
  check("robots/tiago/tiago_no_hand.urdf", "arm_tool_link");
}

}  // namespace
}  // namespace graft::lfd
