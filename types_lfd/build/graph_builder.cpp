// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/graph_builder.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/text.hpp"

namespace graft::lfd {

namespace {

using Entity = GraphLayout::Entity;

/// Upper triangle of diag(1/t^2 x3, 1/r^2 x3).
std::vector<double> poseInformation(const Sigma& sigma) {
  std::vector<double> upper;
  for (int row = 0; row < 6; ++row) {
    const double s = row < 3 ? sigma.t : sigma.r;
    for (int column = row; column < 6; ++column) upper.push_back(row == column ? 1 / (s * s) : 0);
  }
  return upper;
}

/// Upper triangle of diag(1/t^2, 1/t^2, 1/r^2).
std::vector<double> planarInformation(const Sigma& sigma) {
  const double t = 1 / (sigma.t * sigma.t);
  return {t, 0, 0, t, 0, 1 / (sigma.r * sigma.r)};
}

std::vector<double> numbers(const Pose& pose) {
  std::vector<double> v(7);
  pose.toArray(v.data());
  return v;
}

/// How far a track goes from pose i - 1 to pose i, at its mean speed in the half second
/// around: a single step is as long as the tracker's noise makes it.
Sigma stepAtMeanSpeed(const std::vector<Pose>& poses, const std::vector<double>& times,
                      std::size_t i) {
  constexpr double kHalfWindow = 0.25;  // s
  const double middle = 0.5 * (times[i - 1] + times[i]);
  std::size_t first = i - 1;
  std::size_t last = i;
  while (first > 0 && times[first - 1] >= middle - kHalfWindow) --first;
  while (last + 1 < times.size() && times[last + 1] <= middle + kHalfWindow) ++last;
  const double share = (times[i] - times[i - 1]) / (times[last] - times[first]);
  const Vec<double, 6> chord = poseError(poses[first].inverse() * poses[last]);
  return {share * chord.head<3>().norm(), share * chord.tail<3>().norm()};
}

std::vector<double> numbers(const Pose2& pose) { return {pose.x, pose.y, pose.theta}; }

class Builder {
 public:
  Builder(const PreparedTask& prepared, const ResourceFiles& files,
          const std::vector<std::vector<Pose2>>& bases)
      : prepared_(prepared),
        w_(prepared.weights),
        bases_(bases),
        layout_(prepared.demonstrations),
        mean_grasp_(meanGrasp()) {
    addResources(files);
    addGraspVertices();
    for (std::size_t d = 0; d < prepared_.demonstrations.size(); ++d) addDemonstration(d);
    addGraspAgreement();
  }

  GraphDescription take() { return std::move(graph_); }

 private:
  static constexpr std::int64_t kGraspSet = 0;
  static constexpr std::int64_t kReachMap = 1;
  static constexpr std::int64_t kFreeSpace = 2;

  const PreparedDemonstration& demo(std::size_t d) const { return prepared_.demonstrations[d]; }

  void addEdge(const char* tag, std::vector<std::int64_t> vertices, std::vector<double> information,
               std::vector<double> measurement = {}, std::vector<std::int64_t> resources = {}) {
    graph_.edges.push_back({tag, std::move(vertices), std::move(resources), std::move(measurement),
                            std::move(information)});
  }
  void addPose(std::int64_t id, const Pose& pose) {
    graph_.vertices.push_back({"VERTEX_SE3:QUAT", id, numbers(pose)});
  }

  void addResources(const ResourceFiles& files) {
    std::vector<std::string> grasps{files.grasps, formatDouble(prepared_.task.min_quality)};
    for (const double x : numbers(mean_grasp_)) grasps.push_back(formatDouble(x));
    grasps.push_back(formatDouble(w_.grasp_quality.t));
    grasps.push_back(formatDouble(w_.grasp_quality.r));
    graph_.resources.push_back({"LFD_GRASP_SET", kGraspSet, grasps});
    graph_.resources.push_back({"LFD_REACH_MAP", kReachMap, {files.reach_map}});
    std::vector<std::string> space{files.map.empty() ? "-" : files.map};
    for (const Eigen::Vector2d& corner : prepared_.task.robot.footprint) {
      space.push_back(formatDouble(corner.x()));
      space.push_back(formatDouble(corner.y()));
    }
    graph_.resources.push_back({"LFD_FREE_SPACE", kFreeSpace, space});
  }

  /// object_T_hand, over the manipulation of all demonstrations.
  Pose meanGrasp() const {
    std::vector<Pose> held;
    for (const PreparedDemonstration& d : prepared_.demonstrations) {
      for (std::size_t i = d.segments.grasp; i <= d.segments.release; ++i) {
        held.push_back(d.matched.object.poses[i].inverse() * d.gripperLikeHand(i));
      }
    }
    return meanPose(held);
  }

