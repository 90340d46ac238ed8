// SPDX-License-Identifier: BSD-3-Clause
#include "core/linear/block_cholesky.hpp"

#include <algorithm>
#include <limits>

#include "core/base/per_thread.hpp"

namespace graft {

namespace {

/// A pivot below this share of the diagonal entry it comes from is rounding.
constexpr double kPivotShare = 16 * std::numeric_limits<double>::epsilon();

/// Fronts below this are not worth waking other threads for.
constexpr double kFlopsWorthSharing = 4e6;

/// The same in absorbed leaves of one front, and how many of them a piece of work has.
constexpr std::size_t kLeavesWorthSharing = 128;
constexpr std::int64_t kLeavesPerPiece = 64;

/// Blocks are read in another order than they lie: they are asked for this many earlier.
constexpr std::int64_t kBlocksAhead = 8;

void prefetchBlock(const double* block, int size) {
  constexpr int kLine = 8;  // numbers
  for (int i = 0; i < size; i += kLine) __builtin_prefetch(block + i);
}

/// out (columns kStrip apart) = a block of another layout; Rows > 0 fixes the height.
template <int Rows>
void copyColumns(const double* block, int rows, int columns, int by_row, int by_column,
                 double* out) {
  const int height = Rows > 0 ? Rows : rows;
  for (int c = 0; c < columns; ++c) {
    for (int r = 0; r < height; ++r) out[c * kStrip + r] = block[c * by_column + r * by_row];
  }
}
void copyBlock(const double* block, int rows, int columns, int by_row, int by_column, double* out) {
  if (rows == 6) {
    by_row == 1 ? copyColumns<6>(block, rows, columns, 1, by_column, out)
                : copyColumns<6>(block, rows, columns, by_row, by_column, out);
  } else if (rows == 3) {
    copyColumns<3>(block, rows, columns, by_row, by_column, out);
  } else {
    copyColumns<0>(block, rows, columns, by_row, by_column, out);
  }
}

}  // namespace

void BlockCholesky::analyze(const graft_block_pattern& pattern,
                            const std::vector<std::int32_t>& order) {
  // What is there makes room first.
  factor_ = std::vector<double>();
  updates_ = std::vector<double>();
  symbolic_ = SymbolicFactor();
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
    std::int32_t block = -1;
  };
  std::vector<Failure> failures(symbolic_.tasks.size());
  const auto runTask = [&](std::int64_t task) {
    for (const std::int32_t i : symbolic_.tasks[std::size_t(task)]) {
      if (symbolic_.supernodes[std::size_t(i)].absorbed) continue;
      const std::int32_t bad = factorSupernode(std::size_t(i), values, damping, false);
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
    const Supernode& s = symbolic_.supernodes[std::size_t(i)];
    if (s.task >= 0 || s.absorbed) continue;
    const std::int32_t bad = factorSupernode(std::size_t(i), values, damping, true);
    if (bad >= 0) first = {i, bad};
  }
  return first.block;
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

std::int32_t BlockCholesky::factorColumns(std::size_t index) {
  const Supernode& s = symbolic_.supernodes[index];
  const int bad =
      factorFront(*kernels_, s.columns, s.rowStrips(), thresholds_.data() + s.first_scalar,
                  factor_.data() + s.factor_offset, inverses_.data() + s.first_scalar);
  return bad < 0 ? -1 : blockAt(s, bad);
}

std::int32_t BlockCholesky::factorSupernode(std::size_t index, const double* values,
                                            const double* damping, bool share) {
  const Supernode& s = symbolic_.supernodes[index];
  if (s.absorbed_children > 0) {
    const std::int32_t bad = factorAbsorbed(s, values, damping, share);
    if (bad >= 0) return bad;
  }
  assembleMatrix(index, values, damping);
  if (s.absorbed_children > 0) assembleAbsorbed(s, share);
  for (const std::int32_t c : s.children) {
    const Supernode& child = symbolic_.supernodes[std::size_t(c)];
    if (!child.absorbed) assembleColumns(s, child);
  }
  const std::int32_t bad = factorColumns(index);
  if (bad >= 0 || s.rows == 0) return bad;
  formUpdate(s, share);
  for (const std::int32_t c : s.children) {
    const Supernode& child = symbolic_.supernodes[std::size_t(c)];
    if (!child.absorbed) assembleUpdate(s, child);
  }
  return -1;
}

/// The leaves do not depend on each other; the first that fails in order counts.
std::int32_t BlockCholesky::factorAbsorbed(const Supernode& s, const double* values,
                                           const double* damping, bool share) {
  const auto factorRange = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto child = std::size_t(s.children[i]);
      if (!symbolic_.supernodes[child].absorbed) continue;
      assembleMatrix(child, values, damping);
      const std::int32_t bad = factorColumns(child);
      if (bad >= 0) return bad;
    }
    return std::int32_t{-1};
  };
  const std::size_t count = s.children.size();
  if (!share || pool_ == nullptr || std::size_t(s.absorbed_children) < kLeavesWorthSharing) {
    return factorRange(0, count);
  }
  const std::int64_t pieces = (std::int64_t(count) + kLeavesPerPiece - 1) / kLeavesPerPiece;
  std::vector<std::int32_t> failures(std::size_t(pieces), -1);
  pool_->run(pieces, [&](std::int64_t piece) {
    const auto begin = std::size_t(piece * kLeavesPerPiece);
    failures[std::size_t(piece)] =
        factorRange(begin, std::min(count, begin + std::size_t(kLeavesPerPiece)));
  });
  const auto failed =
      std::find_if(failures.begin(), failures.end(), [](std::int32_t f) { return f >= 0; });
  return failed == failures.end() ? -1 : *failed;
}

