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
/// base on the floor three of the six numbers vanish by construction; left are x,
/// y and yaw of the base in the planar frame that moves and turns with the
/// gripper's azimuth. The error measures the distance to the reachable *set*: a
/// pair that is reachable already is left alone (dead zone), and otherwise only
/// the step along the normal towards the nearest reachable pose counts (point to
/// plane; point to point would creep along the boundary). Association: where the
/// base should be (3), a and b (3 each, zero if reachable) of e = b (a' off), and 1
/// or -1 if the gripper points up or down so far that its heading includes its roll.
struct ReachabilityEdge : Edge<ReachabilityEdge, 3, SE3, BasePose>,
                          Associated<10>,
                          Using<ReachMap, FreeSpace> {
  static constexpr auto tag = "LFD_REACHABILITY";
  static constexpr auto doc = "E9: base where the arm reaches and the map is free (paper eq. 9)";

  template <class T>
  Vec<T, 3> error(const SE3<T>& gripper, const BasePose<T>& base) const {
    const double* a = association + 3;
    const double* b = association + 6;
    Vec<T, 3> e(T(0), T(0), T(0));
    if (a[0] == 0 && a[1] == 0 && a[2] == 0) return e;
    const SE2<T> seen = headingFrame(gripper, association[9]).inverse() * base;
    const T along = a[0] * (seen.x - association[0]) + a[1] * (seen.y - association[1]) +
                    a[2] * wrapAngle(T(seen.theta - association[2]));
    for (int i = 0; i < 3; ++i) e[i] = b[i] * along;
    return e;
  }

  bool associate(bool first, const Pose& gripper, const BasePose<>& base,
                 const InformationBlock& information, double* chosen) const {
    const double sigma_t = 1 / std::sqrt(information(0, 0));
    const double sigma_r = 1 / std::sqrt(information(2, 2));
    const NearestBase nearest =
        resource<0>().nearest(gripper, base, sigma_t, sigma_r, &resource<1>());
    const double cap = capOf(gripper);
    const Pose2 frame = headingFrame(gripper, cap).inverse();
    const Pose2 seen = frame * base;
    const Pose2 wanted = frame * nearest.base;
    // The unit normal n of the metric diag(sigma)^-2: a = n / sigma, b = n sigma.
    const double sigma[3] = {sigma_t, sigma_t, sigma_r};
    const double off[3] = {(seen.x - wanted.x) / sigma_t, (seen.y - wanted.y) / sigma_t,
                           wrapAngle(seen.theta - wanted.theta) / sigma_r};
    const double length = std::sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
    const bool away = !nearest.inside && length > 0;
    const bool was_away = chosen[3] != 0 || chosen[4] != 0 || chosen[5] != 0;
    const bool changed = first || chosen[9] != cap || away != was_away;
    wanted.toArray(chosen);
    for (int i = 0; i < 3; ++i) {
      const double normal = away ? off[i] / length : 0;
      chosen[3 + i] = normal / sigma[i];
      chosen[6 + i] = normal * sigma[i];
    }
    chosen[9] = cap;
    return changed;
  }

 private:
  /// 1 or -1 where the gripper points up or down so steeply that its azimuth
  /// alone is no steady heading, else 0.
  static double capOf(const Pose& gripper) {
    constexpr double kSteep = 0.92387953251128674;  // sin(67.5 degrees)
    const double up = (gripper.rotation * Vec<double, 3>(1, 0, 0))[2];
    return up >= kSteep ? 1 : up <= -kSteep ? -1 : 0;
  }
  /// Planar frame at the gripper that turns with its heading: the azimuth a of
  /// the approach axis, or a + r (pointing up) and a - r (down) with the roll r of
  /// R = Rz(a) Ry(-e) Rx(r), by half angles, which stay smooth at the poles.
  template <class T>
  static SE2<T> headingFrame(const SE3<T>& gripper, double cap) {
    using std::atan2;
    const Eigen::Quaternion<T>& q = gripper.rotation;
    T heading;
    if (cap > 0) {
      heading = 2.0 * atan2(T(q.z() + q.x()), T(q.w() - q.y()));
    } else if (cap < 0) {
      heading = 2.0 * atan2(T(q.z() - q.x()), T(q.w() + q.y()));
    } else {
      const Vec<T, 3> approach = q * Vec<T, 3>(T(1), T(0), T(0));
      heading = atan2(approach[1], approach[0]);
    }
    return SE2<T>(gripper.translation[0], gripper.translation[1], heading);
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
