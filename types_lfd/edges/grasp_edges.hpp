// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/error.hpp"
#include "types_lfd/edges/pose_jacobians.hpp"
#include "types_lfd/grasp/grasp_set.hpp"

namespace graft::lfd {

/// Half a turn about the x axis, as flippedGrasp() takes it.
template <class T>
SE3<T> halfTurn() {
  return SE3<T>(Vec<T, 3>(T(0), T(0), T(0)), Eigen::Quaternion<T>(T(0), T(1), T(0), T(0)));
}

/// e = poseError(rel^-1 (frame^-1 body)): the pose of `body` in `frame` is the
/// transform `rel`, whatever moves. The form of paper eqs. 4, 5 and 7.
template <class Derived>
struct FixedTransformEdge : Edge<Derived, 6, SE3, SE3, SE3> {
  template <class T>
  Vec<T, 6> error(const SE3<T>& body, const SE3<T>& frame, const SE3<T>& rel) const {
    return poseError(rel.inverse() * (frame.inverse() * body));
  }
  void jacobians(const Pose& body, const Pose& frame, const Pose& rel, JacobianBlock<6, 6> by_body,
                 JacobianBlock<6, 6> by_frame, JacobianBlock<6, 6> by_rel) const {
    const PoseChainDerivatives d(rel, frame, body);
    d.byB(by_body);
    d.byA(by_frame);
    d.byZ(by_rel);
  }
  bool propagate(int to, Pose& body, Pose& frame, Pose& rel) const {
    if (to == 0) body = frame * rel;
    if (to == 1) frame = body * rel.inverse();
    if (to == 2) rel = frame.inverse() * body;
    return true;
  }
};

/// E4, paper eq. 4: hand, object, V_HG = object_T_hand.
struct HumanGraspEdge : FixedTransformEdge<HumanGraspEdge> {
  static constexpr auto tag = "LFD_HUMAN_GRASP";
  static constexpr auto doc = "E4: hand fixed on the object while it is moved (paper eq. 4)";
};

/// E4 of a demonstration whose hand holds the object turned by half a turn about
/// its approach (x) axis against the one that V_HG describes. It has a type of its
/// own, so that files hold the hand as it was recorded.
struct TurnedHumanGraspEdge : Edge<TurnedHumanGraspEdge, 6, SE3, SE3, SE3> {
  static constexpr auto tag = "LFD_HUMAN_GRASP_TURNED";
  static constexpr auto doc = "E4 of a hand that is turned by 180 degrees about its x axis";
  template <class T>
  Vec<T, 6> error(const SE3<T>& hand, const SE3<T>& object, const SE3<T>& object_T_hand) const {
    return poseError(object_T_hand.inverse() * (object.inverse() * (hand * halfTurn<T>())));
  }
};

/// E5, paper eq. 5: gripper, object, V_RG = object_T_gripper.
struct RobotGraspEdge : FixedTransformEdge<RobotGraspEdge> {
  static constexpr auto tag = "LFD_ROBOT_GRASP";
  static constexpr auto doc = "E5: gripper fixed on the object while it is moved (paper eq. 5)";
};

/// E7, paper eq. 7: gripper, hand, V_gh = hand_T_gripper of one demonstration.
struct HandGripperEdge : FixedTransformEdge<HandGripperEdge> {
  static constexpr auto tag = "LFD_HAND_GRIPPER";
  static constexpr auto doc = "E7: gripper follows the hand at a constant offset (paper eq. 7)";
};

/// E8, paper eq. 8: e = V_gh^-1, pulls the offset towards none.
struct ResemblanceEdge : Edge<ResemblanceEdge, 6, SE3> {
  static constexpr auto tag = "LFD_RESEMBLANCE";
  static constexpr auto doc = "E8: gripper resembles the hand (paper eq. 8)";
  template <class T>
  Vec<T, 6> error(const SE3<T>& hand_T_gripper) const {
    return poseError(hand_T_gripper.inverse());
  }
  void jacobians(const Pose& rel, JacobianBlock<6, 6> by_rel) const {
    PoseChainDerivatives(rel, Pose(), Pose()).byZ(by_rel);
  }
};

/// E8 of a demonstration whose hand is turned (see E4): pulls V_gh towards half a
/// turn about the x axis.
struct TurnedResemblanceEdge : Edge<TurnedResemblanceEdge, 6, SE3> {
  static constexpr auto tag = "LFD_RESEMBLANCE_TURNED";
  static constexpr auto doc = "E8 of a hand that is turned by 180 degrees about its x axis";
  template <class T>
  Vec<T, 6> error(const SE3<T>& hand_T_gripper) const {
    return poseError(hand_T_gripper.inverse() * halfTurn<T>());
  }
};

/// E6, paper eq. 6: e = V_RG^-1 g, g the candidate of the grasp set that is nearest
/// by this edge's own metric e' Omega e. A parallel gripper may grasp turned by half
/// a turn about its approach axis, so every sample counts twice. Association: pose of
/// g (7), row in the file, 1 if turned.
struct GraspQualityEdge : Edge<GraspQualityEdge, 6, SE3>, Associated<9>, Using<GraspSet> {
  static constexpr auto tag = "LFD_GRASP_QUALITY";
  static constexpr auto doc = "E6: gripper at the nearest valid grasp (paper eq. 6)";
  template <class T>
  Vec<T, 6> error(const SE3<T>& object_T_gripper) const {
    return poseError(object_T_gripper.inverse() * SE3<T>::fromArray(association));
  }
  void jacobians(const Pose& object_T_gripper, JacobianBlock<6, 6> by_grasp) const {
    PoseChainDerivatives(object_T_gripper, Pose(), Pose::fromArray(association)).byZ(by_grasp);
  }
  bool alternative(int k, double* chosen) const {
    const auto& candidates = resource<>().candidates();
    if (static_cast<std::size_t>(k) >= candidates.size()) return false;
    choose(candidates[static_cast<std::size_t>(k)], chosen);
    return true;
  }
  bool associate(bool first, const Pose& object_T_gripper, const InformationBlock& information,
                 double* chosen) const {
    const Pose gripper_T_object = object_T_gripper.inverse();
    double least = 0;
    const GraspSet::Candidate* best = nullptr;
    for (const GraspSet::Candidate& candidate : resource<>().candidates()) {
      const Vec<double, 6> e = poseError(gripper_T_object * candidate.object_T_gripper);
      const double cost = e.dot(information * e);
      if (best != nullptr && !(cost < least)) continue;
      least = cost;
      best = &candidate;
    }
    if (best == nullptr) throw Error(ExitCode::kNoResult, "the grasp set is empty");
    const double row = chosen[7];
    const double turned = chosen[8];
    choose(*best, chosen);
    return first || chosen[7] != row || chosen[8] != turned;
  }

