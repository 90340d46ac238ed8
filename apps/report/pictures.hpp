// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "apps/report/svg.hpp"
#include "types_lfd/learn/learn.hpp"
#include "types_lfd/learn/tune.hpp"

namespace graft::report {

/// A finished picture: pictures/<name>.svg, and the same in the page with its
/// caption (plain text) that says what to see.
struct Picture {
  std::string name;
  std::string title;
  std::string caption;
  Svg svg;
};

/// Structure of the hypergraph (paper, Fig. 2) with the counts of the real one.
Picture graphPicture(const lfd::LearnResult& result);

/// Bases, gripper paths and map after some iterations (paper, Fig. 4), all with
/// the same section of the world; before and after where there are no snapshots.
std::vector<Picture> mapPictures(const lfd::LearnResult& result);

/// Hand and gripper seen from the object, and the grasps (paper, Fig. 3).
Picture graspPicture(const lfd::LearnResult& result);

/// Where each demonstration holds the object, for tasks with several ways of it.
Picture holdsPicture(const lfd::LearnResult& result);

/// Reaching, manipulation, retreat, and which stamps were measured.
Picture segmentsPicture(const lfd::LearnResult& result);

/// chi2 over iterations, and what remains of it by type of edge.
Picture convergencePicture(const Summary& summary);

/// Table I as bars.
Picture tablePicture(const lfd::LearnResult& result);

/// Positions over time in the first demonstration, measured and optimized.
Picture tracksPicture(const lfd::LearnResult& result);

/// What other weights would give (graft-lfd learn --tune).
Picture tunePicture(const std::vector<lfd::TuneTrial>& trials);

/// What people call an edge type of the learner: "LFD_HAND_GRIPPER" gives
/// "E7 hand to gripper"; other tags stay as they are.
std::string edgeName(const std::string& tag);

}  // namespace graft::report
