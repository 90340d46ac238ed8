// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/conformance/checks.hpp"

namespace graft::conformance {

/// Seeded numbers, the same with every standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high);
  /// Roughly normal (sum of uniforms), zero mean and unit deviation.
  double normal();

 private:
  std::mt19937_64 engine_;
};

/// A valid estimate: the identity moved by a random tangent; the scale of the
/// step changes from `index` to `index`.
std::vector<double> randomEstimate(const graft_vertex_type& type, Random& random, int index);

/// Numbers that `normalize` accepts, normalised; empty where none of some
/// hundred trials was accepted (`why` then holds the last reason).
std::vector<double> randomMeasurement(const graft_edge_type& type, int dim, Random& random,
                                      std::string& why);

/// A random symmetric positive definite matrix, upper triangle row by row.
std::vector<double> randomInformation(int dim, Random& random);

/// Words separated by blanks.
std::vector<std::string> wordsOf(const char* text);

/// A resource of a type: from the example if it has one, else loaded from
/// generated numbers, one per field. Throws Skip where neither works.
struct ResourceSample {
  std::vector<std::string> tokens;
  std::shared_ptr<const void> data;
};
ResourceSample sampleResource(const Context& context, const graft_resource_type& type);

/// Folder that the example's file names refer to.
std::string exampleDirectory(const Context& context);

}  // namespace graft::conformance