 private:
  static void choose(const GraspSet::Candidate& candidate, double* chosen) {
    candidate.object_T_gripper.toArray(chosen);
    chosen[7] = candidate.row;
    chosen[8] = candidate.flipped ? 1 : 0;
  }
};

/// E10: the grasp poses of two demonstrations agree. The paper takes eq. 3 in
/// the map frame; here both grippers are seen from their object, for the object
/// may stand elsewhere in every demonstration: e of
/// (o_1^-1 g_1)^-1 (o_2^-1 g_2), vertices g_1, o_1, g_2, o_2.
struct GraspAgreementEdge : Edge<GraspAgreementEdge, 6, SE3, SE3, SE3, SE3> {
  static constexpr auto tag = "LFD_GRASP_AGREEMENT";
  static constexpr auto doc = "E10: grasp poses of two demonstrations agree on the object";
  template <class T>
  Vec<T, 6> error(const SE3<T>& g_1, const SE3<T>& o_1, const SE3<T>& g_2,
                  const SE3<T>& o_2) const {
    return poseError((o_1.inverse() * g_1).inverse() * (o_2.inverse() * g_2));
  }
};

}  // namespace graft::lfd

template <>
struct graft::ResourceTag<graft::lfd::GraspSet> {
  static constexpr const char* kTag = "LFD_GRASP_SET";
  static constexpr const char* kDoc = "sampled grasps in the object's frame";
  static constexpr const char* kFields =
      "file min_quality [x y z qx qy qz qw sigma_t sigma_r: only grasps like this one]";
  static std::unique_ptr<const lfd::GraspSet> load(const std::string& directory,
                                                   const std::vector<std::string>& tokens);
};
