// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "types_lfd/model/gaussian_mixture.hpp"

namespace graft::lfd {

/// How a mixture is fitted. Everything is deterministic: the initialisation cuts
/// the samples, ordered by their first coordinate, into equal parts.
struct EmOptions {
  int components = 0;  ///< fixed number, or 0: the lowest BIC of the range below
  int minimum_components = 1;
  int maximum_components = 15;
  int iterations = 500;
  double tolerance = 1e-7;  ///< stop at this gain of mean log-likelihood per sample
  /// No covariance has an eigenvalue below this, in units in which every
  /// dimension of the data has variance one.
  double variance_floor = 1e-6;
  /// A dimension that varies less than this (m, rad, share of the duration) is
  /// scaled by it instead of by its deviation, so that a constant one is allowed.
  double minimum_scale = 1e-3;
};

/// One point of the model selection curve, in the units of the data.
struct ComponentScore {
  int components = 0;
  double log_likelihood = 0;
  double bic = 0;  ///< -2 log L + p log N, p = K-1 + K (D + D (D+1)/2); lower is better
  double aic = 0;  ///< -2 log L + 2 p
  int iterations = 0;
  bool converged = false;
};

struct EmResult {
  GaussianMixture mixture;  ///< ordered by the mean of the first dimension
  ComponentScore score;
  std::vector<double> history;        ///< log-likelihood before each M-step and at the end
  int floored = 0;                    ///< eigenvalues that the floor lifted, at the end
  std::vector<std::string> notes;     ///< what was guessed or reduced; empty if nothing
  std::vector<ComponentScore> curve;  ///< every number of components tried
};

/// Samples of one group share their component: the columns g, g + G, g + 2G, ...
/// of N = n G belong to group g. With G = N every sample is its own group, the
/// usual mixture. For demonstrations resampled at the same G times, one after the
/// other, the components become phases of the motion that all demonstrations pass
/// through, instead of one demonstration's curve each; the likelihood is
/// prod_g sum_k weight_k prod_{n in g} N(sample_n | k).
struct SampleGroups {
  Eigen::Index count = 0;  ///< G; 0 = every sample on its own
};

/// Maximum likelihood mixture of `components` Gaussians for samples in columns
/// (D x N), first row = time. The floor is a constraint on the covariances, and
/// the M-step its exact maximiser (eigenvalues clamped), so the log-likelihood
/// never falls. More components than samples are reduced, with a note. Throws
/// Error(kUsage) for fewer than one component or options out of range,
/// Error(kInput) for no samples or numbers that are not finite.
/// Source: Dempster, Laird, Rubin 1977; Bishop, "Pattern Recognition and Machine
/// Learning", 9.2.
EmResult fitMixture(const Eigen::MatrixXd& samples, int components, const EmOptions& options,
                    SampleGroups groups = SampleGroups());

/// The same with the number of components that `options` asks for: fixed, or the
/// lowest BIC (the smaller number on ties), with the whole curve. In the search
/// a component has at least D+1 samples on average; the range is cut, with a note.
EmResult selectMixture(const Eigen::MatrixXd& samples, const EmOptions& options,
                       SampleGroups groups = SampleGroups());

}  // namespace graft::lfd
