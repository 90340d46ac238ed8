// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/block_cholesky.hpp"

#include <algorithm>
#include <limits>

namespace graft {

namespace {

/// A pivot below this share of the diagonal entry it comes from is rounding.
constexpr double kPivotShare = 16 * std::numeric_limits<double>::epsilon();

/// Fronts below this are not worth waking other threads for.
constexpr double kFlopsWorthSharing = 4e6;

}  // namespace

void BlockCholesky::analyze(const graft_block_pattern& pattern,
                            const std::vector<std::int32_t>& order) {
  symbolic_ = analyzePattern(pattern, pool_ != nullptr && pool_->threads() > 1, order);
  dims_.assign(pattern.dims, pattern.dims + pattern.block_count);
  offsets_.assign(1, 0);
  for (const std::int32_t dim : dims_) offsets_.push_back(offsets_.back() + dim);
  factor_.resize(std::size_t(symbolic_.factor_size));
  updates_.resize(std::size_t(symbolic_.update_size));
  inverses_.resize(std::size_t(symbolic_.dim));
  thresholds_.resize(std::size_t(symbolic_.dim));
}

std::int32_t BlockCholesky::factorize(const double* values, const double* damping) {
  struct Failure {
    std::int32_t supernode = std::numeric_limits<std::int32_t>::max();
    int column = -1;
  };
  std::vector<Failure> failures(symbolic_.tasks.size());
  const auto runTask = [&](std::int64_t task) {
    for (const std::int32_t i : symbolic_.tasks[std::size_t(task)]) {
      const int bad = factorSupernode(std::size_t(i), values, damping, false);
      if (bad < 0) continue;
      failures[std::size_t(task)] = {i, bad};
      return;
    }
  };
  if (!symbolic_.tasks.empty()) pool_->run(std::int64_t(symbolic_.tasks.size()), runTask);
  // The first failure in order is the same for any number of threads.
  Failure first;
  for (const Failure& failure : failures) {
    if (failure.supernode < first.supernode) first = failure;
  }
  const auto count = std::int32_t(symbolic_.supernodes.size());
  for (std::int32_t i = 0; i < std::min(count, first.supernode); ++i) {
    if (symbolic_.supernodes[std::size_t(i)].task >= 0) continue;
    const int bad = factorSupernode(std::size_t(i), values, damping, true);
    if (bad >= 0) first = {i, bad};
  }
  if (first.column < 0) return -1;
  return blockAt(symbolic_.supernodes[std::size_t(first.supernode)], first.column);
}

std::int32_t BlockCholesky::blockAt(const Supernode& s, int column) const {
  std::int32_t position = s.first_block;
  for (; position < s.last_block; ++position) {
    const std::int32_t block = symbolic_.blocks[std::size_t(position)];
    column -= dims_[std::size_t(block)];
    if (column < 0) return block;
  }
  return -1;
}

int BlockCholesky::factorSupernode(std::size_t index, const double* values, const double* damping,
                                   bool share) {
  const Supernode& s = symbolic_.supernodes[index];
  assembleMatrix(index, values, damping);
  for (const std::int32_t c : s.children) {
    assembleColumns(s, symbolic_.supernodes[std::size_t(c)]);
  }
  double* strips = factor_.data() + s.factor_offset;
  const int bad =
      factorFront(*kernels_, s.columns, s.rowStrips(), thresholds_.data() + s.first_scalar, strips,
                  inverses_.data() + s.first_scalar);
  if (bad >= 0 || s.rows == 0) return bad;
  formUpdate(s, share);
  for (const std::int32_t c : s.children) {
    assembleUpdate(s, symbolic_.supernodes[std::size_t(c)]);
  }
  return -1;
}

/// The update matrix -L21 L21', lower triangle.
void BlockCholesky::formUpdate(const Supernode& s, bool share) {
  const std::int64_t stride = std::int64_t{kStrip} * s.columns;
  const double* rows = factor_.data() + s.factor_offset + s.columnStrips() * stride;
  double* update = updates_.data() + s.update_offset;
  const auto formColumns = [&](std::int64_t j) {
    const int width = int(std::min<std::int64_t>(kStrip, s.rows - j * kStrip));
    double* columns = update + j * kStrip * s.updateStride();
    for (std::int64_t i = j; i < s.rowStrips(); ++i) {
      kernels_->negateProduct(s.columns, rows + i * stride, rows + j * stride, width,
                              columns + i * kStrip, s.updateStride());
    }
  };
  if (share && pool_ != nullptr && double(s.rows) * s.rows * s.columns > kFlopsWorthSharing) {
    pool_->run(s.rowStrips(), formColumns);
  } else {
    for (std::int64_t j = 0; j < s.rowStrips(); ++j) formColumns(j);
  }
}

void BlockCholesky::assembleMatrix(std::size_t index, const double* values, const double* damping) {
  const Supernode& s = symbolic_.supernodes[index];
  double* strips = factor_.data() + s.factor_offset;
  std::fill_n(strips, std::int64_t{s.columnStrips() + s.rowStrips()} * kStrip * s.columns, 0.0);
  for (std::int64_t t = symbolic_.target_begin[index]; t < symbolic_.target_begin[index + 1]; ++t) {
    const BlockTarget& target = symbolic_.targets[std::size_t(t)];
    const double* block = values + target.values;
    if (target.transposed) {
      for (int r = 0; r < target.columns; ++r) {
        double* row = strips + s.stripOffset(target.local_row + r);
        for (int c = 0; c < target.rows; ++c) {
          row[(target.local_column + c) * kStrip] = block[r * target.rows + c];
        }
      }
    } else {
      for (int r = 0; r < target.rows; ++r) {
        double* row = strips + s.stripOffset(target.local_row + r);
        for (int c = 0; c < target.columns; ++c) {
          row[(target.local_column + c) * kStrip] = block[c * target.rows + r];
        }
      }
    }
  }
  int column = 0;
  for (std::int32_t p = s.first_block; p < s.last_block; ++p) {
    const auto block = std::size_t(symbolic_.blocks[std::size_t(p)]);
    for (int c = 0; c < dims_[block]; ++c, ++column) {
      double& entry = strips[s.stripOffset(column) + column * kStrip];
      if (damping != nullptr) entry += damping[offsets_[block] + c];
      thresholds_[std::size_t(s.first_scalar + column)] = std::max(0.0, kPivotShare * entry);
    }
  }
}

void BlockCholesky::assembleColumns(const Supernode& s, const Supernode& child) {
  double* strips = factor_.data() + s.factor_offset;
  const double* update = updates_.data() + child.update_offset;
  static PerThread<std::vector<std::int64_t>> all_places;
  std::vector<std::int64_t>& places = all_places.get();
  places.resize(std::size_t(child.rows));
  for (int i = 0; i < child.rows; ++i) {
    places[std::size_t(i)] = s.stripOffset(child.in_parent[std::size_t(i)]);
  }
  for (int j = 0; j < child.rows; ++j) {
    const int column = child.in_parent[std::size_t(j)];
    if (column >= s.columns) break;
    double* out = strips + column * kStrip;
    const double* in = update + std::int64_t{j} * child.updateStride();
    for (int i = j; i < child.rows; ++i) out[places[std::size_t(i)]] += in[i];
  }
}

void BlockCholesky::assembleUpdate(const Supernode& s, const Supernode& child) {
  const double* update = updates_.data() + child.update_offset;
  const std::int32_t* places = child.in_parent.data();
  int first = 0;
  while (first < child.rows && places[first] < s.columns) ++first;
  for (int j = first; j < child.rows; ++j) {
    double* out = updates_.data() + s.update_offset +
                  std::int64_t{places[j] - s.columns} * s.updateStride() - s.columns;
    const double* in = update + std::int64_t{j} * child.updateStride();
    for (int i = j; i < child.rows; ++i) out[places[i]] += in[i];
  }
}

void BlockCholesky::solve(const double* b, double* x) const {
  std::vector<double> y(std::size_t(symbolic_.dim) + kStrip);
  for (std::size_t block = 0; block < dims_.size(); ++block) {
    std::copy(b + offsets_[block], b + offsets_[block + 1],
              y.begin() + symbolic_.scalar_position[block]);
  }
  double sums[kStrip];
  for (const Supernode& s : symbolic_.supernodes) {
    const std::int64_t stride = std::int64_t{kStrip} * s.columns;
    const double* strip = factor_.data() + s.factor_offset;
    const double* inverses = inverses_.data() + s.first_scalar;
    double* own = y.data() + s.first_scalar;
    for (int begin = 0; begin < s.columns; begin += kStrip, strip += stride) {
      const int width = std::min(kStrip, s.columns - begin);
      kernels_->multiply(begin, strip, own, sums);
      for (int c = 0; c < width; ++c) {
        const double* column = strip + (begin + c) * kStrip;
        own[begin + c] = (own[begin + c] - sums[c]) * inverses[begin + c];
        for (int r = c + 1; r < width; ++r) sums[r] += column[r] * own[begin + c];
      }
    }
    for (int row = 0; row < s.rows; row += kStrip, strip += stride) {
      kernels_->multiply(s.columns, strip, own, sums);
      const int width = std::min(kStrip, s.rows - row);
      for (int r = 0; r < width; ++r)
        y[std::size_t(s.row_scalars[std::size_t(row + r)])] -= sums[r];
    }
  }
  for (auto it = symbolic_.supernodes.rbegin(); it != symbolic_.supernodes.rend(); ++it) {
    const Supernode& s = *it;
    const std::int64_t stride = std::int64_t{kStrip} * s.columns;
    const double* strips = factor_.data() + s.factor_offset;
    const double* inverses = inverses_.data() + s.first_scalar;
    double* own = y.data() + s.first_scalar;
    const double* strip = strips + s.columnStrips() * stride;
    for (int row = 0; row < s.rows; row += kStrip, strip += stride) {
      const int width = std::min(kStrip, s.rows - row);
      std::fill(sums, sums + kStrip, 0.0);
      for (int r = 0; r < width; ++r) sums[r] = y[std::size_t(s.row_scalars[std::size_t(row + r)])];
      kernels_->subtractTransposed(s.columns, strip, sums, own);
    }
    for (int index = s.columnStrips() - 1; index >= 0; --index) {
      const int begin = index * kStrip;
      const int width = std::min(kStrip, s.columns - begin);
      strip = strips + index * stride;
      std::fill(sums, sums + kStrip, 0.0);
      for (int c = width - 1; c >= 0; --c) {
        const double* column = strip + (begin + c) * kStrip;
        double value = own[begin + c];
        for (int r = c + 1; r < width; ++r) value -= column[r] * sums[r];
        own[begin + c] = sums[c] = value * inverses[begin + c];
      }
      kernels_->subtractTransposed(begin, strip, sums, own);
    }
  }
  for (std::size_t block = 0; block < dims_.size(); ++block) {
    const auto first = y.begin() + symbolic_.scalar_position[block];
    std::copy(first, first + dims_[block], x + offsets_[block]);
  }
}

}  // namespace graft
