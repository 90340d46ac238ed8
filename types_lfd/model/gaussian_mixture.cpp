// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/model/gaussian_mixture.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/error.hpp"

namespace graft::lfd {

namespace {

constexpr double kLogTwoPi = 1.8378770664093454836;

}  // namespace

Eigen::VectorXd logSumExp(const Eigen::MatrixXd& columns) {
  Eigen::VectorXd result(columns.cols());
  for (Eigen::Index n = 0; n < columns.cols(); ++n) {
    const double top = columns.col(n).maxCoeff();
    double sum = 0;
    for (Eigen::Index k = 0; k < columns.rows(); ++k) sum += std::exp(columns(k, n) - top);
    result[n] = std::isfinite(top) ? top + std::log(sum) : top;
  }
  return result;
}

Eigen::MatrixXd GaussianMixture::logJoint(const Eigen::MatrixXd& samples) const {
  const Eigen::Index count = samples.cols();
  Eigen::MatrixXd joint(static_cast<Eigen::Index>(components.size()), count);
  for (Eigen::Index k = 0; k < joint.rows(); ++k) {
    const GaussianComponent& c = components[static_cast<std::size_t>(k)];
    if (c.weight <= 0) {
      joint.row(k).setConstant(-std::numeric_limits<double>::infinity());
      continue;
    }
    const Eigen::LLT<Eigen::MatrixXd> cholesky(c.covariance);
    if (cholesky.info() != Eigen::Success) {
      throw Error(ExitCode::kNoResult, "covariance of mixture component " + std::to_string(k + 1) +
                                           " is not positive definite");
    }
    const Eigen::MatrixXd whitened = cholesky.matrixL().solve(samples.colwise() - c.mean);
    const double half_log_determinant =
        cholesky.matrixLLT().diagonal().array().log().sum();  // log of the diagonal of L
    const double constant = std::log(c.weight) - half_log_determinant -
                            0.5 * kLogTwoPi * static_cast<double>(samples.rows());
    joint.row(k) = (constant - 0.5 * whitened.colwise().squaredNorm().array()).matrix();
  }
  return joint;
}

double GaussianMixture::logLikelihood(const Eigen::MatrixXd& samples) const {
  return logSumExp(logJoint(samples)).sum();
}

TimeRegression GaussianMixture::atTime(double t) const {
  const auto count = static_cast<Eigen::Index>(components.size());
  const Eigen::Index dim = dimension() - 1;
  if (count == 0 || dim < 1) {
    throw Error(ExitCode::kInternal, "regression on a mixture without components or outputs");
  }
  TimeRegression result;
  Eigen::MatrixXd log_weight(count, 1);
  for (Eigen::Index k = 0; k < count; ++k) {
    const GaussianComponent& c = components[static_cast<std::size_t>(k)];
    const double variance = c.covariance(0, 0);
    const double offset = t - c.mean[0];
    log_weight(k, 0) = std::log(c.weight) - 0.5 * (std::log(variance) + offset * offset / variance);
  }
  const double total = logSumExp(log_weight)[0];
  result.activation = (log_weight.col(0).array() - total).exp().matrix();

  Eigen::MatrixXd means(dim, count);
  result.covariance = Eigen::MatrixXd::Zero(dim, dim);
  for (Eigen::Index k = 0; k < count; ++k) {
    const GaussianComponent& c = components[static_cast<std::size_t>(k)];
    const Eigen::VectorXd slope = c.covariance.col(0).tail(dim) / c.covariance(0, 0);
    means.col(k) = c.mean.tail(dim) + slope * (t - c.mean[0]);
    result.covariance += result.activation[k] * (c.covariance.bottomRightCorner(dim, dim) -
                                                 slope * c.covariance.col(0).tail(dim).transpose());
  }
  result.mean = means * result.activation;
  // The spread between components around the common mean: the same as
  // sum h m m' - m m', without its cancellation.
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::VectorXd d = means.col(k) - result.mean;
    result.covariance += result.activation[k] * (d * d.transpose());
  }
  result.covariance = 0.5 * (result.covariance + result.covariance.transpose()).eval();
  return result;
}

}  // namespace graft::lfd
