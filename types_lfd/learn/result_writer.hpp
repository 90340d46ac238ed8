// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/staged_directory.hpp"
#include "types_lfd/learn/learn.hpp"

namespace graft::lfd {

/// Top-level entries that `learn` owns in its output folder.
std::vector<std::string> learnOutputs();

/// Writes a result into a staged folder (formats of `learn`): trajectories,
/// joints, segments, grasp, graphs, model, metrics, snapshots. Where there is no
/// common grasp: metrics.json and segments.csv only. `messages` (what was said on
/// the way) go to metrics.json. Does not commit.
void writeResult(const LearnResult& result, StagedDirectory& out,
                 const std::vector<std::string>& messages = {});

/// Text of joints.csv: time, then one column per joint; empty fields where no
/// arm configuration was found.
std::string formatJoints(const std::vector<std::string>& names, const std::vector<double>& times,
                         const IkTrack& track);

}  // namespace graft::lfd
