// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <random>
#include <set>
#include <vector>

#include "core/types/abi.h"

namespace graft::testing {

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
    for (const int dim : dims) begin_.push_back(begin_.back() + dim);
    dense = Eigen::MatrixXd::Zero(begin_.back(), begin_.back());
    const auto fill = [&](int i, int j) {
      for (int r = begin_[std::size_t(i)]; r < begin_[std::size_t(i) + 1]; ++r) {
        for (int c = begin_[std::size_t(j)]; c < begin_[std::size_t(j) + 1]; ++c) {
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
        const Eigen::MatrixXd block = dense.block(begin_[std::size_t(i)], begin_[std::size_t(j)],
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

  /// First scalar row of a block.
  int begin(std::int32_t block) const { return begin_[std::size_t(block)]; }

 private:
  std::vector<int> begin_ = {0};
};

/// Dimensions from 1 to 7.
inline std::vector<std::int32_t> mixedDims(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<std::int32_t> dims;
  for (int i = 0; i < count; ++i) dims.push_back(std::int32_t(random() % 7) + 1);
  return dims;
}

/// Pairs of neighbours on a square grid.
inline std::set<std::pair<int, int>> gridPairs(int side) {
  std::set<std::pair<int, int>> grid;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      if (i > 0) grid.insert({side * (i - 1) + j, side * i + j});
      if (j > 0) grid.insert({side * i + j - 1, side * i + j});
    }
  }
  return grid;
}

/// Blocks 0 .. poses - 1 form a chain, all others are seen by some of them; every seventh
/// of those is also joined to the one before it, as an edge of three blocks does it.
inline std::set<std::pair<int, int>> landmarkPairs(int poses, int landmarks, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::set<std::pair<int, int>> pairs;
  for (int i = 1; i < poses; ++i) pairs.insert({i - 1, i});
  for (int j = poses; j < poses + landmarks; ++j) {
    const int first = int(random() % std::uint64_t(poses));
    for (int k = 0; k < 2 + j % 4; ++k) pairs.insert({(first + 2 * k) % poses, j});
    if (j % 7 == 0 && j > poses) pairs.insert({j - 1, j});
  }
  return pairs;
}

/// Dimension 6 for the poses of these, 3 for the others.
inline std::vector<std::int32_t> landmarkDims(int poses, int landmarks) {
  std::vector<std::int32_t> dims(std::size_t(poses), 6);
  dims.resize(std::size_t(poses + landmarks), 3);
  return dims;
}

/// `count` random pairs of n blocks.
inline std::set<std::pair<int, int>> randomPairs(int n, int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::set<std::pair<int, int>> pairs;
  for (int k = 0; k < count; ++k) {
    const int i = int(random() % std::uint64_t(n));
    const int j = int(random() % std::uint64_t(n));
    if (i != j) pairs.insert({std::min(i, j), std::max(i, j)});
  }
  return pairs;
}

}  // namespace graft::testing