  void addGraspVertices() {
    addPose(GraphLayout::kHumanGrasp, mean_grasp_);
    addPose(GraphLayout::kRobotGrasp, mean_grasp_);
    for (std::size_t d = 0; d < prepared_.demonstrations.size(); ++d) {
      addPose(layout_.handToGripper(d), demo(d).hand_turned ? flippedGrasp(Pose()) : Pose());
    }
    addEdge("LFD_GRASP_QUALITY", {GraphLayout::kRobotGrasp}, poseInformation(w_.grasp_quality), {},
            {kGraspSet});
  }

  void addDemonstration(std::size_t d) {
    const PreparedDemonstration& p = demo(d);
    for (std::size_t i = 0; i < p.size(); ++i) {
      addPose(layout_.vertex(d, i, Entity::kHand), p.matched.hand.poses[i]);
      addPose(layout_.vertex(d, i, Entity::kObject), p.matched.object.poses[i]);
      addPose(layout_.vertex(d, i, Entity::kTorso), p.matched.torso.poses[i]);
      addPose(layout_.vertex(d, i, Entity::kGripper), p.gripperLikeHand(i));
      graph_.vertices.push_back(
          {"LFD_BASE", layout_.vertex(d, i, Entity::kBase),
           numbers(bases_.empty() ? uprightBase(p.matched.torso.poses[i]) : bases_[d][i])});
    }
    addHumanTrack(d, Entity::kHand, p.matched.hand, p.accuracy.hand, true);
    addHumanTrack(d, Entity::kObject, p.matched.object, p.accuracy.object, true);
    addHumanTrack(d, Entity::kTorso, p.matched.torso, p.accuracy.torso, false);
    addHumanGrasp(d);
    addGripper(d);
    addBase(d);
  }

  /// E1 on measured poses, E2 on all consecutive pairs, the motion prior.
  void addHumanTrack(std::size_t d, Entity entity, const MatchedTrack& track,
                     const TrackerAccuracy& accuracy, bool steady) {
    const std::vector<double>& times = demo(d).matched.times;
    const std::vector<double> observation = poseInformation({accuracy.sigma_t, accuracy.sigma_r});
    for (std::size_t i = 0; i < track.poses.size(); ++i) {
      if (track.measured[i]) {
        addEdge("LFD_OBSERVATION", {layout_.vertex(d, i, entity)}, observation,
                numbers(track.poses[i]));
      }
      if (i == 0) continue;
      const bool both = track.measured[i] && track.measured[i - 1];
      const double factor = w_.relative_motion_factor * (both ? 1 : w_.interpolated_factor);
      addEdge("LFD_RELATIVE_MOTION",
              {layout_.vertex(d, i - 1, entity), layout_.vertex(d, i, entity)},
              poseInformation({factor * accuracy.sigma_t, factor * accuracy.sigma_r}),
              numbers(track.poses[i - 1].inverse() * track.poses[i]));
      if (!steady || i < 2) continue;
      // A hand stops at the object, and leaves it, at once.
      const Segmentation& segments = demo(d).segments;
      const bool contact = i - 1 == segments.grasp || i - 1 == segments.release;
      if (entity == Entity::kHand && contact) continue;
      const double dt_1 = times[i - 1] - times[i - 2];
      const double dt_2 = times[i] - times[i - 1];
      const double root = std::sqrt(0.5 * (dt_1 + dt_2));
      const Sigma& steady = steadiness(entity, demo(d).phase(i - 1));
      addEdge("LFD_STEADY_MOTION",
              {layout_.vertex(d, i - 2, entity), layout_.vertex(d, i - 1, entity),
               layout_.vertex(d, i, entity)},
              poseInformation({steady.t * root, steady.r * root}), {dt_1, dt_2});
    }
  }

  const Sigma& steadiness(Entity entity, MotionPhase phase) const {
    const bool hand = entity == Entity::kHand;
    switch (phase) {
      case MotionPhase::kFree:
        return hand ? w_.steady_hand_free : w_.steady_object_free;
      case MotionPhase::kContact:
        return hand ? w_.steady_hand_contact : w_.steady_object_contact;
      case MotionPhase::kHeld:
        break;
    }
    return hand ? w_.steady_hand_held : w_.steady_object_held;
  }

  /// E4 on the manipulation.
  void addHumanGrasp(std::size_t d) {
    for (std::size_t i = demo(d).segments.grasp; i <= demo(d).segments.release; ++i) {
      addEdge(demo(d).hand_turned ? "LFD_HUMAN_GRASP_TURNED" : "LFD_HUMAN_GRASP",
              {layout_.vertex(d, i, Entity::kHand), layout_.vertex(d, i, Entity::kObject),
               GraphLayout::kHumanGrasp},
              poseInformation(w_.human_grasp));
    }
  }

