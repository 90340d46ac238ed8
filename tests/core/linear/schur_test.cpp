// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "core/linear/block_cholesky.hpp"
#include "core/linear/schur_pattern.hpp"
#include "core/linear/selected_inverse.hpp"
#include "tests/support/block_matrix.hpp"

namespace graft {
namespace {

using testing::BlockMatrix;
using testing::landmarkDims;
using testing::landmarkPairs;
using testing::mixedDims;
using testing::randomPairs;

constexpr int kPoses = 9;
constexpr int kLandmarks = 350;

const BlockMatrix& landmarks() {
  static const BlockMatrix matrix(landmarkDims(kPoses, kLandmarks),
                                  landmarkPairs(kPoses, kLandmarks, 3), 3);
  return matrix;
}

bool areNeighbours(const BlockGraph& graph, std::int32_t a, std::int32_t b) {
  const auto first = graph.neighbours.begin() + graph.begin[std::size_t(a)];
  const auto last = graph.neighbours.begin() + graph.begin[std::size_t(a) + 1];
  return std::binary_search(first, last, b);
}

TEST(SchurPattern, EliminatesAsADenseComplementDoes) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const int count = 5 + int(seed);
    const BlockMatrix a(mixedDims(count, seed), randomPairs(count, 2 * count, seed), seed);
    const BlockGraph graph(a.pattern);
    const std::vector<std::int32_t> set = independentSet(graph);
    const SchurPattern rest = eliminateBlocks(graph, set);
    ASSERT_EQ(set.size() + rest.blocks.size(), std::size_t(count));
    for (const std::int32_t x : set) {
      for (const std::int32_t y : set) EXPECT_FALSE(areNeighbours(graph, x, y));
    }
    // Maximal: every other block has a neighbour in it.
    for (const std::int32_t x : rest.blocks) {
      EXPECT_TRUE(std::any_of(set.begin(), set.end(),
                              [&](std::int32_t y) { return areNeighbours(graph, x, y); }));
    }
    for (std::int32_t i = 0; i < rest.graph.size(); ++i) {
      const std::int32_t x = rest.blocks[std::size_t(i)];
      EXPECT_EQ(rest.graph.dims[std::size_t(i)], graph.dims[std::size_t(x)]);
      for (std::int32_t j = 0; j < rest.graph.size(); ++j) {
        const std::int32_t y = rest.blocks[std::size_t(j)];
        const bool joined =
            i != j &&
            (areNeighbours(graph, x, y) || std::any_of(set.begin(), set.end(), [&](std::int32_t s) {
               return areNeighbours(graph, s, x) && areNeighbours(graph, s, y);
             }));
        EXPECT_EQ(areNeighbours(rest.graph, i, j), joined);
      }
    }
  }
}

TEST(Schur, EliminatesLandmarksFirstThoughSomeAreJoined) {
  const BlockGraph graph(landmarks().pattern);
  const Ordering ordering = chooseOrdering(graph);
  const std::size_t count = independentSet(graph).size();
  EXPECT_GE(count, std::size_t(kLandmarks * 6 / 7));
  EXPECT_LT(count, std::size_t(kLandmarks));
  EXPECT_EQ(ordering.name.find("schur(" + std::to_string(count) + " of 359)+"), 0u)
      << ordering.name;
  const SymbolicFactor symbolic = analyzePattern(landmarks().pattern);
  int absorbed = 0;
  int together = 0;
  for (const Supernode& s : symbolic.supernodes) {
    absorbed += s.absorbed ? 1 : 0;
    together = std::max(together, s.absorbed_children);
  }
  EXPECT_GT(absorbed, kLandmarks / 2);
  EXPECT_GT(together, 128);  // so that threads share them
  EXPECT_LT(symbolic.update_size, symbolic.factor_size / 2);
}

