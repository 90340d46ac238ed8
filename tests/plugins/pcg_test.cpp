// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"
#include "plugins/solver_pcg/incomplete_pattern.hpp"
#include "tests/support/block_matrix.hpp"
#include "tests/support/graphs.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

using testing::BlockMatrix;

class Pcg : public ::testing::Test {
 protected:
  Pcg() : type(engine.registry().solver("pcg")), self(type->create(2)) {}
  ~Pcg() override { type->destroy(self); }

  Engine engine;
  const graft_solver_type* type;
  void* self;
  graft_message message = {};
  std::int32_t failed = -1;
};

TEST_F(Pcg, SolvesLikeADenseSolver) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const int count = 1 + 3 * int(seed);
    const BlockMatrix a(testing::mixedDims(count, seed),
                        testing::randomPairs(count, 3 * count, seed), seed);
    const Eigen::Index n = a.dense.rows();
    ASSERT_EQ(type->analyze(self, &a.pattern, &message), GRAFT_OK) << message.text;
    for (const double lambda : {0.0, 2.5}) {
      const Eigen::VectorXd damping = Eigen::VectorXd::LinSpaced(n, lambda, 2 * lambda);
      ASSERT_EQ(type->factorize(self, a.values.data(), lambda > 0 ? damping.data() : nullptr,
                                &failed, &message),
                GRAFT_OK)
          << message.text;
      Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n, -1, 1);
      Eigen::MatrixXd dense = a.dense;
      dense.diagonal() += damping;
      const Eigen::VectorXd expected = dense.ldlt().solve(x);
      ASSERT_EQ(type->solve(self, x.data(), x.data(), &message), GRAFT_OK) << message.text;
      EXPECT_LT((x - expected).norm() / expected.norm(), 1e-8);
    }
  }
}

/// The incomplete factor of a matrix that has no other entries is the complete one.
TEST_F(Pcg, IsDirectWithoutFill) {
  std::set<std::pair<int, int>> chain;
  for (int i = 1; i < 200; ++i) chain.insert({i - 1, i});
  BlockMatrix a(std::vector<std::int32_t>(200, 2), chain, 1);
  ASSERT_EQ(type->analyze(self, &a.pattern, &message), GRAFT_OK);
  ASSERT_EQ(type->factorize(self, a.values.data(), nullptr, &failed, &message), GRAFT_OK);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(400, -1, 1);
  Eigen::VectorXd x(400);
  ASSERT_EQ(type->solve(self, b.data(), x.data(), &message), GRAFT_OK);
  EXPECT_LT((a.dense * x - b).norm(), 1e-13 * b.norm());
}

/// Of long thin graphs the factor is complete, others keep the blocks of the matrix.
TEST(PcgFill, IsCompleteWhereThatIsLittleAndLimitedWhereItIsNot) {
  std::set<std::pair<int, int>> chain;
  for (int i = 1; i < 400; ++i) chain.insert({i - 1, i});
  for (int i = 0; i < 380; i += 20) chain.insert({i, i + 15});
  const BlockMatrix thin(std::vector<std::int32_t>(400, 1), chain, 1);
  const IncompletePattern fill = incompletePattern(thin.pattern);
  EXPECT_TRUE(fill.complete);
  // The complete factor's pattern, by dense elimination in that order.
  std::vector<std::set<int>> below(400);
  for (const auto& [a, b] : chain) {
    const int i = fill.position[std::size_t(a)];
    const int j = fill.position[std::size_t(b)];
    below[std::size_t(std::min(i, j))].insert(std::max(i, j));
  }
  for (std::size_t j = 0; j < below.size(); ++j) {
    for (const int a : below[j]) {
      for (const int b : below[j]) {
        if (b > a) below[std::size_t(a)].insert(b);
      }
    }
    const std::vector<std::int32_t> rows(fill.rows.begin() + fill.columns[j] + 1,
                                         fill.rows.begin() + fill.columns[j + 1]);
    EXPECT_EQ(rows, std::vector<std::int32_t>(below[j].begin(), below[j].end())) << j;
  }
  // A grid is not thin.
  const BlockMatrix wide(std::vector<std::int32_t>(50 * 50, 1), testing::gridPairs(50), 2);
  const IncompletePattern limited = incompletePattern(wide.pattern);
  EXPECT_FALSE(limited.complete);
  EXPECT_EQ(limited.rows, wide.rows);
  EXPECT_EQ(limited.columns, wide.columns);
}

TEST_F(Pcg, RefusesWhatIsNotPositiveOrNotFinite) {
  BlockMatrix a({3, 2, 4, 1}, {{0, 1}, {1, 2}, {2, 3}}, 3);
  ASSERT_EQ(type->analyze(self, &a.pattern, &message), GRAFT_OK);
  std::vector<double> values = a.values;
  values[std::size_t(a.offsets[std::size_t(a.columns[2])])] = -1;
  EXPECT_EQ(type->factorize(self, values.data(), nullptr, &failed, &message),
            GRAFT_NOT_POSITIVE_DEFINITE);
  EXPECT_EQ(failed, 2);
  double b[10] = {1};
  EXPECT_EQ(type->solve(self, b, b, &message), GRAFT_FAILED);
  values = a.values;
  values.back() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(type->factorize(self, values.data(), nullptr, &failed, &message), GRAFT_FAILED);
  ASSERT_EQ(type->factorize(self, a.values.data(), nullptr, &failed, &message), GRAFT_OK);
  b[4] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(type->solve(self, b, b, &message), GRAFT_FAILED);
}

TEST_F(Pcg, NeverCallsAnIndefiniteMatrixSolved) {
  // Positive blocks on the diagonal, but not together.
  BlockMatrix a({1, 1}, {{0, 1}}, 3);
  ASSERT_EQ(type->analyze(self, &a.pattern, &message), GRAFT_OK);
  const std::vector<double> values = {1, 2, 1};
  const int status = type->factorize(self, values.data(), nullptr, &failed, &message);
  if (status != GRAFT_OK) {
    EXPECT_EQ(status, GRAFT_NOT_POSITIVE_DEFINITE);
    return;
  }
  double b[2] = {1, -1};
  EXPECT_EQ(type->solve(self, b, b, &message), GRAFT_FAILED);
}

/// The same optimum as with a complete factor.
TEST_F(Pcg, OptimizesPoseGraphs) {
  for (const char* file : {"pose_graphs/smallGrid3D.g2o", "pose_graphs/CSAIL.g2o"}) {
    GRAFT_REQUIRE_DATA(file);
    SCOPED_TRACE(file);
    double reference = 0;
    for (const char* solver : {"block", "pcg"}) {
      LoadedGraph loaded = testing::loadData(file, engine.registry());
      SolveOptions options;
      options.linear_solver = solver;
      const Summary summary = optimize(loaded.graph, loaded.values, engine.registry(), options);
      EXPECT_EQ(summary.status, Status::kConverged) << summary.reason;
      if (reference == 0) reference = summary.chi2_final;
      EXPECT_NEAR(summary.chi2_final, reference, 1e-7 * reference);
    }
  }
}

}  // namespace
}  // namespace graft
