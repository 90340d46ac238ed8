// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/geometry/se2.hpp"
#include "types_lfd/build/graph_description.hpp"
#include "types_lfd/build/prepare.hpp"

namespace graft::lfd {

/// Which vertex has which id: V_HG 0, V_RG 1, V_gh 2 .. 1+D, then five per
/// tuple (hand, object, torso, gripper, base), demonstration after
/// demonstration.
class GraphLayout {
 public:
  enum Entity { kHand = 0, kObject = 1, kTorso = 2, kGripper = 3, kBase = 4 };
  static constexpr std::int64_t kHumanGrasp = 0;
  static constexpr std::int64_t kRobotGrasp = 1;

  explicit GraphLayout(const std::vector<PreparedDemonstration>& demonstrations);

  std::int64_t handToGripper(std::size_t demo) const { return 2 + std::int64_t(demo); }
  std::int64_t vertex(std::size_t demo, std::size_t tuple, Entity entity) const {
    return first_[demo] + 5 * std::int64_t(tuple) + entity;
  }

 private:
  std::vector<std::int64_t> first_;
};

/// File names that the graph's resources refer to. An empty map = no map.
struct ResourceFiles {
  std::string grasps;
  std::string reach_map;
  std::string map;
};

/// The upright floor pose under a torso: x, y, and the heading of its x axis.
Pose2 uprightBase(const Pose& world_T_torso);

/// base_link on the floor in space: z = 0, upright.
Pose floorPose(const Pose2& world_T_base);

/// Builds the hypergraph over all demonstrations (paper, section IV; edges E1 to
/// E10 and the priors of docs): initial estimates are the matched poses, the
/// gripper begins at the hand, the base as `bases` says (per demonstration and tuple; see
/// startBases(); empty = under the torso), V_HG and V_RG at the
/// mean of object_T_hand over the manipulation, V_gh at identity. Where a hand is
/// turned (PreparedDemonstration), gripper and V_gh begin turned back, and E4 and
/// E8 are the types for turned hands.
GraphDescription buildGraph(const PreparedTask& task, const ResourceFiles& files,
                            const std::vector<std::vector<Pose2>>& bases = {});

}  // namespace graft::lfd
