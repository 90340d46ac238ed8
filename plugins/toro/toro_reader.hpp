// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "core/types/abi.h"

namespace graft::toro {

/// Whether the beginning of a file is TORO's: the first tag is VERTEX2 or EDGE2, or,
/// in a file whose name ends in .graph, VERTEX3 or EDGE3 (which g2o has, too).
bool looksLikeToro(std::string_view path, std::string_view head);

/// Reads TORO's text into a sink:
///   VERTEX2 id x y theta
///   EDGE2   a b x y theta  I11 I12 I22 I33 I13 I23
///   VERTEX3 id x y z roll pitch yaw
///   EDGE3   a b x y z roll pitch yaw  upper triangle of I, row by row (21)
/// as VERTEX_SE2, EDGE_SE2, VERTEX_SE3:QUAT and EDGE_SE3:QUAT. The information of
/// Euler angles becomes that of g2o's chart as g2o does it for EDGE3 (see
/// eulerByQuaternionVector). Every defect is reported with line and column; false
/// if there was one.
bool readToro(std::string_view text, const graft_graph_sink& sink);

}  // namespace graft::toro
