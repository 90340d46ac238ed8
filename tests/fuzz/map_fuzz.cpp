// SPDX-License-Identifier: BSD-3-Clause
// The yaml of a map. Its picture is another target's.
#include <cmath>

#include "tests/fuzz/fuzz.hpp"
#include "types_lfd/map/map_yaml.hpp"

namespace graft::fuzz {

void fuzzOne(std::string_view bytes) {
  lfd::MapYaml map;
  if (!accepts([&](Diagnostics& found) { map = lfd::parseMapYaml(bytes, "map.yaml", found); })) {
    return;
  }
  require(!map.image.empty(), "a map without a picture");
  require(map.resolution > 0 && std::isfinite(map.resolution), "a resolution out of range");
  require(
      std::isfinite(map.origin.x) && std::isfinite(map.origin.y) && std::isfinite(map.origin.theta),
      "an origin that is not finite");
  require(map.free_thresh <= map.occupied_thresh, "reversed thresholds");
}

}  // namespace graft::fuzz
