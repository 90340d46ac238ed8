// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <random>

#include "core/plugin/engine.hpp"

namespace graft {
namespace {

/// A random sparse symmetric block matrix, and the same as a dense one.
struct BlockProblem {
  std::vector<std::int32_t> dims;
  std::vector<std::int64_t> columns;
  std::vector<std::int32_t> rows;
  std::vector<std::int64_t> offsets;
  std::vector<double> values;
  Eigen::MatrixXd dense;
  std::vector<int> first;

  BlockProblem(int blocks, unsigned seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    std::uniform_int_distribution<int> dim(1, 7);
    int n = 0;
    for (int j = 0; j < blocks; ++j) {
      dims.push_back(dim(random));
      first.push_back(n);
      n += dims.back();
    }
    dense = Eigen::MatrixXd::Zero(n, n);
    columns.push_back(0);
    for (int j = 0; j < blocks; ++j) {
      for (int i = j; i < blocks; ++i) {
        if (i != j && number(random) < 0.4) continue;
        Eigen::MatrixXd block =
            Eigen::MatrixXd::NullaryExpr(dims[i], dims[j], [&] { return number(random); });
        if (i == j) {
          block = block * block.transpose();
          block.diagonal().array() += 3.0 * n;
        }
        rows.push_back(i);
        offsets.push_back(std::int64_t(values.size()));
        values.insert(values.end(), block.data(), block.data() + block.size());
        dense.block(first[i], first[j], dims[i], dims[j]) = block;
        dense.block(first[j], first[i], dims[j], dims[i]) = block.transpose();
      }
      columns.push_back(std::int64_t(rows.size()));
    }
  }
  graft_block_pattern pattern() const {
    return {sizeof(graft_block_pattern),
            std::int32_t(dims.size()),
            dims.data(),
            columns.data(),
            rows.data(),
            offsets.data()};
  }
};

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
    const BlockProblem problem(int(seed) + 1, seed);
    const graft_block_pattern pattern = problem.pattern();
    const auto n = problem.dense.rows();
    ASSERT_EQ(type->analyze(self, &pattern, &message), GRAFT_OK) << message.text;
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
  BlockProblem problem(8, 3);
  const int bad = 5;
  const std::int64_t diagonal = problem.offsets[std::size_t(problem.columns[bad])];
  problem.values[std::size_t(diagonal)] = -1e9;
  const graft_block_pattern pattern = problem.pattern();
  ASSERT_EQ(type->analyze(self, &pattern, &message), GRAFT_OK);
  EXPECT_EQ(type->factorize(self, problem.values.data(), nullptr, &failed, &message),
            GRAFT_NOT_POSITIVE_DEFINITE);
  EXPECT_EQ(failed, bad);
  double b = 0;
  EXPECT_EQ(type->solve(self, &b, &b, &message), GRAFT_FAILED);
}

TEST_F(Cholmod, RefusesWhatIsNotFinite) {
  BlockProblem problem(4, 9);
  problem.values.back() = std::numeric_limits<double>::quiet_NaN();
  const graft_block_pattern pattern = problem.pattern();
  ASSERT_EQ(type->analyze(self, &pattern, &message), GRAFT_OK);
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

TEST_F(Cholmod, StatesItsLicence) {
  EXPECT_NE(engine.registry().providerOf({Kind::kSolver, "cholmod"})->license.find("GPL"),
            std::string::npos);
}

}  // namespace
}  // namespace graft
