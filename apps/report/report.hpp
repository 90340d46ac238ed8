// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/staged_directory.hpp"
#include "types_lfd/learn/learn.hpp"
#include "types_lfd/learn/tune.hpp"

namespace graft::report {

/// Writes what a person looks at after learning: report.html and pictures/*.svg,
/// all self-contained (no script, no network), readable in light and dark and
/// on paper. Works with results that have no map, no snapshots, or no common
/// grasp; then the page says what is missing and why. `messages` are lines that
/// were printed on the way (Diagnostics::lines()); they are shown as they are.
/// Throws Error(kOutput) where a file cannot be written.
void writeReport(const lfd::LearnResult& result, StagedDirectory& out,
                 const std::vector<std::string>& messages = {});

/// Writes pictures/tune.svg.
void writeTuning(const std::vector<lfd::TuneTrial>& trials, StagedDirectory& out);

}  // namespace graft::report
