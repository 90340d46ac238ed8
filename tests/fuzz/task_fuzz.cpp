// SPDX-License-Identifier: BSD-3-Clause
// Task files. Files that they name are not opened.
#include <cmath>

#include "tests/fuzz/fuzz.hpp"
#include "types_lfd/demo/task.hpp"

namespace graft::fuzz {

void fuzzOne(std::string_view bytes) {
  const File file(bytes);
  lfd::Task task;
  if (!accepts([&](Diagnostics& found) { task = lfd::readTask(file.path(), found); })) return;
  require(!task.demonstrations.empty(), "a task without demonstrations");
  require(task.robot.footprint.size() >= 3, "a footprint of less than three corners");
  for (const auto& [entity, accuracy] : task.trackers) {
    require(accuracy.sigma_t > 0 && accuracy.sigma_r > 0, "tracker " + entity + " without noise");
  }
  for (const lfd::WeightOverride& weight : task.weights) {
    require(weight.sigma_t >= 0 && weight.sigma_r >= 0, "a negative deviation");
  }
}

}  // namespace graft::fuzz
