// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "types_lfd/eval/metrics.hpp"
#include "types_lfd/learn/scene_file.hpp"
#include "types_lfd/model/motion_model.hpp"

namespace graft::lfd {

/// What `learn` wrote, read back from its folder.
struct LearnedFolder {
  Task task;  ///< without demonstrations
  std::vector<DemonstrationEstimate> demonstrations;
};

/// Reads segments.csv and the tracks below `estimates`: "optimized", or
/// "iterations/5". Throws Error(kInput) as below.
std::vector<DemonstrationEstimate> readEstimates(const std::string& directory,
                                                 const std::string& estimates);

/// Reads segments.csv and optimized/. Throws Error(kInput) naming the file and
/// line that is missing or not as `learn` writes it.
LearnedFolder readLearnedFolder(const std::string& directory);

/// One mixture per segment (reach, manipulate, retreat) over all demonstrations
/// (paper, section V); a segment without samples is left out with a warning.
MotionModel fitMotionModel(const std::string& task_name,
                           const std::vector<DemonstrationEstimate>& demonstrations,
                           Diagnostics& diagnostics);

}  // namespace graft::lfd
