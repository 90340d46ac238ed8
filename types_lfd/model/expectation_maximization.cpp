// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/model/expectation_maximization.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.hpp"

namespace graft::lfd {

namespace {

void validate(const Eigen::MatrixXd& samples, const EmOptions& options) {
  if (!(options.variance_floor > 0) || !(options.minimum_scale > 0) || !(options.tolerance > 0) ||
      options.iterations < 1) {
    throw Error(ExitCode::kUsage,
                "mixture options: floor, scale, tolerance and iterations must be positive");
  }
  if (samples.rows() < 1 || samples.cols() < 1) {
    throw Error(ExitCode::kInput, "no samples to fit a mixture to");
  }
  if (!samples.allFinite()) {
    throw Error(ExitCode::kInput, "samples of a mixture must be finite");
  }
}

/// z = (x - center) / scale gives every dimension variance one.
struct Scaling {
  Eigen::VectorXd center;
  Eigen::VectorXd scale;

  Scaling(const Eigen::MatrixXd& samples, double minimum_scale) {
    center = samples.rowwise().mean();
    const Eigen::MatrixXd centered = samples.colwise() - center;
    scale = (centered.rowwise().squaredNorm() / static_cast<double>(samples.cols()))
                .cwiseSqrt()
                .cwiseMax(minimum_scale);
  }
  Eigen::MatrixXd apply(const Eigen::MatrixXd& samples) const {
    return scale.cwiseInverse().asDiagonal() * (samples.colwise() - center);
  }
  void undo(GaussianMixture& mixture) const {
    for (GaussianComponent& c : mixture.components) {
      c.mean = center + scale.cwiseProduct(c.mean);
      c.covariance = scale.asDiagonal() * c.covariance * scale.asDiagonal();
      c.covariance = 0.5 * (c.covariance + c.covariance.transpose()).eval();
    }
  }
};

/// argmax over Sigma >= floor I of -log|Sigma| - tr(Sigma^-1 S): the eigenvalues
/// of S, those below the floor lifted to it. Returns how many were.
int liftToFloor(Eigen::MatrixXd& covariance, double floor) {
  covariance = 0.5 * (covariance + covariance.transpose()).eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  if (eigen.info() != Eigen::Success) {
    throw Error(ExitCode::kNoResult, "no eigenvalues for a covariance of a mixture");
  }
  int lifted = 0;
  for (const double value : eigen.eigenvalues()) lifted += value < floor ? 1 : 0;
  if (lifted > 0) {
    covariance = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(floor).asDiagonal() *
                 eigen.eigenvectors().transpose();
    covariance = 0.5 * (covariance + covariance.transpose()).eval();
  }
  return lifted;
}

/// M-step for soft assignments (K x N, columns sum to one). A component that
/// nothing is assigned to keeps its shape. Returns the eigenvalues lifted.
int maximize(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& assignment, double floor,
             GaussianMixture& mixture) {
  const auto count = static_cast<double>(samples.cols());
  int lifted = 0;
  for (Eigen::Index k = 0; k < assignment.rows(); ++k) {
    GaussianComponent& c = mixture.components[static_cast<std::size_t>(k)];
    const double mass = assignment.row(k).sum();
    c.weight = mass / count;
    if (mass < 1e-10) continue;
    c.mean = samples * assignment.row(k).transpose() / mass;
    const Eigen::MatrixXd centered = samples.colwise() - c.mean;
    c.covariance = centered * assignment.row(k).asDiagonal() * centered.transpose() / mass;
    lifted += liftToFloor(c.covariance, floor);
  }
  return lifted;
}

/// Hard assignment to equal parts of the samples in order of time.
Eigen::MatrixXd timeBins(const Eigen::MatrixXd& samples, int components) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(samples.cols()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return samples(0, a) < samples(0, b); });
  Eigen::MatrixXd assignment = Eigen::MatrixXd::Zero(components, samples.cols());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t bin = i * static_cast<std::size_t>(components) / order.size();
    assignment(static_cast<Eigen::Index>(bin), order[i]) = 1;
  }
  return assignment;
}

/// K x G: log(weight_k prod_{n in g} N(sample_n | k)).
Eigen::MatrixXd groupJoint(const GaussianMixture& mixture, const Eigen::MatrixXd& samples,
                           Eigen::Index groups) {
  const Eigen::MatrixXd joint = mixture.logJoint(samples);
  Eigen::MatrixXd result = joint.leftCols(groups);
  for (Eigen::Index first = groups; first < joint.cols(); first += groups) {
    result += joint.middleCols(first, groups);
  }
  // The weight counts once for a group.
  const Eigen::Index copies = joint.cols() / groups;
  const auto repeated = static_cast<double>(copies - 1);
  for (Eigen::Index k = 0; repeated > 0 && k < result.rows(); ++k) {
    const double weight = mixture.components[static_cast<std::size_t>(k)].weight;
    if (weight > 0) result.row(k).array() -= repeated * std::log(weight);
  }
  return result;
}

