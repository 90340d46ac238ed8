// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace graft::lfd {

/// One weighted Gaussian on R^D.
struct GaussianComponent {
  double weight = 0;
  Eigen::VectorXd mean;        ///< D
  Eigen::MatrixXd covariance;  ///< D x D, symmetric, positive semidefinite
};

/// What a mixture over [t; x] says about x at one time.
struct TimeRegression {
  Eigen::VectorXd mean;        ///< D-1
  Eigen::MatrixXd covariance;  ///< (D-1) x (D-1), moment matched
  Eigen::VectorXd activation;  ///< K, sums to one: how far each component speaks
};

/// p(xi) = sum_k weight_k N(xi | mean_k, covariance_k), xi = [t; x].
struct GaussianMixture {
  std::vector<GaussianComponent> components;

  Eigen::Index dimension() const { return components.empty() ? 0 : components[0].mean.size(); }

  /// K x N: log(weight_k N(sample_n | k)); samples are columns (D x N). Throws
  /// Error(kNoResult) where a covariance is not positive definite.
  Eigen::MatrixXd logJoint(const Eigen::MatrixXd& samples) const;

  /// sum_n log p(sample_n); samples are columns (D x N).
  double logLikelihood(const Eigen::MatrixXd& samples) const;

  /// Gaussian mixture regression on the first dimension. Only the variances of
  /// t are inverted, so covariances may be singular in x. The covariance is that
  /// of the conditional mixture, spread between components included:
  ///   sum_k h_k (S_k + m_k m_k') - m m'.
  /// Source: Cohn, Ghahramani, Jordan, "Active learning with statistical
  /// models", JAIR 4, 1996, section 4; h_k computed in log space, so that a time
  /// far from the data follows the nearest component instead of dividing 0 by 0.
  TimeRegression atTime(double t) const;
};

/// log(sum_k exp(column_k)) of every column (K x N to N), without overflow.
Eigen::VectorXd logSumExp(const Eigen::MatrixXd& columns);

}  // namespace graft::lfd