TEST(Schur, LeavesOtherGraphsToTheOtherOrders) {
  const BlockMatrix grid(std::vector<std::int32_t>(400, 3), testing::gridPairs(20), 4);
  EXPECT_EQ(chooseOrdering(BlockGraph(grid.pattern)).name, "amd");
}

/// The system of all solves below, dense.
Eigen::VectorXd denseSolution(const Eigen::VectorXd& damping, const Eigen::VectorXd& b) {
  Eigen::MatrixXd dense = landmarks().dense;
  dense.diagonal() += damping;
  return dense.llt().solve(b);
}

TEST(Schur, SolvesAsADenseFactorisationForAnyThreads) {
  const BlockMatrix& a = landmarks();
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(a.dense.rows(), -1, 2);
  const Eigen::VectorXd damping = 0.3 * Eigen::VectorXd::LinSpaced(a.dense.rows(), 1, 3);
  const Eigen::VectorXd expected = denseSolution(damping, b);
  Eigen::VectorXd reference;
  for (const FrontKernels* kernels : {&frontKernels(), &portableFrontKernels()}) {
    for (const int threads : {1, 2, 4}) {
      ThreadPool pool(threads);
      BlockCholesky cholesky(&pool, *kernels);
      cholesky.analyze(a.pattern);
      Eigen::VectorXd x(b.size());
      // Twice, for the second finds the first one's numbers in memory.
      for (int round = 0; round < 2; ++round) {
        ASSERT_EQ(cholesky.factorize(a.values.data(), damping.data()), -1);
        cholesky.solve(b.data(), x.data());
        EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm());
        if (threads == 1 && round == 0) reference = x;
        EXPECT_TRUE(x == reference);
      }
    }
  }
}

TEST(Schur, NamesTheLandmarkThatIsNotDeterminedForAnyThreads) {
  const BlockMatrix& a = landmarks();
  std::vector<std::int32_t> reference;
  for (const int threads : {1, 2, 4}) {
    ThreadPool pool(threads);
    BlockCholesky cholesky(&pool);
    cholesky.analyze(a.pattern);
    std::vector<std::int32_t> failed;
    for (const int first : {30, 200, 340}) {
      Eigen::VectorXd damping = Eigen::VectorXd::Zero(a.dense.rows());
      damping[a.begin(first)] = -1e9;
      EXPECT_EQ(cholesky.factorize(a.values.data(), damping.data()), first);
      for (const int other : {100, 300}) damping[a.begin(other)] = -1e9;
      failed.push_back(cholesky.factorize(a.values.data(), damping.data()));
    }
    if (threads == 1) reference = failed;
    EXPECT_EQ(failed, reference);
  }
}

TEST(Schur, HasTheInverseOfTheWholeMatrix) {
  const BlockMatrix& a = landmarks();
  const Eigen::MatrixXd inverse =
      a.dense.llt().solve(Eigen::MatrixXd::Identity(a.dense.rows(), a.dense.rows()));
  std::vector<BlockPair> pairs;
  for (std::int32_t i = 0; i < a.pattern.block_count; ++i) {
    pairs.push_back({i, i});
    pairs.push_back({i, (i + 10) % kPoses});
  }
  std::vector<Eigen::MatrixXd> reference;
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    BlockCholesky cholesky(&pool);
    cholesky.analyze(a.pattern);
    ASSERT_EQ(cholesky.factorize(a.values.data(), nullptr), -1);
    const std::vector<Eigen::MatrixXd> blocks = inverseBlocks(cholesky, pairs, &pool);
    if (threads == 1) reference = blocks;
    EXPECT_TRUE(blocks == reference);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Eigen::MatrixXd expected = inverse.block(
          a.begin(pairs[i].row), a.begin(pairs[i].column), blocks[i].rows(), blocks[i].cols());
      EXPECT_LT((blocks[i] - expected).norm(), 1e-12 * inverse.cwiseAbs().maxCoeff());
    }
  }
}

}  // namespace
}  // namespace graft
