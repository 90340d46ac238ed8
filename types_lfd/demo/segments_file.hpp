// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "types_lfd/demo/match.hpp"
#include "types_lfd/demo/segment.hpp"

namespace graft::lfd {

/// Text of segments.csv: header `demo,grasp_time,release_time`, one line per
/// demonstration, stamps of tuples as read (shortest round-trip numbers). The
/// two lists belong together entry by entry.
std::string formatSegments(const std::vector<MatchedDemonstration>& matched,
                           const std::vector<Segmentation>& segments);

}  // namespace graft::lfd
