// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/error.hpp"
#include "core/geometry/se2.hpp"

namespace graft::lfd {

/// What a map_server yaml file says.
struct MapYaml {
  std::string image;            ///< as written
  std::int64_t image_line = 0;  ///< where, for messages
  double resolution = 0;        ///< m per cell
  Pose2 origin;                 ///< pose of the lower left corner of the lower left cell
  bool negate = false;          ///< white is occupied
  double occupied_thresh = 0.65;
  double free_thresh = 0.196;
};

/// Parses the flat subset of YAML that map_server writes: `key: value` lines,
/// comments, quoted strings, and `[x, y, yaw]` or three `- number` lines for
/// the origin. Unknown, repeated and missing keys, numbers out of range,
/// reversed thresholds and modes other than trinary are errors with their line.
MapYaml parseMapYaml(std::string_view content, const std::string& path, Diagnostics& diagnostics);

}  // namespace graft::lfd
