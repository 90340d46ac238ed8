// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/solve/robust_edges.hpp"
#include "core/solve/weighted_rounds.hpp"

namespace graft {

/// How far the errors of edges lie from what the edges in use predict, in the measure of
/// the prediction's own covariance, to first order.
///
/// With whitened error r and Jacobian J of an edge, and the Hessian H of the edges in use:
/// one that is not in use has r normal with covariance S = I + J H^-1 J', and chi2 rises by
/// r' S^-1 r (chi-square if it is true) when it comes into use. When one that is in use is
/// taken out, chi2 falls by r' (I - J H^-1 J')^-1 r.
class Innovations {
 public:
  using Place = RobustEdges::Place;

  /// `problem` gets its weights back after a use of them.
  Innovations(Problem& problem, ThreadPool& pool);

  /// Linearises at a state and factors H of the edges of weight above 0, which all have
  /// weight 1. False where H is singular or something cannot be evaluated.
  bool begin(const GraduationTools& tools, const State& state);

  /// An edge that is not in use as seen by the others.
  struct View {
    double square = 0;  ///< r' S^-1 r
    double spread = 0;  ///< log det S per row of r: how little is predicted
  };
  /// From a sample of estimates with covariance H^-1 (solutions for noise in every
  /// measurement), so that many edges cost as much as one: S to some ten per cent.
  std::vector<View> sample(const std::vector<Place>& places);

  /// An edge that is in use as seen by the others.
  struct Removal {
    double fall = 0;     ///< of chi2 without it; 0 in directions that no other edge checks
    double checked = 0;  ///< least eigenvalue of I - J H^-1 J': 0 = not at all, 1 = fully
  };
  /// Exactly (to first order), for about what three factorisations cost. Throws
  /// Error(kNoResult) where memory does not suffice.
  std::vector<Removal> removals(const std::vector<Place>& places);

 private:
  std::vector<double> noise(std::uint64_t seed) const;
  void predict(Place place, const double* x, double* error) const;
  /// Calls visit(slot, free block) for the slots of an edge that are free.
  template <class Visit>
  void forEachFree(Place place, const Visit& visit) const;
  Eigen::Map<const Eigen::VectorXd> residual(Place place) const;
  /// J of an edge: error_dim x the dimension of a slot.
  Eigen::MatrixXd jacobian(Place place, std::size_t slot) const;

  Problem* problem_;
  Linearizer linearizer_;
  const GraduationTools* tools_ = nullptr;
  State state_;
};

}  // namespace graft
