// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <utility>

#include "core/base/error.hpp"
#include "types_lfd/robot/urdf.hpp"

namespace graft::lfd {

/// What a robot's semantic description says of collisions: pairs of links
/// (each pair in alphabetical order) that need no test.
struct Srdf {
  std::set<std::pair<std::string, std::string>> disabled;

  bool isDisabled(const std::string& a, const std::string& b) const {
    return disabled.count(a < b ? std::make_pair(a, b) : std::make_pair(b, a)) > 0;
  }
};

/// Reads an SRDF (http://wiki.ros.org/srdf): its <disable_collisions>; groups,
/// states and end effectors are left to planners. Throws Error(kInput) where the
/// file is no XML or no <robot>, is of a robot of another name, or an element has
/// no link1 or link2; links that the URDF lacks are a warning with the line.
Srdf readSrdf(const std::string& path, const UrdfModel& model, Diagnostics& diagnostics);

/// The same for a text in memory; `path` is for messages.
Srdf readSrdfText(const std::string& path, const std::string& content, const UrdfModel& model,
                  Diagnostics& diagnostics);

}  // namespace graft::lfd
