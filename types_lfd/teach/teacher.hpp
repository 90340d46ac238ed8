// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "types_lfd/teach/scenario.hpp"

namespace graft::lfd {

/// The simulated teacher: writes a complete task folder into `directory`
/// (task.xml, robot.urdf, grasps.csv, map.yaml, map.pgm, demo_XX/*.tum) and
/// beside it `truth/`: the noise-free tracks `demo_XX_{hand,object,torso}.tum`
/// at every camera frame, and segments.csv. The same arguments give the same
/// bytes; another seed gives other geometry, motions and noise. Entries of an
/// earlier run (demo_*) are replaced. Throws Error(kUsage) for an unknown task
/// or bad options, Error(kOutput) where the folder cannot be written.
void teach(const std::string& task_name, const std::string& directory, std::uint64_t seed,
           const TeachOptions& options = {});

/// Name of the `index`-th demonstration, from 0: demo_01, demo_02, ...
std::string demonstrationName(int index);

}  // namespace graft::lfd
