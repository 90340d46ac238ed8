// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/io/graph_loader.hpp"

namespace graft::testing {

/// Loads a text as a file of that name would be. Messages go to `diagnostics`.
LoadedGraph loadText(const std::string& text, Registry& registry, Diagnostics& diagnostics,
                     const LoadOptions& options = {}, const std::string& name = "g.g2o");

/// Loads a file of the shared evaluation data; messages are dropped.
LoadedGraph loadData(const std::string& relative, Registry& registry);

/// The text of a cube of side^3 poses in space, each joined to its neighbours: little data, a
/// large factor.
std::string cubeOfPoses(int side);

}  // namespace graft::testing
