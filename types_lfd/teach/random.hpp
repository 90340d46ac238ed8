// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace graft::lfd {

/// Random numbers that are the same for a seed with every compiler and
/// library: the engine's output is fixed by the standard, and the deviates are
/// computed here.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// A stream of its own for each (seed, stream, index), so that a change in
  /// what one part draws leaves all other parts as they were.
  Random(std::uint64_t seed, std::uint64_t stream, std::uint64_t index);

  /// In [low, high).
  double uniform(double low, double high);
  /// True with the given probability.
  bool chance(double probability) { return uniform(0, 1) < probability; }
  /// One of 0 .. count - 1.
  int below(int count) { return static_cast<int>(uniform(0, count)); }
  /// Standard normal. Source: Box and Muller, "A note on the generation of
  /// random normal deviates", 1958.
  double normal();
  /// Three independent normal deviates of standard deviation `sigma`.
  Eigen::Vector3d normal3(double sigma);

 private:
  std::mt19937_64 engine_;
  bool has_spare_ = false;
  double spare_ = 0;
};

}  // namespace graft::lfd