  /// E3, E5, E7 and E8.
  void addGripper(std::size_t d) {
    const PreparedDemonstration& p = demo(d);
    const std::int64_t offset = layout_.handToGripper(d);
    addEdge(p.hand_turned ? "LFD_RESEMBLANCE_TURNED" : "LFD_RESEMBLANCE", {offset},
            poseInformation(w_.resemblance));
    for (std::size_t i = 0; i < p.size(); ++i) {
      const std::int64_t gripper = layout_.vertex(d, i, Entity::kGripper);
      addEdge("LFD_HAND_GRIPPER", {gripper, layout_.vertex(d, i, Entity::kHand), offset},
              poseInformation(w_.hand_gripper));
      if (p.manipulating(i)) {
        addEdge("LFD_ROBOT_GRASP",
                {gripper, layout_.vertex(d, i, Entity::kObject), GraphLayout::kRobotGrasp},
                poseInformation(w_.robot_grasp));
      }
      if (i == 0) continue;
      addEdge(
          "LFD_GRIPPER_SMOOTH", {layout_.vertex(d, i - 1, Entity::kGripper), gripper},
          poseInformation(smoothSigma(stepAtMeanSpeed(p.matched.hand.poses, p.matched.times, i))));
    }
  }

  /// E3, E9 and the prior of the base.
  void addBase(std::size_t d) {
    const PreparedDemonstration& p = demo(d);
    std::vector<Pose> upright;
    for (const Pose& torso : p.matched.torso.poses)
      upright.push_back(floorPose(uprightBase(torso)));
    for (std::size_t i = 0; i < p.size(); ++i) {
      const std::int64_t base = layout_.vertex(d, i, Entity::kBase);
      addEdge("LFD_BASE_PRIOR", {base}, planarInformation(w_.base_prior),
              numbers(uprightBase(p.matched.torso.poses[i])));
      addEdge("LFD_REACHABILITY", {layout_.vertex(d, i, Entity::kGripper), base},
              planarInformation(w_.reachability), {}, {kReachMap, kFreeSpace});
      if (i == 0) continue;
      addEdge("LFD_BASE_SMOOTH", {layout_.vertex(d, i - 1, Entity::kBase), base},
              planarInformation(smoothSigma(stepAtMeanSpeed(upright, p.matched.times, i))));
    }
  }

  Sigma smoothSigma(const Sigma& step) const {
    return {w_.smooth_factor * std::max(step.t, w_.smooth_floor.t),
            w_.smooth_factor * std::max(step.r, w_.smooth_floor.r)};
  }

  /// E10 between the grasp poses of every pair of demonstrations.
  void addGraspAgreement() {
    const auto vertex = [&](std::size_t d, Entity entity) {
      return layout_.vertex(d, demo(d).segments.grasp, entity);
    };
    for (std::size_t b = 0; b < prepared_.demonstrations.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        addEdge("LFD_GRASP_AGREEMENT",
                {vertex(a, Entity::kGripper), vertex(a, Entity::kObject),
                 vertex(b, Entity::kGripper), vertex(b, Entity::kObject)},
                poseInformation(w_.grasp_agreement));
      }
    }
  }

  const PreparedTask& prepared_;
  const Weights& w_;
  const std::vector<std::vector<Pose2>>& bases_;
  GraphLayout layout_;
  Pose mean_grasp_;
  GraphDescription graph_;
};

}  // namespace

GraphLayout::GraphLayout(const std::vector<PreparedDemonstration>& demonstrations) {
  std::int64_t next = 2 + std::int64_t(demonstrations.size());
  for (const PreparedDemonstration& d : demonstrations) {
    first_.push_back(next);
    next += 5 * std::int64_t(d.size());
  }
}

Pose2 uprightBase(const Pose& world_T_torso) {
  const Vec<double, 3> forward = world_T_torso.rotation * Vec<double, 3>(1, 0, 0);
  return Pose2(world_T_torso.translation[0], world_T_torso.translation[1],
               std::atan2(forward[1], forward[0]));
}

Pose floorPose(const Pose2& world_T_base) {
  return Pose(Vec<double, 3>(world_T_base.x, world_T_base.y, 0),
              expSO3<double>(Vec<double, 3>(0, 0, world_T_base.theta)));
}

GraphDescription buildGraph(const PreparedTask& task, const ResourceFiles& files,
                            const std::vector<std::vector<Pose2>>& bases) {
  return Builder(task, files, bases).take();
}

}  // namespace graft::lfd