void finishScore(ComponentScore& score, Eigen::Index dimension, Eigen::Index samples) {
  const auto d = static_cast<double>(dimension);
  const auto k = static_cast<double>(score.components);
  const double parameters = (k - 1) + k * (d + d * (d + 1) / 2);
  score.bic = -2 * score.log_likelihood + parameters * std::log(static_cast<double>(samples));
  score.aic = -2 * score.log_likelihood + 2 * parameters;
}

}  // namespace

EmResult fitMixture(const Eigen::MatrixXd& samples, int components, const EmOptions& options,
                    SampleGroups groups) {
  validate(samples, options);
  if (groups.count == 0) groups.count = samples.cols();
  if (groups.count < 1 || samples.cols() % groups.count != 0) {
    throw Error(ExitCode::kInternal, "the groups of a mixture's samples must have one size");
  }
  if (components < 1) {
    throw Error(ExitCode::kUsage,
                "a mixture needs at least one component, not " + std::to_string(components));
  }
  EmResult result;
  if (components > samples.cols()) {
    result.notes.push_back("only " + std::to_string(samples.cols()) + " of " +
                           std::to_string(components) +
                           " mixture components: there are no more samples");
    components = static_cast<int>(samples.cols());
  }

  const Scaling scaling(samples, options.minimum_scale);
  const Eigen::MatrixXd scaled = scaling.apply(samples);
  const auto count = static_cast<double>(samples.cols());
  // The density changes by the product of the scales.
  const double shift = -count * scaling.scale.array().log().sum();

  GaussianMixture& mixture = result.mixture;
  mixture.components.resize(static_cast<std::size_t>(components));
  result.floored = maximize(scaled, timeBins(scaled, components), options.variance_floor, mixture);
  for (int iteration = 0;; ++iteration) {
    const Eigen::MatrixXd joint = groupJoint(mixture, scaled, groups.count);
    const Eigen::VectorXd evidence = logSumExp(joint);
    const double likelihood = evidence.sum() + shift;
    const bool small_gain =
        iteration > 0 && likelihood - result.history.back() < options.tolerance * count;
    result.history.push_back(likelihood);
    result.score.iterations = iteration;
    result.score.converged = small_gain;
    if (small_gain || iteration == options.iterations) break;
    const Eigen::MatrixXd assignment = (joint.rowwise() - evidence.transpose())
                                           .array()
                                           .exp()
                                           .matrix()
                                           .replicate(1, samples.cols() / groups.count);
    result.floored = maximize(scaled, assignment, options.variance_floor, mixture);
  }

  scaling.undo(mixture);
  auto& all = mixture.components;
  const auto dead = std::remove_if(all.begin(), all.end(),
                                   [](const GaussianComponent& c) { return c.weight <= 1e-12; });
  if (dead != all.end()) {
    result.notes.push_back(std::to_string(all.end() - dead) +
                           " mixture components without any sample were removed");
    all.erase(dead, all.end());
  }
  std::stable_sort(
      all.begin(), all.end(),
      [](const GaussianComponent& a, const GaussianComponent& b) { return a.mean[0] < b.mean[0]; });
  if (result.floored > 0) {
    result.notes.push_back(std::to_string(result.floored) +
                           " eigenvalues of covariances were lifted to the variance floor");
  }
  if (!result.score.converged) {
    result.notes.push_back("expectation maximisation with " + std::to_string(components) +
                           " components stopped at its limit of iterations");
  }
  result.score.components = static_cast<int>(all.size());
  result.score.log_likelihood = result.history.back();
  finishScore(result.score, samples.rows(), samples.cols());
  result.curve = {result.score};
  return result;
}

EmResult selectMixture(const Eigen::MatrixXd& samples, const EmOptions& options,
                       SampleGroups groups) {
  if (options.components != 0) return fitMixture(samples, options.components, options, groups);
  validate(samples, options);
  if (options.minimum_components < 1 || options.maximum_components < options.minimum_components) {
    throw Error(ExitCode::kUsage,
                "the range of mixture components must be 1 <= minimum <= maximum");
  }
  const auto room = static_cast<int>(samples.cols() / (samples.rows() + 1));
  const int last = std::max(options.minimum_components, std::min(options.maximum_components, room));

  EmResult best;
  std::vector<ComponentScore> curve;
  for (int k = options.minimum_components; k <= last; ++k) {
    EmResult candidate = fitMixture(samples, k, options, groups);
    curve.push_back(candidate.score);
    if (curve.size() == 1 || candidate.score.bic < best.score.bic) best = std::move(candidate);
  }
  if (last < options.maximum_components) {
    best.notes.push_back("at most " + std::to_string(last) + " mixture components tried: " +
                         std::to_string(samples.cols()) + " samples carry no more");
  }
  best.curve = std::move(curve);
  return best;
}

}  // namespace graft::lfd
