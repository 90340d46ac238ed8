// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "types_lfd/edges/base_pose.hpp"
#include "types_lfd/edges/pose_jacobians.hpp"
#include "types_lfd/map/footprint.hpp"
#include "types_lfd/reach/reach_map.hpp"

namespace graft::lfd {

/// The map that the base must keep off, with the base's footprint; `checker` is
/// null where a task has no map.
struct FreeSpace : BaseFilter {
  std::unique_ptr<const OccupancyMap> map;
  std::unique_ptr<const FootprintChecker> checker;
  bool isFree(const Pose2& world_T_base) const override {
    return checker == nullptr || !checker->inCollision(world_T_base);
  }
};

/// E9, paper eq. 9: (g^-1 b)^-1 x_IRM, x_IRM the reachable base pose nearest to
/// the current one, without those whose footprint hits the map. For an upright
/// base on the floor three of the six numbers vanish by construction; the error
/// is [dx dy dyaw] of b^-1 b*, with b* = x_IRM carried along with the gripper's
/// position and azimuth. A pair that is reachable already is left alone (dead
/// zone): the error measures the distance to the reachable set, not to a sample
/// of it. Association: 1 if outside, then b* seen from the gripper's azimuth
/// frame (x, y, yaw), then 1 if the gripper points up or down so far that its
/// azimuth is taken from the closing axis.
struct ReachabilityEdge : Edge<ReachabilityEdge, 3, SE3, BasePose>,
                          Associated<5>,
                          Using<ReachMap, FreeSpace> {
  static constexpr auto tag = "LFD_REACHABILITY";
  static constexpr auto doc = "E9: base where the arm reaches and the map is free (paper eq. 9)";

  template <class T>
  Vec<T, 3> error(const SE3<T>& gripper, const BasePose<T>& base) const {
    if (association[0] == 0) return Vec<T, 3>(T(0), T(0), T(0));
    const SE2<T> target = azimuthFrame(gripper, association[4] != 0) *
                          SE2<double>::fromArray(association + 1).cast<T>();
    return poseError(base.inverse() * target);
  }

  bool associate(bool first, const Pose& gripper, const BasePose<>& base,
                 const InformationBlock& information, double* chosen) const {
    const double sigma_t = 1 / std::sqrt(information(0, 0));
    const double sigma_r = 1 / std::sqrt(information(2, 2));
    const NearestBase nearest =
        resource<0>().nearest(gripper, base, sigma_t, sigma_r, &resource<1>());
    const double old[2] = {chosen[0], chosen[4]};
    const bool pole = isPole(gripper);
    chosen[0] = nearest.inside ? 0 : 1;
    (azimuthFrame(gripper, pole).inverse() * nearest.base).toArray(chosen + 1);
    chosen[4] = pole ? 1 : 0;
    return first || old[0] != chosen[0] || old[1] != chosen[4];
  }

 private:
  static bool isPole(const Pose& gripper) {
    const Vec<double, 3> approach = gripper.rotation * Vec<double, 3>(1, 0, 0);
    return std::abs(approach[2]) > 0.9239;  // 67.5 degrees
  }
  /// Planar frame at the gripper that turns with its azimuth.
  template <class T>
  static SE2<T> azimuthFrame(const SE3<T>& gripper, bool pole) {
    using std::atan2;
    const Vec<T, 3> axis =
        gripper.rotation * (pole ? Vec<T, 3>(T(0), T(1), T(0)) : Vec<T, 3>(T(1), T(0), T(0)));
    const T azimuth = pole ? atan2(-axis[0], axis[1]) : atan2(axis[1], axis[0]);
    return SE2<T>(gripper.translation[0], gripper.translation[1], azimuth);
  }
};

}  // namespace graft::lfd

template <>
struct graft::ResourceTag<graft::lfd::ReachMap> {
  static constexpr const char* kTag = "LFD_REACH_MAP";
  static constexpr const char* kDoc = "inverse reachability map of a robot's arm";
  static constexpr const char* kFields = "file";
  static std::unique_ptr<const lfd::ReachMap> load(const std::string& directory,
                                                   const std::vector<std::string>& tokens);
};

template <>
struct graft::ResourceTag<graft::lfd::FreeSpace> {
  static constexpr const char* kTag = "LFD_FREE_SPACE";
  static constexpr const char* kDoc = "occupancy map ('-' for none) and footprint of the base";
  static constexpr const char* kFields = "file x y x y x y ...";
  static std::unique_ptr<const lfd::FreeSpace> load(const std::string& directory,
                                                    const std::vector<std::string>& tokens);
};
