// SPDX-License-Identifier: BSD-3-Clause
// SRDF of a robot of three links.
#include "tests/fuzz/fuzz.hpp"
#include "types_lfd/robot/srdf.hpp"

namespace graft::fuzz {

void fuzzOne(std::string_view bytes) {
  static const lfd::UrdfModel model = [] {
    lfd::UrdfModel robot;
    robot.name = "r";
    for (const char* name : {"a", "b", "c"}) {
      robot.links.emplace_back();
      robot.links.back().name = name;
    }
    return robot;
  }();
  lfd::Srdf srdf;
  const bool taken = accepts([&](Diagnostics& found) {
    srdf = lfd::readSrdfText("robot.srdf", std::string(bytes), model, found);
  });
  if (!taken) return;
  for (const auto& [first, second] : srdf.disabled) {
    require(first <= second, "a pair out of order");
    require(srdf.isDisabled(second, first), "a pair that is not found again");
  }
}

}  // namespace graft::fuzz