/// Adds the updates of the absorbed leaves to the front: every entry in the order of the
/// leaves, for threads have columns of their own.
void BlockCholesky::assembleAbsorbed(const Supernode& s, bool share) {
  std::fill_n(updates_.data() + s.update_offset, std::int64_t{s.rows} * s.updateStride(), 0.0);
  const int width = s.columns + s.rows;
  std::vector<int> cuts = {0};
  if (share && pool_ != nullptr && pool_->threads() > 1 &&
      std::size_t(s.absorbed_children) >= kLeavesWorthSharing) {
    std::vector<std::int64_t> entries(std::size_t(width), 0);
    std::int64_t total = 0;
    for (const std::int32_t c : s.children) {
      const Supernode& child = symbolic_.supernodes[std::size_t(c)];
      if (!child.absorbed) continue;
      for (int i = 0; i < child.rows; ++i) {
        entries[std::size_t(child.in_parent[std::size_t(i)])] += child.rows - i;
      }
      total += std::int64_t{child.rows} * (child.rows + 1) / 2;
    }
    const std::int64_t share_of_piece = total / (4 * pool_->threads()) + 1;
    std::int64_t sum = 0;
    for (int column = 0; column < width; ++column) {
      sum += entries[std::size_t(column)];
      if (sum < share_of_piece) continue;
      cuts.push_back(column + 1);
      sum = 0;
    }
  }
  if (cuts.back() < width) cuts.push_back(width);
  const auto addAll = [&](std::int64_t piece) {
    for (const std::int32_t c : s.children) {
      const Supernode& child = symbolic_.supernodes[std::size_t(c)];
      if (!child.absorbed) continue;
      const auto& places = child.in_parent;
      const auto first = std::lower_bound(places.begin(), places.end(), cuts[std::size_t(piece)]);
      const auto last = std::lower_bound(first, places.end(), cuts[std::size_t(piece) + 1]);
      addAbsorbed(s, child, int(first - places.begin()), int(last - places.begin()));
    }
  };
  const auto pieces = std::int64_t(cuts.size()) - 1;
  if (pieces > 1) {
    pool_->run(pieces, addAll);
  } else {
    addAll(0);
  }
}

