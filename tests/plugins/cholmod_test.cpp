// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "core/base/memory.hpp"
#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"
#include "tests/support/address_space.hpp"
#include "tests/support/block_matrix.hpp"
#include "tests/support/graphs.hpp"

namespace graft {
namespace {

using testing::BlockMatrix;

class Cholmod : public ::testing::Test {
 protected:
  Cholmod() : type(engine.registry().solver("cholmod")), self(type->create(1)) {}
  ~Cholmod() override { type->destroy(self); }

  Engine engine;
  const graft_solver_type* type;
  void* self;
  graft_message message = {};
  std::int32_t failed = -1;
};

TEST_F(Cholmod, SolvesLikeADenseSolver) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const int count = int(seed) + 1;
    const BlockMatrix problem(testing::mixedDims(count, seed),
                              testing::randomPairs(count, 2 * count, seed), seed);
    const auto n = problem.dense.rows();
    ASSERT_EQ(type->analyze(self, &problem.pattern, &message), GRAFT_OK) << message.text;
    for (const double lambda : {0.0, 2.5}) {
      const Eigen::VectorXd damping = Eigen::VectorXd::LinSpaced(n, lambda, 2 * lambda);
      ASSERT_EQ(type->factorize(self, problem.values.data(), lambda > 0 ? damping.data() : nullptr,
                                &failed, &message),
                GRAFT_OK)
          << message.text;
      const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(n, -1, 1);
      Eigen::VectorXd x(n);
      ASSERT_EQ(type->solve(self, b.data(), x.data(), &message), GRAFT_OK);
      Eigen::MatrixXd a = problem.dense;
      a.diagonal() += damping;
      const Eigen::VectorXd expected = a.ldlt().solve(b);
      EXPECT_LT((x - expected).norm() / expected.norm(), 1e-12);
    }
  }
}

TEST_F(Cholmod, NamesTheBlockThatIsNotPositive) {
  BlockMatrix problem(testing::mixedDims(8, 3), testing::randomPairs(8, 16, 3), 3);
  const int bad = 5;
  const std::int64_t diagonal = problem.offsets[std::size_t(problem.columns[bad])];
  problem.values[std::size_t(diagonal)] = -1e9;
  ASSERT_EQ(type->analyze(self, &problem.pattern, &message), GRAFT_OK);
  EXPECT_EQ(type->factorize(self, problem.values.data(), nullptr, &failed, &message),
            GRAFT_NOT_POSITIVE_DEFINITE);
  EXPECT_EQ(failed, bad);
  double b = 0;
  EXPECT_EQ(type->solve(self, &b, &b, &message), GRAFT_FAILED);
}

TEST_F(Cholmod, RefusesWhatIsNotFinite) {
  BlockMatrix problem(testing::mixedDims(4, 9), testing::randomPairs(4, 4, 9), 9);
  problem.values.back() = std::numeric_limits<double>::quiet_NaN();
  ASSERT_EQ(type->analyze(self, &problem.pattern, &message), GRAFT_OK);
  EXPECT_EQ(type->factorize(self, problem.values.data(), nullptr, &failed, &message), GRAFT_FAILED);
}

/// Blocks on the diagonal only, as large as a type may make them; no numbers stand behind.
struct HugePattern {
  HugePattern(std::int32_t blocks, std::int32_t dim) : dims(std::size_t(blocks), dim) {
    for (std::int32_t j = 0; j <= blocks; ++j) {
      columns.push_back(j);
      if (j < blocks) rows.push_back(j);
      if (j < blocks) offsets.push_back(std::int64_t(j) * dim * dim);
    }
    pattern = {sizeof pattern, blocks, dims.data(), columns.data(), rows.data(), offsets.data()};
  }
  std::vector<std::int32_t> dims;
  std::vector<std::int64_t> columns;
  std::vector<std::int32_t> rows;
  std::vector<std::int64_t> offsets;
  graft_block_pattern pattern;
};

TEST_F(Cholmod, MatricesBeyondItsIndicesAreRefusedBeforeMemoryIsTaken) {
  // Each of these has more entries than an int counts, the second more rows as well.
  for (const std::int32_t blocks : {2, 32769}) {
    const HugePattern huge(blocks, 65536);
    EXPECT_EQ(type->analyze(self, &huge.pattern, &message), GRAFT_OUT_OF_MEMORY);
    EXPECT_STREQ(message.text, "the matrix is too large for 32-bit indices");
  }
}

TEST_F(Cholmod, PredictsWhatItsFactorTakes) {
  // Without fill: the entries of the matrix (8 + 4 bytes each), and as many of its copy.
  std::set<std::pair<int, int>> chain;
  for (int i = 1; i < 500; ++i) chain.insert({i - 1, i});
  const BlockMatrix thin(std::vector<std::int32_t>(500, 1), chain, 1);
  ASSERT_EQ(type->analyze(self, &thin.pattern, &message), GRAFT_OK);
  EXPECT_EQ(type->factor_bytes(self), 2 * 12 * (500 + 499));
  // One dense front of n columns: n^2 numbers, a work space of one; and again the copy.
  const int n = 400;
  const BlockMatrix full({n}, {}, 1);
  ASSERT_EQ(type->analyze(self, &full.pattern, &message), GRAFT_OK);
  EXPECT_EQ(type->factor_bytes(self), 8.0 * (n * n + 1) + 12.0 * n * (n + 1) / 2);
}

TEST_F(Cholmod, WhatDoesNotFitIsRefusedBeforeItIsTaken) {
  GRAFT_REQUIRE_LIMITS();
  Diagnostics diagnostics;
  LoadedGraph loaded = testing::loadText(testing::cubeOfPoses(16), engine.registry(), diagnostics);
  SolveOptions options;
  options.linear_solver = "cholmod";
  options.threads = 1;
  options.iterations = 1;
  Summary summary = optimize(loaded.graph, loaded.values, engine.registry(), options);
  ASSERT_TRUE(summary.usable()) << summary.reason;
  const double bytes = summary.factor_bytes;
  ASSERT_GT(bytes, 1e8);
  const testing::AddressSpaceLimit limit(0.7 * bytes);
  summary = optimize(loaded.graph, loaded.values, engine.registry(), options);
  EXPECT_EQ(summary.status, Status::kFailed);
  EXPECT_EQ(
      summary.reason.find("the factor of the normal equations needs " + formatBytes(bytes) + ", "),
      0u)
      << summary.reason;
}

TEST_F(Cholmod, StatesItsLicence) {
  EXPECT_NE(engine.registry().providerOf({Kind::kSolver, "cholmod"})->license.find("GPL"),
            std::string::npos);
}

}  // namespace
}  // namespace graft
