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
/// plane; point to point would creep along the boundary). Since the set changes
/// with the gripper's height and tilt, so does the distance; without those slopes
/// the gradient would not be that of the cost. Where an obstacle keeps the base
/// off, the plane stays in the world. Association: as in `Chosen`.
struct ReachabilityEdge : Edge<ReachabilityEdge, 3, SE3, BasePose>,
                          Associated<17>,
                          Using<ReachMap, FreeSpace> {
  static constexpr auto tag = "LFD_REACHABILITY";
  static constexpr auto doc = "E9: base where the arm reaches and the map is free (paper eq. 9)";

  /// What the numbers of the association are.
  enum Chosen {
    kWanted = 0,  ///< base pose, in the heading frame or in the world
    kAcross = 3,  ///< a, and
    kAlong = 6,   ///< b of e = b (a' off + slopes' change); both zero if reachable
    kCap = 9,  ///< 1, -1 if the gripper points up, down so far that its heading includes its roll
    kWorld = 10,  ///< 1 if the plane stays in the world
    kSlope = 11,  ///< by height, elevation and roll of the gripper,
    kFrom = 14,   ///< which were these
  };

  template <class T>
  Vec<T, 3> error(const SE3<T>& gripper, const BasePose<T>& base) const {
    const double* a = association + kAcross;
    const double* b = association + kAlong;
    Vec<T, 3> e(T(0), T(0), T(0));
    if (a[0] == 0 && a[1] == 0 && a[2] == 0) return e;
    const double* wanted = association + kWanted;
    const SE2<T> seen = association[kWorld] != 0
                            ? SE2<T>(base)
                            : headingFrame(gripper, association[kCap]).inverse() * base;
    T along = a[0] * (seen.x - wanted[0]) + a[1] * (seen.y - wanted[1]) +
              a[2] * wrapAngle(T(seen.theta - wanted[2]));
    const double* slope = association + kSlope;
    const double* from = association + kFrom;
    along += slope[0] * (gripper.translation[2] - from[0]);
    if (slope[1] != 0) along += slope[1] * (elevationOf(gripper) - from[1]);
    if (slope[2] != 0) along += slope[2] * wrapAngle(T(rollOf(gripper) - from[2]));
    for (int i = 0; i < 3; ++i) e[i] = b[i] * along;
    return e;
  }

  bool associate(bool first, const Pose& gripper, const BasePose<>& base,
                 const InformationBlock& information, double* chosen) const {
    const double sigma_t = 1 / std::sqrt(information(0, 0));
    const double sigma_r = 1 / std::sqrt(information(2, 2));
    const ProjectedBase nearest =
        resource<0>().project(gripper, base, sigma_t, sigma_r, &resource<1>());
    const double cap = capOf(gripper);
    const Pose2 frame = nearest.at_obstacle ? Pose2() : headingFrame(gripper, cap).inverse();
    const Pose2 seen = frame * base;
    const Pose2 wanted = frame * nearest.base;
    // The unit normal n of the metric diag(sigma)^-2: a = n / sigma, b = n sigma.
    const double sigma[3] = {sigma_t, sigma_t, sigma_r};
    const double off[3] = {(seen.x - wanted.x) / sigma_t, (seen.y - wanted.y) / sigma_t,
                           wrapAngle(seen.theta - wanted.theta) / sigma_r};
    const double length = std::sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
    const bool away = !nearest.inside && length > 0;
    const bool was_away =
        chosen[kAcross] != 0 || chosen[kAcross + 1] != 0 || chosen[kAcross + 2] != 0;
    const bool changed = first || chosen[kCap] != cap || away != was_away;
    wanted.toArray(chosen + kWanted);
    for (int i = 0; i < 3; ++i) {
      const double normal = away ? off[i] / length : 0;
      chosen[kAcross + i] = normal / sigma[i];
      chosen[kAlong + i] = normal * sigma[i];
    }
    chosen[kCap] = cap;
    chosen[kWorld] = nearest.at_obstacle ? 1 : 0;
    chosen[kSlope] = nearest.by_height;
    chosen[kSlope + 1] = nearest.by_elevation;
    chosen[kSlope + 2] = nearest.by_roll;
    chosen[kFrom] = gripper.translation[2];
    chosen[kFrom + 1] = elevationOf(gripper);
    chosen[kFrom + 2] = rollOf(gripper);
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
  /// Elevation and roll of R = Rz(a) Ry(-elevation) Rx(roll), as in ReachGrid::view.
  template <class T>
  static T elevationOf(const SE3<T>& gripper) {
    using std::atan2;
    using std::sqrt;
    const Vec<T, 3> x = gripper.rotation * Vec<T, 3>(T(1), T(0), T(0));
    return atan2(x[2], T(sqrt(T(x[0] * x[0] + x[1] * x[1]))));
  }
  template <class T>
  static T rollOf(const SE3<T>& gripper) {
    using std::atan2;
    const Vec<T, 3> y = gripper.rotation * Vec<T, 3>(T(0), T(1), T(0));
    const Vec<T, 3> z = gripper.rotation * Vec<T, 3>(T(0), T(0), T(1));
    return atan2(y[2], z[2]);
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
