// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/base/error.hpp"
#include "types_lfd/demo/demonstration.hpp"
#include "types_lfd/demo/task.hpp"

namespace graft::lfd {

/// Looks at raw tracks for what people get wrong when they record: stamps that
/// are not seconds, positions that are not metres, y up instead of z up, a floor
/// that is not at z = 0, tracks under each other's names, tracks that stand
/// still or hardly overlap, tracker accuracies that are not metres and radians.
/// Each finding says what was seen and what to change. What nothing can be
/// learned from is an error at the demonstration's line, what is odd a warning.
/// Quantiles are used throughout, so that outliers do not count.
void checkRecordings(const Task& task, const std::vector<Demonstration>& demonstrations,
                     Diagnostics& diagnostics);

}  // namespace graft::lfd
