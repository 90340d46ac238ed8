// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/reach_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "types_lfd/build/grasp_modes.hpp"

namespace graft::lfd {

namespace {

using Reason = UnreachableRange::Reason;

constexpr double kDegree = 3.14159265358979323846 / 180;
// Tuples in reach between two ranges that do not part them: tracker noise.
constexpr std::size_t kBridged = 2;

/// The least turn about one of the gripper's own axes that brings it into reach
/// at its height, rad, in steps of a sixth of a cell; infinite if there is none.
double leastTurnAboutAxes(const ReachMap& reach, const Pose& gripper) {
  const double step = reach.grid().step() / 6;
  const int most = reach.grid().turn * 3;
  for (int k = 1; k <= most; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        Vec<double, 3> turn = Vec<double, 3>::Zero();
        turn[axis] = sign * k * step;
        const Pose turned(gripper.translation, gripper.rotation * expSO3<double>(turn));
        if (reach.reachableSomewhere(turned)) return k * step;
      }
    }
  }
  return std::numeric_limits<double>::infinity();
}

/// The least turn to any orientation in reach at the gripper's height, rad: about
/// one axis, or else over a grid of orientations at half a cell.
double leastTurn(const ReachMap& reach, const Pose& gripper) {
  double least = leastTurnAboutAxes(reach, gripper);
  if (std::isfinite(least)) return least;
  const double step = reach.grid().step() / 2;
  const int n = 2 * reach.grid().turn;
  const auto about = [&](int axis, int k) {
    Vec<double, 3> turn = Vec<double, 3>::Zero();
    turn[axis] = k * step;
    return expSO3<double>(turn);
  };
  for (int elevation = -n / 4; elevation <= n / 4; ++elevation) {
    for (int roll = 0; roll < n; ++roll) {
      const Eigen::Quaterniond tilt = about(1, -elevation) * about(0, roll);
      if (!reach.reachableSomewhere(Pose(gripper.translation, tilt))) continue;
      for (int heading = 0; heading < n; ++heading) {
        const Eigen::Quaterniond rotation = about(2, heading) * tilt;
        least = std::min(least, rotationAngle(gripper.rotation.conjugate() * rotation));
      }
    }
  }
  return least;
}

/// Adds a tuple to the last range if it continues it, else begins one.
void addTuple(std::size_t i, Reason reason, double by, std::vector<UnreachableRange>& ranges) {
  if (!ranges.empty() && ranges.back().reason == reason && i <= ranges.back().last + 1 + kBridged) {
    ranges.back().last = i;
    ranges.back().by = std::max(ranges.back().by, by);
    return;
  }
  ranges.push_back({reason, i, i, by});
}

}  // namespace

ReachCheck checkReach(const PreparedTask& task, const GraspSet& grasps, const ReachMap& reach) {
  ReachCheck check;
  // heights() goes a cell beyond the last nodes that are reached for sure.
  check.heights = reach.heights();
  check.heights.low += reach.grid().resolution;
  check.heights.high -= reach.grid().resolution;
  std::vector<Pose> held;
  for (const PreparedDemonstration& demo : task.demonstrations) {
    for (std::size_t i = demo.segments.grasp; i <= demo.segments.release; ++i) {
      held.push_back(demo.matched.object.poses[i].inverse() * demo.gripperLikeHand(i));
    }
  }
  const Pose mean = meanPose(held);
  const Sigma& metric = task.weights.grasp_quality;
  check.grasp.choice = grasps.nearest(mean, metric.t, metric.r);
  check.grasp.row = grasps.valid()[static_cast<std::size_t>(check.grasp.choice.index)].row;
  const Pose grasp = grasps.pose(check.grasp.choice);
  const Vec<double, 6> gap = poseError(mean.inverse() * grasp);
  check.grasp.distance = gap.head<3>().norm();
  check.grasp.angle = gap.tail<3>().norm();

  const Pose hand_T_gripper = mean.inverse() * grasp;
  for (const PreparedDemonstration& demo : task.demonstrations) {
    std::vector<UnreachableRange> ranges;
    for (std::size_t i = 0; i < demo.size(); ++i) {
      ++check.tuples;
      // While it is held the object tells where the gripper is.
      const Pose gripper = demo.manipulating(i) ? demo.matched.object.poses[i] * grasp
                                                : demo.gripperLikeHand(i) * hand_T_gripper;
      if (reach.reachableSomewhere(gripper)) continue;
      ++check.unreachable;
      const double z = gripper.translation[2];
      const double above = z - check.heights.high;
      const double below = check.heights.low - z;
      // A cell further nothing is reached, however it is turned.
      const bool near = std::max(above, below) < reach.grid().resolution;
      const double turn =
          near ? leastTurn(reach, gripper) : std::numeric_limits<double>::infinity();
      if (std::isfinite(turn)) {
        addTuple(i, Reason::kTilt, turn, ranges);
      } else {
        addTuple(i, above > below ? Reason::kTooHigh : Reason::kTooLow,
                 std::max({0.0, above, below}), ranges);
      }
    }
    check.ranges.push_back(std::move(ranges));
  }
  return check;
}

std::string describeRange(const PreparedDemonstration& demo, const UnreachableRange& range,
                          const ReachCheck& check) {
  const std::vector<double>& times = demo.matched.times;
  char text[400];
  int length = std::snprintf(text, sizeof text,
                             "%s: %.2f to %.2f s (%zu tuples): ", demo.matched.name.c_str(),
                             times[range.first] - times.front(), times[range.last] - times.front(),
                             range.last - range.first + 1);
  length = std::min(length, int(sizeof text) - 1);
  char* const rest = text + length;
  const std::size_t room = sizeof text - static_cast<std::size_t>(length);
  if (range.reason == Reason::kTilt) {
    std::snprintf(rest, room,
                  "the gripper is tilted up to %.0f degrees out of what the arm can do at this "
                  "height; add grasps with another approach, or hold the object so that the "
                  "hand is less tilted",
                  range.by / kDegree);
  } else {
    const bool high = range.reason == Reason::kTooHigh;
    std::snprintf(rest, room,
                  "the gripper is up to %.2f m too %s for the arm (%s %.2f m over the floor); "
                  "demonstrate it %s, or take a robot that reaches %s",
                  range.by, high ? "high" : "low", high ? "at most" : "at least",
                  high ? check.heights.high : check.heights.low, high ? "lower" : "higher",
                  high ? "higher" : "lower");
  }
  return text;
}

}  // namespace graft::lfd
