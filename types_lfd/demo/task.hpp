// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/geometry/se3.hpp"

namespace graft::lfd {

/// Standard deviation of one pose of a tracker: per axis of translation (m) and
/// per axis of rotation (rad).
struct TrackerAccuracy {
  double sigma_t = 0;
  double sigma_r = 0;
};

/// The robot that will do the task. Paths are resolved against the task's folder.
struct RobotSpec {
  std::string urdf;
  std::string base_link;
  std::string tip_link;
  std::string srdf;                        ///< empty if none
  std::vector<Eigen::Vector2d> footprint;  ///< corners in base_link, m, simple polygon
  Pose tip_T_gripper;                      ///< attribute `tool`; identity if not given
};

/// One recorded demonstration; file paths are resolved against the task's folder.
struct DemonstrationSpec {
  std::string name;
  std::string hand;
  std::string object;
  std::string torso;  ///< empty if not recorded
  std::optional<double> grasp_time;
  std::optional<double> release_time;
  std::optional<Pose> hand_offset;  ///< marker_T_palm
  SourceLocation where;
};

/// <weights edge= sigma_t= sigma_r=/>: replaces the default weight of an edge.
struct WeightOverride {
  std::string edge;
  double sigma_t = 0;
  double sigma_r = 0;
  SourceLocation where;
};

/// A task folder: what a person recorded and what it is recorded for.
struct Task {
  std::string path;       ///< the file, as given
  std::string directory;  ///< its folder, without a slash at the end; "." if none is named
  std::string name;
  RobotSpec robot;
  std::string grasps;
  double min_quality = 0;                           ///< inclusive
  std::string map;                                  ///< empty if none
  std::map<std::string, TrackerAccuracy> trackers;  ///< by entity: "hand", "object", "torso"
  std::vector<DemonstrationSpec> demonstrations;
  std::vector<WeightOverride> weights;
};

/// Reads a task file. Any element or attribute that the format does not name is
/// an error with its line. One pass collects the first defect of every element
/// in `diagnostics`; the caller decides (`throwIfErrors`).
/// Throws Error(kInput) where the file is no XML or its root is no task.
Task readTask(const std::string& path, Diagnostics& diagnostics);

}  // namespace graft::lfd
