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
/// gripper's azimuth. The error measures the distance to the reachable *set*, a
/// union of boxes in these coordinates: a pair that is reachable already is left
/// alone (dead zone), and a coordinate in which the base lies within the bounds
/// of the nearest box is free to move (point to plane rather than point to point,
/// which would creep along the boundary). Association: which of the three
/// coordinates are off (3), where they should be (3), and 1 or -1 if the gripper
/// points up or down so far that its heading includes its roll.
struct ReachabilityEdge : Edge<ReachabilityEdge, 3, SE3, BasePose>,
                          Associated<7>,
                          Using<ReachMap, FreeSpace> {
  static constexpr auto tag = "LFD_REACHABILITY";
  static constexpr auto doc = "E9: base where the arm reaches and the map is free (paper eq. 9)";

  template <class T>
  Vec<T, 3> error(const SE3<T>& gripper, const BasePose<T>& base) const {
    Vec<T, 3> e(T(0), T(0), T(0));
    if (association[0] == 0 && association[1] == 0 && association[2] == 0) return e;
    const SE2<T> seen = headingFrame(gripper, association[6]).inverse() * base;
    if (association[0] != 0) e[0] = seen.x - association[3];
    if (association[1] != 0) e[1] = seen.y - association[4];
    if (association[2] != 0) e[2] = wrapAngle(T(seen.theta - association[5]));
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
    // A coordinate that the projection left alone comes back within rounding.
    constexpr double kSame = 1e-9;
    const double off[3] = {seen.x - wanted.x, seen.y - wanted.y,
                           wrapAngle(seen.theta - wanted.theta)};
    bool changed = first || chosen[6] != cap;
    for (int i = 0; i < 3; ++i) {
      const double active = !nearest.inside && std::abs(off[i]) > kSame ? 1 : 0;
      changed = changed || active != chosen[i];
      chosen[i] = active;
    }
    wanted.toArray(chosen + 3);
    chosen[6] = cap;
    return changed;
  }

 private:
  /// 1 or -1 where the reachability map folds the gripper's roll into its
  /// heading because it points up or down, else 0.
  double capOf(const Pose& gripper) const {
    const ReachGrid& grid = resource<0>().grid();
    const int ring = grid.ring((gripper.rotation * Vec<double, 3>(1, 0, 0))[2]);
    return ring >= grid.turn / 4 ? 1 : ring <= -grid.turn / 4 ? -1 : 0;
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
