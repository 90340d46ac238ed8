// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

#include "core/linear/block_cholesky.hpp"
#include "tests/support/block_matrix.hpp"

namespace graft {
namespace {

using testing::BlockMatrix;
using testing::gridPairs;
using testing::mixedDims;
using testing::randomPairs;

/// Compares with Eigen's dense Cholesky, with and without damping.
void expectSolves(const BlockMatrix& a, const FrontKernels& kernels = frontKernels()) {
  BlockCholesky cholesky(nullptr, kernels);
  cholesky.analyze(a.pattern);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(a.dense.rows(), -1, 2);
  for (const double damping : {0.0, 0.7}) {
    const Eigen::VectorXd diagonal = damping * Eigen::VectorXd::LinSpaced(a.dense.rows(), 1, 3);
    ASSERT_EQ(cholesky.factorize(a.values.data(), damping > 0 ? diagonal.data() : nullptr), -1);
    Eigen::VectorXd x(b.size());
    cholesky.solve(b.data(), x.data());
    Eigen::MatrixXd dense = a.dense;
    dense.diagonal() += diagonal;
    const Eigen::VectorXd expected = dense.llt().solve(b);
    EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST(BlockCholesky, SolvesOneBlockOfAnySize) {
  for (int dim = 1; dim <= 40; ++dim) expectSolves(BlockMatrix({dim}, {}, 1));
}

TEST(BlockCholesky, SolvesRandomPatternsOfMixedBlocks) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    std::mt19937_64 random(seed);
    const int count = 2 + int(random() % 60);
    SCOPED_TRACE(seed);
    const BlockMatrix a(mixedDims(count, seed), randomPairs(count, count * int(1 + seed % 4), seed),
                        seed);
    expectSolves(a);
    expectSolves(a, portableFrontKernels());
  }
}

TEST(BlockCholesky, SolvesArrowChainGridAndSeparateParts) {
  std::set<std::pair<int, int>> arrow;
  std::set<std::pair<int, int>> chain;
  std::set<std::pair<int, int>> parts;
  for (int i = 1; i < 80; ++i) {
    arrow.insert({0, i});
    chain.insert({i - 1, i});
    if (i % 7 != 0) parts.insert({i - 1, i});
  }
  expectSolves(BlockMatrix(mixedDims(80, 1), arrow, 1));
  expectSolves(BlockMatrix(std::vector<std::int32_t>(80, 6), chain, 2));
  expectSolves(BlockMatrix(mixedDims(80, 3), parts, 3));
  expectSolves(BlockMatrix(std::vector<std::int32_t>(225, 3), gridPairs(15), 4));
}

TEST(BlockCholesky, GivesTheSameBitsForAnyThreads) {
  constexpr int kSide = 20;
  BlockMatrix a(std::vector<std::int32_t>(kSide * kSide, 6), gridPairs(kSide), 9);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(a.dense.rows(), -1, 2);
  Eigen::VectorXd damping = Eigen::VectorXd::Zero(a.dense.rows());
  Eigen::VectorXd reference;
  std::vector<std::int32_t> failed;
  for (const int threads : {1, 2, 4}) {
    ThreadPool pool(threads);
    BlockCholesky cholesky(&pool);
    cholesky.analyze(a.pattern);
    EXPECT_EQ(cholesky.symbolic().tasks.empty(), threads == 1);
    ASSERT_EQ(cholesky.factorize(a.values.data(), nullptr), -1);
    Eigen::VectorXd x(b.size());
    cholesky.solve(b.data(), x.data());
    if (threads == 1) reference = x;
    EXPECT_TRUE(x == reference);
    std::vector<std::int32_t> blocks;
    for (const int first : {17, 100, 321}) {
      damping[6 * first] = damping[6 * (kSide * kSide - first)] = -1e9;
      blocks.push_back(cholesky.factorize(a.values.data(), damping.data()));
      damping.setZero();
    }
    if (threads == 1) failed = blocks;
    EXPECT_EQ(blocks, failed);
  }
  EXPECT_LT((a.dense * reference - b).norm(), 1e-12 * b.norm());
}

TEST(BlockCholesky, NamesABlockThatIsNotPositive) {
  BlockMatrix a(mixedDims(30, 5), {{3, 7}, {7, 20}}, 5);
  BlockCholesky cholesky;
  cholesky.analyze(a.pattern);
  std::vector<double> damping(std::size_t(a.dense.rows()), 0.0);
  std::int64_t first = std::accumulate(a.dims.begin(), a.dims.begin() + 12, std::int64_t{0});
  for (const double bad :
       {-1e9, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    damping[std::size_t(first)] = bad;
    EXPECT_EQ(cholesky.factorize(a.values.data(), damping.data()), 12);
  }
  EXPECT_EQ(cholesky.factorize(a.values.data(), nullptr), -1);
}

TEST(BlockCholesky, FindsSingularMatricesInSpiteOfRounding) {
  // A Laplacian with odd weights: its smallest eigenvalue is zero to rounding.
  BlockMatrix a({1, 1, 1, 1}, {{0, 1}, {1, 2}, {2, 3}, {0, 3}}, 6);
  const double weights[] = {0.1, 0.3, 0.7, 1.1};
  std::fill(a.values.begin(), a.values.end(), 0.0);
  const auto add = [&](int i, int j, double value) {
    for (std::int64_t b = a.columns[std::size_t(j)]; b < a.columns[std::size_t(j) + 1]; ++b) {
      if (a.rows[std::size_t(b)] == i) a.values[std::size_t(a.offsets[std::size_t(b)])] += value;
    }
  };
  const std::pair<int, int> edges[] = {{0, 1}, {1, 2}, {2, 3}, {0, 3}};
  for (int k = 0; k < 4; ++k) {
    add(edges[k].first, edges[k].first, weights[k]);
    add(edges[k].second, edges[k].second, weights[k]);
    add(edges[k].second, edges[k].first, -weights[k]);
  }
  BlockCholesky cholesky;
  cholesky.analyze(a.pattern);
  EXPECT_GE(cholesky.factorize(a.values.data(), nullptr), 0);
}

TEST(Ordering, PredictsWhatADenseFactorisationTakes) {
  const BlockMatrix a({2, 3, 1}, {{0, 1}, {0, 2}, {1, 2}}, 7);
  const BlockGraph graph(a.pattern);
  double flops = 0;
  for (int n = 6; n > 0; --n) flops += double(n) * n;
  EXPECT_DOUBLE_EQ(predictCost(graph, {0, 1, 2}).flops, flops);
  EXPECT_DOUBLE_EQ(predictCost(graph, {0, 1, 2}).entries, 21);
  EXPECT_DOUBLE_EQ(chooseOrdering(graph).flops, flops);
}

TEST(Ordering, IsAPermutationForBigGridsToo) {
  constexpr int kSide = 26;
  const BlockMatrix a(std::vector<std::int32_t>(kSide * kSide, 1), gridPairs(kSide), 8);
  BlockGraph graph(a.pattern);
  // As if blocks were large, so that nested dissection is tried.
  std::fill(graph.dims.begin(), graph.dims.end(), 12);
  Ordering ordering = chooseOrdering(graph);
  EXPECT_LE(ordering.flops, predictCost(graph, ordering.order).flops);
  std::sort(ordering.order.begin(), ordering.order.end());
  for (int i = 0; i < kSide * kSide; ++i) EXPECT_EQ(ordering.order[std::size_t(i)], i);
}

}  // namespace
}  // namespace graft
