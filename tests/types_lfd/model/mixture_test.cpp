// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "core/base/error.hpp"
#include "types_lfd/model/expectation_maximization.hpp"

namespace graft::lfd {
namespace {

Eigen::MatrixXd normalMatrix(Eigen::Index rows, Eigen::Index cols, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd m(rows, cols);
  for (Eigen::Index j = 0; j < cols; ++j) {
    for (Eigen::Index i = 0; i < rows; ++i) m(i, j) = normal(random);
  }
  return m;
}

/// A covariance with well-separated, random eigenvectors.
Eigen::MatrixXd randomCovariance(Eigen::Index dim, std::mt19937_64& random) {
  const Eigen::MatrixXd a = normalMatrix(dim, dim, random);
  return a * a.transpose() / static_cast<double>(dim) + 0.2 * Eigen::MatrixXd::Identity(dim, dim);
}

Eigen::MatrixXd sampleComponent(const GaussianComponent& c, Eigen::Index count,
                                std::mt19937_64& random) {
  const Eigen::MatrixXd l = c.covariance.llt().matrixL();
  return (l * normalMatrix(c.mean.size(), count, random)).colwise() + c.mean;
}

Eigen::MatrixXd covarianceOf(const Eigen::MatrixXd& samples) {
  const Eigen::MatrixXd centered = samples.colwise() - samples.rowwise().mean();
  return centered * centered.transpose() / static_cast<double>(samples.cols());
}

/// A noisy curve over time: what demonstrations look like.
Eigen::MatrixXd noisyCurve(Eigen::Index count, std::mt19937_64& random) {
  Eigen::MatrixXd x(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(count - 1);
    x.col(i) << t, std::sin(6 * t), 0.3 * std::cos(9 * t);
  }
  x.bottomRows(2) += 0.01 * normalMatrix(2, count, random);
  return x;
}

TEST(Mixture, OneComponentIsSampleMeanAndCovariance) {
  std::mt19937_64 random(1);
  const Eigen::MatrixXd samples = sampleComponent(
      {1, Eigen::Vector4d(0.5, -3, 100, 1e-3), randomCovariance(4, random)}, 300, random);
  const EmResult fit = fitMixture(samples, 1, EmOptions());
  ASSERT_EQ(fit.mixture.components.size(), 1U);
  const GaussianComponent& c = fit.mixture.components[0];
  EXPECT_NEAR(c.weight, 1, 1e-14);
  EXPECT_LT((c.mean - samples.rowwise().mean()).norm(), 1e-11);
  EXPECT_LT((c.covariance - covarianceOf(samples)).norm(), 1e-11);
  EXPECT_TRUE(fit.score.converged);
  EXPECT_EQ(fit.floored, 0);
}

TEST(Mixture, LogLikelihoodOfOneGaussianHasItsClosedForm) {
  std::mt19937_64 random(2);
  const Eigen::MatrixXd samples = normalMatrix(3, 200, random);
  const EmResult fit = fitMixture(samples, 1, EmOptions());
  // At the maximum the quadratic forms sum to N D.
  const double expected = -0.5 * 200 *
                          (3 * std::log(2 * 3.14159265358979323846) +
                           std::log(covarianceOf(samples).determinant()) + 3);
  EXPECT_NEAR(fit.score.log_likelihood, expected, 1e-9 * std::abs(expected));
  EXPECT_NEAR(fit.mixture.logLikelihood(samples), expected, 1e-9 * std::abs(expected));
  EXPECT_NEAR(fit.score.bic, -2 * expected + 9 * std::log(200.0), 1e-6);
  EXPECT_NEAR(fit.score.aic, -2 * expected + 18, 1e-6);
}

TEST(Mixture, TwoSeparatedComponentsAreTheirSamplesMoments) {
  std::mt19937_64 random(3);
  Eigen::MatrixXd samples(3, 500);
  samples.leftCols(200) = sampleComponent(
      {1, Eigen::Vector3d(0, 0, 0), 0.01 * randomCovariance(3, random)}, 200, random);
  samples.rightCols(300) = sampleComponent(
      {1, Eigen::Vector3d(10, 5, -5), 0.01 * randomCovariance(3, random)}, 300, random);
  const EmResult fit = fitMixture(samples, 2, EmOptions());
  ASSERT_EQ(fit.mixture.components.size(), 2U);
  EXPECT_NEAR(fit.mixture.components[0].weight, 0.4, 1e-9);
  for (int k = 0; k < 2; ++k) {
    const Eigen::MatrixXd part = k == 0 ? samples.leftCols(200) : samples.rightCols(300);
    const GaussianComponent& c = fit.mixture.components[static_cast<std::size_t>(k)];
    EXPECT_LT((c.mean - part.rowwise().mean()).norm(), 1e-9);
    EXPECT_LT((c.covariance - covarianceOf(part)).norm(), 1e-9);
  }
}

TEST(Mixture, LikelihoodNeverFalls) {
  std::mt19937_64 random(4);
  const Eigen::MatrixXd curve = noisyCurve(240, random);
  Eigen::MatrixXd repeated(3, 60);  // few distinct points: the floor is at work
  for (Eigen::Index i = 0; i < 60; ++i) repeated.col(i) = curve.col(40 * (i / 10));
  for (const Eigen::MatrixXd& samples : {curve, repeated}) {
    for (const int k : {1, 3, 6, 9}) {
      const EmResult fit = fitMixture(samples, k, EmOptions());
      for (std::size_t i = 1; i < fit.history.size(); ++i) {
        EXPECT_GE(fit.history[i], fit.history[i - 1] - 1e-9 * std::abs(fit.history[i])) << k;
      }
      EXPECT_NEAR(fit.mixture.logLikelihood(samples), fit.history.back(),
                  1e-6 * std::abs(fit.history.back()));
    }
  }
}

TEST(Mixture, RegressionOfOneGaussianIsItsConditional) {
  std::mt19937_64 random(5);
  GaussianMixture mixture;
  mixture.components.push_back({1, normalMatrix(5, 1, random), randomCovariance(5, random)});
  const GaussianComponent& c = mixture.components[0];
  const double t = 0.7;
  const TimeRegression r = mixture.atTime(t);
  // Independent truth: the conditional's information is a block of the joint's.
  const Eigen::MatrixXd information = c.covariance.inverse();
  const Eigen::MatrixXd conditional = information.bottomRightCorner(4, 4).inverse();
  const Eigen::VectorXd mean =
      c.mean.tail(4) - conditional * information.bottomLeftCorner(4, 1) * (t - c.mean[0]);
  EXPECT_LT((r.mean - mean).norm(), 1e-12);
  EXPECT_LT((r.covariance - conditional).norm(), 1e-12);
}

TEST(Mixture, RegressionHasTheMomentsOfTheConditionalMixture) {
  // Two components equally active at t = 0 whose means are 2 apart: variance
  // 0.25 within and 1 between.
  GaussianMixture mixture;
  for (const double side : {-1.0, 1.0}) {
    Eigen::Matrix2d covariance;
    covariance << 1, 0, 0, 0.25;
    mixture.components.push_back({0.5, Eigen::Vector2d(0, side), covariance});
  }
  const TimeRegression r = mixture.atTime(0);
  EXPECT_NEAR(r.mean[0], 0, 1e-15);
  EXPECT_NEAR(r.covariance(0, 0), 1.25, 1e-14);

  // In general: integrals of p(x | t) over a grid, for random components in 2-D.
  std::mt19937_64 random(6);
  GaussianMixture general;
  for (const double weight : {0.2, 0.5, 0.3}) {
    general.components.push_back({weight, normalMatrix(2, 1, random), randomCovariance(2, random)});
  }
  for (const double t : {-1.0, 0.2, 1.5}) {
    double mass = 0;
    double first = 0;
    double second = 0;
    const double step = 0.002;
    Eigen::MatrixXd point(2, 1);
    for (double x = -12; x <= 12; x += step) {
      point << t, x;
      const double p = std::exp(general.logLikelihood(point)) * step;
      mass += p;
      first += p * x;
      second += p * x * x;
    }
    const TimeRegression regression = general.atTime(t);
    EXPECT_NEAR(regression.mean[0], first / mass, 1e-9);
    EXPECT_NEAR(regression.covariance(0, 0), second / mass - first * first / (mass * mass), 1e-9);
  }
}

TEST(Mixture, RegressionFarFromTheDataIsFinite) {
  std::mt19937_64 random(7);
  const EmResult fit = fitMixture(noisyCurve(200, random), 6, EmOptions());
  for (const double t : {-100.0, 50.0, 1e6}) {
    const TimeRegression r = fit.mixture.atTime(t);
    EXPECT_TRUE(r.mean.allFinite() && r.covariance.allFinite());
    EXPECT_NEAR(r.activation.sum(), 1, 1e-12);
  }
}

TEST(Mixture, BicFindsTheNumberOfComponents) {
  for (const int truth : {1, 2, 4}) {
    std::mt19937_64 random(static_cast<std::uint64_t>(truth));
    Eigen::MatrixXd samples(3, 200 * truth);
    for (int k = 0; k < truth; ++k) {
      const GaussianComponent c{1, Eigen::Vector3d(4.0 * k, k % 2 == 0 ? 0 : 5, 2.0 * k),
                                0.3 * randomCovariance(3, random)};
      samples.middleCols(200 * k, 200) = sampleComponent(c, 200, random);
    }
    EmOptions options;
    options.maximum_components = 7;
    const EmResult fit = selectMixture(samples, options);
    EXPECT_EQ(fit.score.components, truth);
    ASSERT_EQ(fit.curve.size(), 7U);
    for (const ComponentScore& s : fit.curve) EXPECT_GE(s.bic, fit.score.bic);
  }
}

TEST(Mixture, GroupsShareTheirComponent) {
  // Four demonstrations far apart from one another: clusters each, if it were not
  // for the groups.
  std::mt19937_64 random(9);
  const Eigen::Index steps = 50;
  Eigen::MatrixXd samples(2, 4 * steps);
  for (Eigen::Index d = 0; d < 4; ++d) {
    for (Eigen::Index i = 0; i < steps; ++i) {
      const double t = static_cast<double>(i) / (steps - 1);
      samples.col(d * steps + i) << t, 3.0 * static_cast<double>(d) + (t < 0.5 ? t : 1 - t);
    }
  }
  samples.row(1) += 0.01 * normalMatrix(1, 4 * steps, random);
  const EmResult grouped = fitMixture(samples, 4, EmOptions(), SampleGroups{steps});
  for (const GaussianComponent& c : grouped.mixture.components) {
    EXPECT_GT(c.covariance(1, 1), 5);     // all four demonstrations ...
    EXPECT_LT(c.covariance(0, 0), 0.02);  // ... at one time
  }
  for (const double t : {0.1, 0.25, 0.9}) {
    const double mean = 4.5 + (t < 0.5 ? t : 1 - t);
    EXPECT_NEAR(grouped.mixture.atTime(t).mean[0], mean, 0.03);
  }
  for (std::size_t i = 1; i < grouped.history.size(); ++i) {
    EXPECT_GE(grouped.history[i], grouped.history[i - 1] - 1e-9 * std::abs(grouped.history[i]));
  }
  // Its likelihood by brute force.
  double likelihood = 0;
  for (Eigen::Index g = 0; g < steps; ++g) {
    Eigen::MatrixXd terms(4, 1);
    for (Eigen::Index k = 0; k < 4; ++k) {
      GaussianMixture one;
      one.components.push_back(grouped.mixture.components[static_cast<std::size_t>(k)]);
      terms(k, 0) = std::log(one.components[0].weight);
      one.components[0].weight = 1;
      for (Eigen::Index d = 0; d < 4; ++d) {
        terms(k, 0) += one.logLikelihood(samples.col(d * steps + g));
      }
    }
    likelihood += logSumExp(terms)[0];
  }
  EXPECT_NEAR(grouped.score.log_likelihood, likelihood, 1e-8 * std::abs(likelihood));
  EXPECT_THROW(fitMixture(samples, 2, EmOptions(), SampleGroups{3}), Error);
}

TEST(Mixture, UnitsDoNotMatter) {
  std::mt19937_64 random(8);
  const Eigen::MatrixXd samples = noisyCurve(200, random);
  const Eigen::Vector3d unit(1, 1000, 0.25);
  const EmResult a = fitMixture(samples, 4, EmOptions());
  const EmResult b = fitMixture(unit.asDiagonal() * samples, 4, EmOptions());
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_LT((unit.asDiagonal() * a.mixture.components[k].mean - b.mixture.components[k].mean)
                  .cwiseQuotient(unit)
                  .norm(),
              1e-7);
  }
}

TEST(Mixture, DegenerateSamplesGiveFlooredCovariancesAndNotes) {
  EmOptions options;
  const auto expectUsable = [&](const EmResult& fit) {
    EXPECT_FALSE(fit.notes.empty());
    for (const GaussianComponent& c : fit.mixture.components) {
      EXPECT_TRUE(c.mean.allFinite() && c.covariance.allFinite());
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(c.covariance);
      EXPECT_GT(eigen.eigenvalues()[0], 0);
    }
    EXPECT_TRUE(fit.mixture.atTime(0.5).mean.allFinite());
  };
  const Eigen::MatrixXd identical = Eigen::Vector3d(0.5, 2, -1).replicate(1, 40);
  expectUsable(fitMixture(identical, 3, options));
  expectUsable(selectMixture(identical, options));
  EXPECT_LT(
      (fitMixture(identical, 3, options).mixture.atTime(0.5).mean - Eigen::Vector2d(2, -1)).norm(),
      1e-9);

  const EmResult few = fitMixture(Eigen::MatrixXd::Random(3, 4), 9, options);  // K > N
  expectUsable(few);
  EXPECT_LE(few.mixture.components.size(), 4U);
  EXPECT_NE(few.notes[0].find("only 4 of 9"), std::string::npos);
  expectUsable(fitMixture(Eigen::MatrixXd::Zero(3, 1), 1, options));
}

TEST(Mixture, BadArgumentsAreRefused) {
  const Eigen::MatrixXd samples = Eigen::MatrixXd::Random(2, 10);
  const auto codeOf = [](const auto& f) {
    try {
      f();
    } catch (const Error& e) {
      return e.code();
    }
    return ExitCode::kSuccess;
  };
  EmOptions no_floor;
  no_floor.variance_floor = 0;
  EmOptions no_range;
  no_range.minimum_components = 0;
  Eigen::MatrixXd hole = samples;
  hole(1, 3) = std::nan("");
  EXPECT_EQ(codeOf([&] { fitMixture(samples, 0, EmOptions()); }), ExitCode::kUsage);
  EXPECT_EQ(codeOf([&] { fitMixture(samples, 1, no_floor); }), ExitCode::kUsage);
  EXPECT_EQ(codeOf([&] { selectMixture(samples, no_range); }), ExitCode::kUsage);
  EXPECT_EQ(codeOf([&] { fitMixture(hole, 1, EmOptions()); }), ExitCode::kInput);
  EXPECT_EQ(codeOf([&] { selectMixture(Eigen::MatrixXd(2, 0), EmOptions()); }), ExitCode::kInput);
  EXPECT_EQ(codeOf([&] { GaussianMixture().atTime(0); }), ExitCode::kInternal);
}

}  // namespace
}  // namespace graft::lfd
