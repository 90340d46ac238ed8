// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace graft::lfd {

/// Why the corners (m, in order, either sense) are no simple polygon with an
/// area; empty if they are one.
std::string footprintDefect(const std::vector<Eigen::Vector2d>& corners);

}  // namespace graft::lfd
