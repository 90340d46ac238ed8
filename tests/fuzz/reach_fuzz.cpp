// SPDX-License-Identifier: BSD-3-Clause
// Maps of reachability. The envelope's size and checksum are made right, or no changed
// byte would get past them; the bytes as they are go in as well.
#include <cmath>
#include <cstring>

#include "tests/fuzz/fuzz.hpp"
#include "types_lfd/reach/capability_map.hpp"
#include "types_lfd/reach/reach_map.hpp"

namespace graft::fuzz {

namespace {

constexpr std::size_t kEnvelope = 32;

/// The format's checksum (see reach_file.cpp), over all that follows the envelope.
std::uint64_t checksum(std::string_view body) {
  std::uint64_t h = 0xcbf29ce484222325ULL;
  std::size_t i = 0;
  for (; i + 8 <= body.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, body.data() + i, 8);
    h = (h ^ word) * 0x100000001b3ULL;
    h ^= h >> 29;
  }
  for (; i < body.size(); ++i) h = (h ^ static_cast<unsigned char>(body[i])) * 0x100000001b3ULL;
  return h ^ body.size();
}

std::string enveloped(std::string_view bytes) {
  const std::uint32_t words[2] = {0x01020304, 2};
  std::string file = "GRAFTIRM" + std::string(kEnvelope - 8, '\0');
  file += bytes.substr(std::min(bytes.size(), kEnvelope));
  const std::uint64_t size = file.size();
  const std::uint64_t sum = checksum(std::string_view(file).substr(kEnvelope));
  std::memcpy(file.data() + 8, words, 8);
  std::memcpy(file.data() + 16, &size, 8);
  std::memcpy(file.data() + 24, &sum, 8);
  return file;
}

void load(std::string_view bytes) {
  const File file(bytes);
  accepts([&](Diagnostics&) {
    const lfd::ReachMap map = lfd::ReachMap::load(file.path());
    for (const double height : {0.0, 0.7, -1e9}) {
      Pose gripper;
      gripper.translation = {0.3, -0.2, height};
      const Pose2 base;
      require(!std::isnan(map.distance(gripper, base)), "not a distance");
      map.quality(gripper, base);
      const lfd::NearestBase nearest = map.nearest(gripper, base, 0.1, 0.1);
      require(!nearest.found || std::isfinite(nearest.cost), "not a cost");
    }
  });
}

}  // namespace

void fuzzOne(std::string_view bytes) {
  load(bytes);
  load(enveloped(bytes));
  const File file(bytes);
  accepts([&](Diagnostics&) {
    const lfd::CapabilityMap map = lfd::CapabilityMap::load(file.path());
    for (const lfd::Capability& cube : map.capabilities()) {
      require(map.find(cube.center) != nullptr, "a cube that is not found at its centre");
      require(cube.share() >= 0 && cube.share() <= 1, "a share out of range");
    }
  });
}

}  // namespace graft::fuzz