/// Adds columns begin .. end of a leaf's -L21 L21', lower triangle, to the front.
void BlockCholesky::addAbsorbed(const Supernode& s, const Supernode& child, int begin, int end) {
  const std::int64_t stride = std::int64_t{kStrip} * child.columns;
  const double* rows = factor_.data() + child.factor_offset + child.columnStrips() * stride;
  const std::int32_t* in_parent = child.in_parent.data();
  static PerThread<std::vector<double>> products;
  static PerThread<std::vector<std::int64_t>> all_places;
  std::vector<double>& product = products.get();
  std::vector<std::int64_t>& places = all_places.get();
  product.resize(std::size_t(child.updateStride()) * kStrip);
  places.resize(std::size_t(child.rows));
  for (int i = begin; i < child.rows; ++i) {
    places[std::size_t(i)] = s.stripOffset(in_parent[i]);
  }
  for (int first = begin; first < end;) {
    const int strip = first / kStrip;
    const int last = std::min(end, (strip + 1) * kStrip);
    for (int i = strip; i < child.rowStrips(); ++i) {
      kernels_->negateProduct(child.columns, rows + i * stride,
                              rows + strip * stride + first % kStrip, last - first,
                              product.data() + i * kStrip, child.updateStride());
    }
    for (int j = first; j < last; ++j) {
      const double* in = product.data() + std::int64_t{j - first} * child.updateStride();
      const int column = in_parent[j];
      if (column < s.columns) {
        double* out = factor_.data() + s.factor_offset + std::int64_t{column} * kStrip;
        for (int i = j; i < child.rows; ++i) out[places[std::size_t(i)]] += in[i];
      } else {
        double* out = updates_.data() + s.update_offset +
                      std::int64_t{column - s.columns} * s.updateStride() - s.columns;
        for (int i = j; i < child.rows; ++i) out[in_parent[i]] += in[i];
      }
    }
    first = last;
  }
}

/// The update matrix -L21 L21', lower triangle; what absorbed leaves left there stays.
void BlockCholesky::formUpdate(const Supernode& s, bool share) {
  const std::int64_t stride = std::int64_t{kStrip} * s.columns;
  const double* rows = factor_.data() + s.factor_offset + s.columnStrips() * stride;
  double* update = updates_.data() + s.update_offset;
  const auto product =
      s.absorbed_children > 0 ? kernels_->subtractProduct : kernels_->negateProduct;
  const auto formColumns = [&](std::int64_t j) {
    const int width = int(std::min<std::int64_t>(kStrip, s.rows - j * kStrip));
    double* columns = update + j * kStrip * s.updateStride();
    for (std::int64_t i = j; i < s.rowStrips(); ++i) {
      product(s.columns, rows + i * stride, rows + j * stride, width, columns + i * kStrip,
              s.updateStride());
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
    if (t + kBlocksAhead < std::int64_t(symbolic_.targets.size())) {
      const BlockTarget& later = symbolic_.targets[std::size_t(t + kBlocksAhead)];
      prefetchBlock(values + later.values, later.rows * later.columns);
    }
    const int height = target.transposed ? target.columns : target.rows;
    const int width = target.transposed ? target.rows : target.columns;
    const int by_row = target.transposed ? target.rows : 1;
    const int by_column = target.transposed ? 1 : target.rows;
    for (int r = 0; r < height;) {  // a part for every strip
      const std::int64_t place = s.stripOffset(target.local_row + r);
      const int part = std::min(height - r, kStrip - int(place % kStrip));
      double* out = strips + place + std::int64_t{target.local_column} * kStrip;
      copyBlock(block + r * by_row, part, width, by_row, by_column, out);
      r += part;
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
      const std::int32_t* scalars = s.row_scalars.data() + row;
      for (int r = 0; r < width; ++r) y[std::size_t(scalars[r])] -= sums[r];
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
      const std::int32_t* scalars = s.row_scalars.data() + row;
      for (int r = 0; r < width; ++r) sums[r] = y[std::size_t(scalars[r])];
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
