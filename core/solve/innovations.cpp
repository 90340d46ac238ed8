// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/innovations.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <functional>
#include <random>

#include "core/linear/selected_inverse.hpp"

namespace graft {

namespace {

/// Estimates in a sample: more than the error of any common edge is long, so that their
/// covariance has full rank there.
constexpr int kSample = 32;
constexpr std::int64_t kEdgesPerPiece = 64;
/// Of I - J H^-1 J', whose eigenvalues lie between 0 and 1: what is below is not checked.
constexpr double kUnchecked = 1e-6;

/// Row-major block of a Jacobian.
using Rows =
    Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>, 0,
               Eigen::OuterStride<>>;

}  // namespace

Innovations::Innovations(Problem& problem, ThreadPool& pool)
    : problem_(&problem), linearizer_(problem, pool) {}

bool Innovations::begin(const GraduationTools& tools, const State& state) {
  {
    SolveContext context(*problem_, tools.solver, tools.memory, tools.pool, tools.seconds);
    context.start(state, 0);
    if (!context.linearize().ok() || !context.factorize(nullptr).ok) return false;
  }
  tools_ = &tools;
  state_ = state;
  // Jacobians of all edges, those that are not in use included.
  std::vector<std::vector<double>> weights;
  for (std::size_t g = 0; g < problem_->groups().size(); ++g) {
    weights.push_back(problem_->groups()[g].weights);
    problem_->setWeights(g, {});
  }
  const bool ok = linearizer_.linearize(state).ok();
  for (std::size_t g = 0; g < weights.size(); ++g) {
    problem_->setWeights(g, std::move(weights[g]));
  }
  return ok;
}

template <class Visit>
void Innovations::forEachFree(Place p, const Visit& visit) const {
  const EdgeGroup& group = problem_->groups()[p.first];
  for (int k = 0; k < group.arity; ++k) {
    const std::int32_t block = group.blocks[p.second * std::size_t(group.arity) + std::size_t(k)];
    if (block >= 0) visit(std::size_t(k), std::size_t(block));
  }
}

Eigen::Map<const Eigen::VectorXd> Innovations::residual(Place p) const {
  const int dim = problem_->groups()[p.first].error_dim;
  return {linearizer_.residuals(p.first).data() + p.second * std::size_t(dim), dim};
}

/// J' z for a vector z of independent signs, one for each row of the edges in use.
std::vector<double> Innovations::noise(std::uint64_t seed) const {
  std::mt19937_64 random(seed);
  std::vector<double> sum(std::size_t(problem_->dim()), 0.0);
  for (std::size_t g = 0; g < problem_->groups().size(); ++g) {
    const EdgeGroup& group = problem_->groups()[g];
    const double* row = linearizer_.jacobians(g).data();
    for (std::int64_t e = 0; e < group.count; ++e) {
      const bool used = group.weight(e) != 0;
      std::uint64_t bits = 0;
      for (int i = 0; i < group.error_dim; ++i, row += group.tangent_dim) {
        if (i % 64 == 0) bits = random();
        const double sign = ((bits >> (i % 64)) & 1U) != 0 ? 1 : -1;
        if (!used) continue;
        forEachFree({g, std::size_t(e)}, [&](std::size_t slot, std::size_t block) {
          double* out = sum.data() + problem_->offsets()[block];
          const double* in = row + group.slot_offsets[slot];
          for (int c = 0; c < group.slot_dims[slot]; ++c) out[c] += sign * in[c];
        });
      }
    }
  }
  return sum;
}

/// J x of an edge.
void Innovations::predict(Place p, const double* x, double* error) const {
  const EdgeGroup& group = problem_->groups()[p.first];
  const auto dim = std::size_t(group.error_dim);
  const auto width = std::size_t(group.tangent_dim);
  const double* row = linearizer_.jacobians(p.first).data() + p.second * dim * width;
  for (std::size_t i = 0; i < dim; ++i, row += width) {
    double sum = 0;
    forEachFree(p, [&](std::size_t slot, std::size_t block) {
      const double* xs = x + problem_->offsets()[block];
      const double* js = row + group.slot_offsets[slot];
      for (int c = 0; c < group.slot_dims[slot]; ++c) sum += js[c] * xs[c];
    });
    error[i] = sum;
  }
}

std::vector<Innovations::View> Innovations::sample(const std::vector<Place>& places) {
  std::vector<Eigen::MatrixXd> covariances;
  for (const Place& p : places) {
    const int dim = problem_->groups()[p.first].error_dim;
    covariances.emplace_back(Eigen::MatrixXd::Identity(dim, dim));
  }
  const auto count = std::int64_t(places.size());
  const auto forEach = [&](const std::function<void(std::size_t)>& visit) {
    tools_->pool.run((count + kEdgesPerPiece - 1) / kEdgesPerPiece, [&](std::int64_t piece) {
      const std::int64_t end = std::min((piece + 1) * kEdgesPerPiece, count);
      for (std::int64_t i = piece * kEdgesPerPiece; i < end; ++i) visit(std::size_t(i));
    });
  };
  std::vector<double> x(std::size_t(problem_->dim()));
  for (int k = 0; k < kSample && count > 0 && !tools_->must_stop(); ++k) {
    const std::vector<double> right = noise(std::uint64_t(k) + 1);
    tools_->solver.solve(right.data(), x.data());
    forEach([&](std::size_t i) {
      Eigen::MatrixXd& covariance = covariances[i];
      Eigen::VectorXd error(covariance.rows());
      predict(places[i], x.data(), error.data());
      covariance.noalias() += error * error.transpose() / kSample;
    });
  }
  std::vector<View> views(places.size());
  forEach([&](std::size_t i) {
    const Eigen::LLT<Eigen::MatrixXd> cholesky(covariances[i]);
    views[i].square = cholesky.matrixL().solve(residual(places[i])).squaredNorm();
    views[i].spread = 2 * cholesky.matrixLLT().diagonal().array().log().mean();
  });
  return views;
}

Eigen::MatrixXd Innovations::jacobian(Place p, std::size_t slot) const {
  const EdgeGroup& group = problem_->groups()[p.first];
  const int dim = group.error_dim;
  const double* first = linearizer_.jacobians(p.first).data() +
                        p.second * std::size_t(dim) * std::size_t(group.tangent_dim) +
                        group.slot_offsets[slot];
  return Rows(first, dim, group.slot_dims[slot], Eigen::OuterStride<>(group.tangent_dim));
}

std::vector<Innovations::Removal> Innovations::removals(const std::vector<Place>& places) {
  std::vector<Removal> removals(places.size());
  Linearizer used(*problem_, tools_->pool);
  if (!used.linearize(state_).ok()) return removals;
  NormalEquations equations(*problem_);
  equations.gather(used, tools_->pool);
  BlockCholesky cholesky(&tools_->pool);
  cholesky.analyze(equations.pattern());
  if (cholesky.factorize(equations.hessian().data(), nullptr) >= 0) return removals;
  std::vector<BlockPair> pairs;
  for (const Place& p : places) {
    forEachFree(p, [&](std::size_t, std::size_t a) {
      forEachFree(p, [&](std::size_t, std::size_t b) {
        if (a >= b) pairs.push_back({std::int32_t(a), std::int32_t(b)});
      });
    });
  }
  const std::vector<Eigen::MatrixXd> blocks = inverseBlocks(cholesky, pairs, &tools_->pool);
  std::size_t next = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const int dim = problem_->groups()[places[i].first].error_dim;
    Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(dim, dim);
    forEachFree(places[i], [&](std::size_t s, std::size_t a) {
      forEachFree(places[i], [&](std::size_t t, std::size_t b) {
        if (a < b) return;
        const Eigen::MatrixXd part =
            jacobian(places[i], s) * blocks[next++] * jacobian(places[i], t).transpose();
        rest -= part;
        if (a != b) rest -= part.transpose();
      });
    });
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(rest);
    const Eigen::VectorXd along = spectrum.eigenvectors().transpose() * residual(places[i]);
    removals[i].checked = spectrum.eigenvalues()[0];
    for (int k = 0; k < dim; ++k) {
      const double checked = spectrum.eigenvalues()[k];
      if (checked > kUnchecked) removals[i].fall += along[k] * along[k] / checked;
    }
  }
  return removals;
}

}  // namespace graft
