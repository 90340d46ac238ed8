// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/random.hpp"

#include <cmath>

namespace graft::lfd {

namespace {

/// Source: Steele, Lea, Flood, "Fast splittable pseudorandom number
/// generators", 2014 (SplitMix64).
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

}  // namespace

Random::Random(std::uint64_t seed, std::uint64_t stream, std::uint64_t index)
    : engine_(mixed(mixed(mixed(seed) ^ stream) ^ index)) {}

double Random::uniform(double low, double high) {
  constexpr double kStep = 1.0 / 9007199254740992.0;  // 2^-53
  return low + (high - low) * (static_cast<double>(engine_() >> 11) * kStep);
}

double Random::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  constexpr double kTwoPi = 6.28318530717958647692;
  const double radius = std::sqrt(-2 * std::log(1 - uniform(0, 1)));
  const double angle = kTwoPi * uniform(0, 1);
  has_spare_ = true;
  spare_ = radius * std::sin(angle);
  return radius * std::cos(angle);
}

Eigen::Vector3d Random::normal3(double sigma) {
  const double x = normal();
  const double y = normal();
  const double z = normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

}  // namespace graft::lfd
