// SPDX-License-Identifier: BSD-3-Clause
// grasps.csv: every grasp that is kept can be chosen.
#include "tests/fuzz/fuzz.hpp"
#include "types_lfd/grasp/grasp_set.hpp"

namespace graft::fuzz {

void fuzzOne(std::string_view bytes) {
  const File file(bytes);
  lfd::GraspSet set;
  const bool taken =
      accepts([&](Diagnostics& found) { set = lfd::GraspSet::read(file.path(), 0.5, found); });
  if (!taken) return;
  require(!set.valid().empty(), "a set without grasps");
  for (const lfd::Grasp& grasp : set.valid()) {
    require(grasp.quality >= 0.5 && grasp.quality <= 1, "a quality out of range");
    const lfd::GraspSet::Choice choice = set.nearest(grasp.object_T_gripper, 0.01, 0.1);
    require(choice.index >= 0, "no grasp is nearest");
    require(choice.cost < 1e-12, "a grasp is not the nearest to itself");
  }
}

}  // namespace graft::fuzz
