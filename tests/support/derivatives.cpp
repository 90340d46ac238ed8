// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/derivatives.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace graft::testing {

namespace {

Eigen::VectorXd riddersColumn(const std::function<Eigen::VectorXd(double)>& f, double step) {
  constexpr int kLevels = 10;
  constexpr double kShrink = 1.4;
  std::vector<std::vector<Eigen::VectorXd>> table(kLevels);
  Eigen::VectorXd best;
  double best_error = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kLevels; ++i, step /= kShrink) {
    table[i].push_back((f(step) - f(-step)) / (2 * step));
    double factor = kShrink * kShrink;
    for (int j = 1; j <= i; ++j, factor *= kShrink * kShrink) {
      table[i].push_back((factor * table[i][j - 1] - table[i - 1][j - 1]) / (factor - 1));
      const double error =
          std::max((table[i][j] - table[i][j - 1]).template lpNorm<Eigen::Infinity>(),
                   (table[i][j] - table[i - 1][j - 1]).template lpNorm<Eigen::Infinity>());
      if (error <= best_error) {
        best_error = error;
        best = table[i][j];
      }
    }
  }
  return best;
}

}  // namespace

Eigen::MatrixXd riddersJacobian(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& f,
                                int n, double initial_step) {
  Eigen::MatrixXd jacobian;
  for (int k = 0; k < n; ++k) {
    const auto along = [&](double s) {
      Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
      x[k] = s;
      return f(x);
    };
    const Eigen::VectorXd column = riddersColumn(along, initial_step);
    if (jacobian.size() == 0) jacobian.resize(column.size(), n);
    jacobian.col(k) = column;
  }
  return jacobian;
}

}  // namespace graft::testing
