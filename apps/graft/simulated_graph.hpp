// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace graft {

/// What `graft simulate` makes.
struct SimulationOptions {
  std::string kind;  ///< sphere, torus, grid or manhattan
  int size = 50;     ///< poses along one ring, side or (manhattan) 100 steps
  std::uint64_t seed = 1;
  double sigma_t = 0.05;  ///< noise of measurements per axis, m
  double sigma_r = 0.02;  ///< and rad
  bool truth = false;     ///< vertices at the truth instead of dead reckoning
};

/// A pose graph as g2o text: true poses on the named shape, measurements
/// between consecutive poses and to neighbours on the rings around (loop
/// closures), with Gaussian noise and matching information. The same options
/// give the same bytes on every machine.
///  - sphere, torus: size rings of size poses in space;
///  - grid: size x size x size/5 poses in space, neighbours along three axes;
///  - manhattan: 100 size steps of 1 m on a planar grid with random turns, closures
///    where the walk comes back to a place.
std::string simulateGraph(const SimulationOptions& options);

}  // namespace graft
