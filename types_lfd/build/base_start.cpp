// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/base_start.hpp"

#include "types_lfd/build/graph_builder.hpp"

namespace graft::lfd {

namespace {

struct FreeOfMap : BaseFilter {
  explicit FreeOfMap(const FootprintChecker* given) : checker(given) {}
  bool isFree(const Pose2& world_T_base) const override {
    return checker == nullptr || !checker->inCollision(world_T_base);
  }
  const FootprintChecker* checker;
};

}  // namespace

std::vector<std::vector<Pose2>> startBases(const PreparedTask& task, const TaskScene& scene) {
  const Sigma& metric = task.weights.reachability;
  const FreeOfMap space(scene.footprint.get());
  std::vector<std::vector<Pose2>> all;
  for (const PreparedDemonstration& demo : task.demonstrations) {
    const auto nearest = [&](std::size_t i, const Pose2& to) {
      return scene.reach->nearest(demo.gripperLikeHand(i), to, metric.t, metric.r, &space).base;
    };
    std::vector<Pose2> bases(demo.size());
    const std::size_t grasp = demo.segments.grasp;
    bases[grasp] = nearest(grasp, uprightBase(demo.matched.torso.poses[grasp]));
    for (std::size_t i = grasp; i > 0; --i) bases[i - 1] = nearest(i - 1, bases[i]);
    for (std::size_t i = grasp + 1; i < demo.size(); ++i) bases[i] = nearest(i, bases[i - 1]);
    all.push_back(std::move(bases));
  }
  return all;
}

}  // namespace graft::lfd
