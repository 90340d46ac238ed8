// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/se2.hpp"
#include "core/geometry/se3.hpp"

namespace graft {

/// Where a simulated robot truly was, in order of time, and between which poses
/// it measured. Planar worlds have `plane`, others `space`.
struct SimulatedWorld {
  std::vector<Pose> space;
  std::vector<Pose2> plane;
  std::vector<std::pair<int, int>> edges;  ///< {i, i + 1} is odometry
  bool planar() const { return space.empty(); }
  std::size_t size() const { return planar() ? plane.size() : space.size(); }
};

/// Normal deviates that are the same with every standard library.
class NormalDeviates {
 public:
  explicit NormalDeviates(std::uint64_t seed) : random_(seed) {}
  double next();
  /// In [0, n).
  int below(int n) { return int(random_() % std::uint64_t(n)); }

 private:
  std::mt19937_64 random_;
  double spare_ = 0;
  bool has_spare_ = false;
};

/// `size` rings of `size` poses on a sphere; neighbours on the next ring meet.
SimulatedWorld sphereWorld(int size);
/// The same on a torus; the last ring meets the first.
SimulatedWorld torusWorld(int size);
/// size x size x size poses, walked row by row; neighbours in the grid meet.
SimulatedWorld gridWorld(int size);
/// `size` unit steps on a plane grid with random turns; meets poses of its past
/// that stand on the same or a neighbouring crossing.
SimulatedWorld manhattanWorld(int size, NormalDeviates& random);

}  // namespace graft
