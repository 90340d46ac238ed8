// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>
#include <random>
#include <set>

#include "core/solve/block_cholesky.hpp"

namespace graft {
namespace {

/// A symmetric block matrix, dense and as the solver wants it.
struct BlockMatrix {
  std::vector<std::int32_t> dims;
  std::vector<std::int64_t> columns;
  std::vector<std::int32_t> rows;
  std::vector<std::int64_t> offsets;
  std::vector<double> values;
  Eigen::MatrixXd dense;
  graft_block_pattern pattern = {};

  /// `pairs`: off-diagonal blocks. Random entries; the diagonal makes it definite.
  BlockMatrix(std::vector<std::int32_t> block_dims, const std::set<std::pair<int, int>>& pairs,
              std::uint64_t seed)
      : dims(std::move(block_dims)) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<int> begin(1, 0);
    for (const int dim : dims) begin.push_back(begin.back() + dim);
    dense = Eigen::MatrixXd::Zero(begin.back(), begin.back());
    const auto fill = [&](int i, int j) {
      for (int r = begin[std::size_t(i)]; r < begin[std::size_t(i) + 1]; ++r) {
        for (int c = begin[std::size_t(j)]; c < begin[std::size_t(j) + 1]; ++c) {
          dense(r, c) = uniform(random);
          dense(c, r) = dense(r, c);
        }
      }
    };
    for (std::size_t i = 0; i < dims.size(); ++i) fill(int(i), int(i));
    for (const auto& [a, b] : pairs) fill(std::max(a, b), std::min(a, b));
    for (int i = 0; i < dense.rows(); ++i) dense(i, i) = dense.row(i).cwiseAbs().sum() + 0.1;
    columns.push_back(0);
    offsets.push_back(0);
    for (int j = 0; j < int(dims.size()); ++j) {
      for (int i = j; i < int(dims.size()); ++i) {
        if (i != j && pairs.count({j, i}) == 0 && pairs.count({i, j}) == 0) continue;
        rows.push_back(i);
        const Eigen::MatrixXd block = dense.block(begin[std::size_t(i)], begin[std::size_t(j)],
                                                  dims[std::size_t(i)], dims[std::size_t(j)]);
        values.insert(values.end(), block.data(), block.data() + block.size());
        offsets.push_back(std::int64_t(values.size()));
      }
      columns.push_back(std::int64_t(rows.size()));
    }
    pattern.struct_size = sizeof pattern;
    pattern.block_count = std::int32_t(dims.size());
    pattern.dims = dims.data();
    pattern.columns = columns.data();
    pattern.rows = rows.data();
    pattern.offsets = offsets.data();
  }
  BlockMatrix(const BlockMatrix&) = delete;
};

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

std::vector<std::int32_t> mixedDims(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<std::int32_t> dims;
  for (int i = 0; i < count; ++i) dims.push_back(std::int32_t(random() % 7) + 1);
  return dims;
}

TEST(BlockCholesky, SolvesOneBlockOfAnySize) {
  for (int dim = 1; dim <= 40; ++dim) expectSolves(BlockMatrix({dim}, {}, 1));
}

TEST(BlockCholesky, SolvesRandomPatternsOfMixedBlocks) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    std::mt19937_64 random(seed);
    const int count = 2 + int(random() % 60);
    std::set<std::pair<int, int>> pairs;
    for (int k = 0; k < count * int(1 + seed % 4); ++k) {
      const int i = int(random() % std::uint64_t(count));
      const int j = int(random() % std::uint64_t(count));
      if (i != j) pairs.insert({std::min(i, j), std::max(i, j)});
    }
    SCOPED_TRACE(seed);
    const BlockMatrix a(mixedDims(count, seed), pairs, seed);
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
  std::set<std::pair<int, int>> grid;
  for (int i = 0; i < 15; ++i) {
    for (int j = 0; j < 15; ++j) {
      if (i > 0) grid.insert({15 * (i - 1) + j, 15 * i + j});
      if (j > 0) grid.insert({15 * i + j - 1, 15 * i + j});
    }
  }
  expectSolves(BlockMatrix(std::vector<std::int32_t>(225, 3), grid, 4));
}

TEST(BlockCholesky, GivesTheSameBitsForAnyThreads) {
  std::set<std::pair<int, int>> grid;
  constexpr int kSide = 20;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      if (i > 0) grid.insert({kSide * (i - 1) + j, kSide * i + j});
      if (j > 0) grid.insert({kSide * i + j - 1, kSide * i + j});
    }
  }
  BlockMatrix a(std::vector<std::int32_t>(kSide * kSide, 6), grid, 9);
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
  EXPECT_DOUBLE_EQ(predictFlops(graph, {0, 1, 2}), flops);
  EXPECT_DOUBLE_EQ(chooseOrdering(graph).flops, flops);
}

TEST(Ordering, IsAPermutationForBigGridsToo) {
  std::set<std::pair<int, int>> grid;
  constexpr int kSide = 26;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      if (i > 0) grid.insert({kSide * (i - 1) + j, kSide * i + j});
      if (j > 0) grid.insert({kSide * i + j - 1, kSide * i + j});
    }
  }
  const BlockMatrix a(std::vector<std::int32_t>(kSide * kSide, 1), grid, 8);
  BlockGraph graph(a.pattern);
  // As if blocks were large, so that nested dissection is tried.
  std::fill(graph.dims.begin(), graph.dims.end(), 12);
  Ordering ordering = chooseOrdering(graph);
  EXPECT_LE(ordering.flops, predictFlops(graph, ordering.order));
  std::sort(ordering.order.begin(), ordering.order.end());
  for (int i = 0; i < kSide * kSide; ++i) EXPECT_EQ(ordering.order[std::size_t(i)], i);
}

}  // namespace
}  // namespace graft
