// SPDX-License-Identifier: BSD-3-Clause
#include "core/linear/selected_inverse.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/support/block_matrix.hpp"

namespace graft {
namespace {

using testing::BlockMatrix;
using testing::gridPairs;
using testing::mixedDims;
using testing::randomPairs;

std::vector<BlockPair> allPairs(const BlockMatrix& a) {
  std::vector<BlockPair> pairs;
  for (std::int32_t i = 0; i < a.pattern.block_count; ++i) {
    for (std::int32_t j = 0; j < a.pattern.block_count; ++j) pairs.push_back({i, j});
  }
  return pairs;
}

/// Largest difference from the dense inverse, relative to its largest entry.
double worstError(const BlockMatrix& a, const std::vector<BlockPair>& pairs,
                  const std::vector<Eigen::MatrixXd>& blocks) {
  const Eigen::MatrixXd inverse =
      a.dense.llt().solve(Eigen::MatrixXd::Identity(a.dense.rows(), a.dense.rows()));
  double worst = blocks.size() == pairs.size() ? 0 : 1;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::MatrixXd expected =
        inverse.block(a.begin(pairs[i].row), a.begin(pairs[i].column),
                      a.dims[std::size_t(pairs[i].row)], a.dims[std::size_t(pairs[i].column)]);
    if (blocks[i].rows() != expected.rows() || blocks[i].cols() != expected.cols()) return 1;
    worst = std::max(worst, (blocks[i] - expected).cwiseAbs().maxCoeff());
  }
  return worst / inverse.cwiseAbs().maxCoeff();
}

void expectInverse(const BlockMatrix& a, const FrontKernels& kernels = frontKernels()) {
  BlockCholesky cholesky(nullptr, kernels);
  cholesky.analyze(a.pattern);
  ASSERT_EQ(cholesky.factorize(a.values.data(), nullptr), -1);
  const std::vector<BlockPair> pairs = allPairs(a);
  EXPECT_LT(worstError(a, pairs, inverseBlocks(cholesky, pairs, nullptr)), 1e-13);
  // Few blocks, so that solving is cheaper.
  const std::vector<BlockPair> few = {{0, 0}, {a.pattern.block_count - 1, 0}};
  EXPECT_LT(worstError(a, few, inverseBlocks(cholesky, few, nullptr)), 1e-13);
}

TEST(SelectedInverse, OfOneBlockOfAnySize) {
  for (int dim = 1; dim <= 40; ++dim) expectInverse(BlockMatrix({dim}, {}, 1));
}

TEST(SelectedInverse, OfRandomPatternsOfMixedBlocks) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    const int count = 2 + int(seed * 3 % 60);
    const BlockMatrix a(mixedDims(count, seed), randomPairs(count, count * int(1 + seed % 4), seed),
                        seed);
    expectInverse(a);
    expectInverse(a, portableFrontKernels());
  }
}

TEST(SelectedInverse, OfGridsAndSeparateParts) {
  expectInverse(BlockMatrix(std::vector<std::int32_t>(144, 3), gridPairs(12), 4));
  std::set<std::pair<int, int>> parts;
  for (int i = 1; i < 80; ++i) {
    if (i % 7 != 0) parts.insert({i - 1, i});
  }
  expectInverse(BlockMatrix(mixedDims(80, 3), parts, 3));
}

TEST(SelectedInverse, HasTheSameBitsForAnyThreads) {
  constexpr int kSide = 18;
  const BlockMatrix a(std::vector<std::int32_t>(kSide * kSide, 6), gridPairs(kSide), 9);
  std::vector<BlockPair> pairs;
  for (std::int32_t i = 0; i < kSide * kSide; ++i) {
    pairs.push_back({i, i});
    if (i > 0) pairs.push_back({i, i - 1});
    if (i % 50 == 1) pairs.push_back({i, kSide * kSide - i});
  }
  std::vector<Eigen::MatrixXd> reference;
  for (const int threads : {1, 2, 4}) {
    ThreadPool pool(threads);
    BlockCholesky cholesky(&pool);
    cholesky.analyze(a.pattern);
    EXPECT_EQ(cholesky.symbolic().tasks.empty(), threads == 1);
    ASSERT_EQ(cholesky.factorize(a.values.data(), nullptr), -1);
    const std::vector<Eigen::MatrixXd> blocks = inverseBlocks(cholesky, pairs, &pool);
    if (threads == 1) reference = blocks;
    EXPECT_TRUE(blocks == reference);
  }
  EXPECT_LT(worstError(a, pairs, reference), 1e-13);
}

TEST(SelectedInverse, OfNothingIsNothing) {
  const BlockMatrix a({3, 2}, {{0, 1}}, 1);
  BlockCholesky cholesky;
  cholesky.analyze(a.pattern);
  ASSERT_EQ(cholesky.factorize(a.values.data(), nullptr), -1);
  EXPECT_TRUE(inverseBlocks(cholesky, {}, nullptr).empty());
}

}  // namespace
}  // namespace graft
