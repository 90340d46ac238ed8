// SPDX-License-Identifier: BSD-3-Clause
#include "core/linear/selected_inverse.hpp"

#include <algorithm>
#include <atomic>
#include <memory>
#include <numeric>

#include "core/base/memory.hpp"

namespace graft {

namespace {

/// Products with fewer multiplications are not worth waking other threads for.
constexpr double kProductsWorthSharing = 4e6;

/// Leaves of one front that a thread takes at a time.
constexpr std::size_t kLeavesPerPiece = 64;

/// Nanoseconds, roughly: only their ratio matters, to choose between recurrences and
/// solutions with unit vectors, which read the whole factor twice.
constexpr double kPerProduct = 1.0 / 12;
constexpr double kPerFront = 500;
constexpr double kPerFactorEntry = 1.5;

/// Room for the parts of one front; k columns, m rows. By strips as in the factor.
struct Workspace {
  std::vector<double> roots;     ///< -inv(L11)', k x k
  std::vector<double> weights;   ///< W' = (L21 inv(L11))', k x m
  std::vector<double> rows;      ///< Z22, m x m, both triangles
  std::vector<double> coupling;  ///< Z12 = -W' Z22, k x m
  std::vector<double> columns;   ///< Z11 = inv(L11 L11') + W' Z22 W, k x k, lower triangle
  std::vector<std::int64_t> places;
};

class Inversion {
 public:
  Inversion(const BlockCholesky& cholesky, const std::vector<BlockPair>& pairs, ThreadPool* pool)
      : cholesky_(cholesky),
        symbolic_(cholesky.symbolic()),
        kernels_(cholesky.kernels()),
        pairs_(pairs),
        pool_(pool),
        results_(pairs.size()) {}

  std::vector<Eigen::MatrixXd> run() {
    assignPairs();
    if (recurrencesAreCheaper()) {
      recur();
    } else {
      for (auto& list : wanted_) {
        unassigned_.insert(unassigned_.end(), list.begin(), list.end());
      }
    }
    solveUnassigned();
    return std::move(results_);
  }

 private:
  const std::vector<std::int32_t>& dims() const { return cholesky_.dims(); }
  std::int64_t scalarOf(std::int32_t block) const {
    return symbolic_.scalar_position[std::size_t(block)];
  }

  /// Local number of a scalar position in a front, or -1.
  static std::int64_t localOf(const Supernode& s, std::int64_t position) {
    if (position < s.first_scalar + s.columns) return position - s.first_scalar;
    const auto row = std::lower_bound(s.row_scalars.begin(), s.row_scalars.end(), position);
    if (row == s.row_scalars.end() || *row != position) return -1;
    return row - s.row_scalars.begin() + s.columns;
  }

  /// Every pair goes to the front whose columns hold the block that comes first.
  void assignPairs() {
    const std::size_t count = symbolic_.supernodes.size();
    std::vector<std::int32_t> owner(symbolic_.blocks.size());
    for (std::size_t k = 0; k < count; ++k) {
      const Supernode& s = symbolic_.supernodes[k];
      for (std::int32_t p = s.first_block; p < s.last_block; ++p) {
        owner[std::size_t(symbolic_.blocks[std::size_t(p)])] = std::int32_t(k);
      }
    }
    wanted_.resize(count);
    pending_ = std::make_unique<std::atomic<std::int32_t>[]>(count);
    needed_.assign(count, 0);
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const bool swapped = scalarOf(pairs_[i].row) < scalarOf(pairs_[i].column);
      const std::int32_t first = swapped ? pairs_[i].row : pairs_[i].column;
      const std::int32_t second = swapped ? pairs_[i].column : pairs_[i].row;
      const auto k = std::size_t(owner[std::size_t(first)]);
      if (localOf(symbolic_.supernodes[k], scalarOf(second)) < 0) {
        unassigned_.push_back(i);
        continue;
      }
      wanted_[k].push_back(i);
      needed_[k] = 1;
    }
    for (std::size_t k = 0; k < count; ++k) {
      pending_[k] = 0;
    }
    for (std::size_t k = 0; k < count; ++k) {
      const std::int32_t parent = symbolic_.supernodes[k].parent;
      if (needed_[k] == 0 || parent < 0) continue;
      needed_[std::size_t(parent)] = 1;
      ++pending_[std::size_t(parent)];
    }
  }

  bool recurrencesAreCheaper() const {
    double recurrences = 0;
    for (std::size_t k = 0; k < needed_.size(); ++k) {
      if (needed_[k] == 0) continue;
      const Supernode& s = symbolic_.supernodes[k];
      const double columns = s.columns;
      const double all = columns + s.rows;
      recurrences += kPerFront + kPerProduct * columns * all * all + all * all;
    }
    std::vector<std::int32_t> blocks;
    for (const auto& list : wanted_) {
      for (const std::size_t i : list) blocks.push_back(pairs_[i].column);
    }
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    double solutions = 0;
    for (const std::int32_t block : blocks) {
      solutions +=
          dims()[std::size_t(block)] * (kPerFactorEntry * double(symbolic_.factor_size) +
                                        kPerFront / 4 * double(symbolic_.supernodes.size()));
    }
    return recurrences < solutions;
  }

  /// Fronts are kept while children are to come, at most along a path from a root; with
  /// what the largest one needs beside.
  double bytesOfFronts() const {
    std::vector<std::int32_t> pending;
    for (std::size_t k = 0; k < needed_.size(); ++k) pending.push_back(pending_[k]);
    double live = 0;
    double peak = 0;
    for (std::size_t k = needed_.size(); k-- > 0;) {
      if (needed_[k] == 0) continue;
      const Supernode& s = symbolic_.supernodes[k];
      const double size = entriesOf(s);
      peak = std::max(peak, live + 2 * size);
      if (pending[k] > 0) live += size;
      if (s.parent < 0 || --pending[std::size_t(s.parent)] > 0) continue;
      live -= entriesOf(symbolic_.supernodes[std::size_t(s.parent)]);
    }
    return peak * sizeof(double);
  }
  static double entriesOf(const Supernode& s) {
    const double height = double(s.columns) + s.rows;
    return height * height;
  }

  void recur() {
    requireMemory(bytesOfFronts(), "the inverse on the fronts of the factor");
    fronts_.resize(symbolic_.supernodes.size());
    Workspace own;
    for (std::size_t k = symbolic_.supernodes.size(); k-- > 0;) {
      const Supernode& s = symbolic_.supernodes[k];
      if (s.task < 0 && needed_[k] != 0 && !s.absorbed) invertWithLeaves(k, own, true);
    }
    const auto runTask = [&](std::int64_t task) {
      Workspace workspace;
      const auto& list = symbolic_.tasks[std::size_t(task)];
      for (auto k = list.rbegin(); k != list.rend(); ++k) {
        const auto index = std::size_t(*k);
        if (needed_[index] == 0 || symbolic_.supernodes[index].absorbed) continue;
        invertWithLeaves(index, workspace, false);
      }
    };
    const auto tasks = std::int64_t(symbolic_.tasks.size());
    if (pool_ != nullptr && tasks > 0) {
      pool_->run(tasks, runTask);
    } else {
      for (std::int64_t task = 0; task < tasks; ++task) runTask(task);
    }
  }

  /// Calls body for every strip, on all threads where that is worth it.
  template <class Body>
  void overStrips(int strips, double products, bool share, const Body& body) {
    if (share && pool_ != nullptr && products > kProductsWorthSharing) {
      pool_->run(strips, body);
    } else {
      for (int i = 0; i < strips; ++i) body(i);
    }
  }

  /// A front and then the absorbed leaves under it, for many threads.
  void invertWithLeaves(std::size_t index, Workspace& w, bool share) {
    invert(index, w, share);
    const Supernode& s = symbolic_.supernodes[index];
    if (s.absorbed_children == 0) return;
    std::vector<std::size_t> leaves;
    for (const std::int32_t c : s.children) {
      const auto child = std::size_t(c);
      if (needed_[child] != 0 && symbolic_.supernodes[child].absorbed) leaves.push_back(child);
    }
    const auto invertRange = [&](std::size_t begin, std::size_t end, Workspace& workspace) {
      for (std::size_t i = begin; i < end; ++i) invert(leaves[i], workspace, false);
    };
    if (!share || pool_ == nullptr || leaves.size() <= kLeavesPerPiece) {
      return invertRange(0, leaves.size(), w);
    }
    const std::size_t pieces = (leaves.size() + kLeavesPerPiece - 1) / kLeavesPerPiece;
    pool_->run(std::int64_t(pieces), [&](std::int64_t piece) {
      Workspace own;
      const std::size_t begin = std::size_t(piece) * kLeavesPerPiece;
      invertRange(begin, std::min(leaves.size(), begin + kLeavesPerPiece), own);
    });
  }

  /// The inverse on the front of one supernode, given that of its parent.
  void invert(std::size_t index, Workspace& w, bool share) {
    const Supernode& s = symbolic_.supernodes[index];
    const int k = s.columns;
    const int m = s.rows;
    const double all = double(k) + m;
    invertRoots(s, w);
    if (m > 0) {
      gatherRows(s, w);
      const double* below =
          cholesky_.factor().data() + s.factor_offset + s.columnStrips() * std::int64_t{kStrip} * k;
      w.weights.resize(std::size_t(s.columnStrips()) * kStrip * std::size_t(m));
      w.coupling.resize(w.weights.size());
      overStrips(s.columnStrips(), double(m) * all * k, share, [&](std::int64_t i) {
        const std::int64_t skip = i * kStrip * kStrip;  // inv(L11)' is an upper triangle
        const double* roots = w.roots.data() + i * kStrip * k + skip;
        double* weights = w.weights.data() + i * kStrip * m;
        for (int r = 0; r < m; r += kStrip) {
          kernels_.negateProduct(k - int(i) * kStrip, roots, below + std::int64_t{r} * k + skip,
                                 std::min(kStrip, m - r), weights + r * kStrip, kStrip);
        }
        for (int r = 0; r < m; r += kStrip) {
          kernels_.negateProduct(m, weights, w.rows.data() + std::int64_t{r} * m,
                                 std::min(kStrip, m - r),
                                 w.coupling.data() + i * kStrip * m + r * kStrip, kStrip);
        }
      });
    }
    w.columns.resize(std::size_t(s.columnStrips()) * kStrip * std::size_t(k));
    overStrips(s.columnStrips(), double(k) * all * k, share, [&](std::int64_t i) {
      double* out = w.columns.data() + i * kStrip * k;
      const std::int64_t skip = i * kStrip * kStrip;
      for (int j = 0; j < std::min(k, int(i + 1) * kStrip); j += kStrip) {
        const int width = std::min(kStrip, k - j);
        double* tile = out + j * kStrip;
        kernels_.negateProduct(k - int(i) * kStrip, w.roots.data() + i * kStrip * k + skip,
                               w.roots.data() + std::int64_t{j} * k + skip, width, tile, kStrip);
        for (int e = 0; e < width * kStrip; ++e) tile[e] = 0.0 - tile[e];  // not -0
        if (m == 0) continue;
        kernels_.subtractProduct(m, w.coupling.data() + i * kStrip * m,
                                 w.weights.data() + std::int64_t{j} * m, width, tile, kStrip);
      }
    });
    for (const std::size_t pair : wanted_[index]) extract(s, w, pair);
    if (pending_[index] > 0) keepFront(s, w, fronts_[index]);
    if (s.parent >= 0 && --pending_[std::size_t(s.parent)] == 0) {
      std::vector<double>().swap(fronts_[std::size_t(s.parent)]);
    }
  }

  /// -inv(L11)' by the same tiles as the rows of a factor: -I inv(L11)'.
  void invertRoots(const Supernode& s, Workspace& w) const {
    const int k = s.columns;
    const std::int64_t stride = std::int64_t{kStrip} * k;
    w.roots.assign(std::size_t(s.columnStrips()) * std::size_t(stride), 0.0);
    const double* strips = cholesky_.factor().data() + s.factor_offset;
    const double* inverses = cholesky_.inverses().data() + s.first_scalar;
    for (int i = 0; i < s.columnStrips(); ++i) {
      const int first = i * kStrip;
      double* row = w.roots.data() + i * stride;
      for (int r = 0; r < std::min(kStrip, k - first); ++r) row[(first + r) * kStrip + r] = -1;
      for (int begin = first; begin < k; begin += kStrip) {
        const double* own = strips + std::int64_t{begin} * k;
        const int width = std::min(kStrip, k - begin);
        double* c = row + begin * kStrip;
        if (begin > first) {
          kernels_.subtractProduct(begin - first, row + first * kStrip, own + first * kStrip, width,
                                   c, kStrip);
        }
        kernels_.solveTile(width, own + begin * kStrip, inverses + begin, c);
      }
    }
  }

  /// Z22 out of the front of the parent, which holds all these rows.
  void gatherRows(const Supernode& s, Workspace& w) const {
    const int m = s.rows;
    const Supernode& parent = symbolic_.supernodes[std::size_t(s.parent)];
    const std::vector<double>& front = fronts_[std::size_t(s.parent)];
    const std::int64_t height = parent.columns + parent.rows;
    w.rows.assign(std::size_t(s.rowStrips()) * kStrip * std::size_t(m), 0.0);
    w.places.resize(std::size_t(m));
    for (int i = 0; i < m; ++i) {
      w.places[std::size_t(i)] = std::int64_t{i / kStrip} * kStrip * m + i % kStrip;
    }
    const std::int32_t* in_parent = s.in_parent.data();
    for (int j = 0; j < m; ++j) {
      const double* in = front.data() + in_parent[j] * height;
      double* column = w.rows.data() + std::int64_t{j} * kStrip;
      double* row = w.rows.data() + w.places[std::size_t(j)];
      for (int i = j; i < m; ++i) {
        const double value = in[in_parent[i]];
        column[w.places[std::size_t(i)]] = value;
        row[std::int64_t{i} * kStrip] = value;
      }
    }
  }

  /// The lower triangle of the whole front, for the children.
  static void keepFront(const Supernode& s, const Workspace& w, std::vector<double>& front) {
    const int k = s.columns;
    const int m = s.rows;
    const std::int64_t height = std::int64_t{k} + m;
    front.resize(std::size_t(height * height));
    for (int j = 0; j < k; ++j) {
      double* out = front.data() + j * height;
      for (int i = j; i < k; ++i) out[i] = columnsEntry(s, w, i, j);
      const double* in = w.coupling.data() + std::int64_t{j / kStrip} * kStrip * m + j % kStrip;
      for (int i = 0; i < m; ++i) out[k + i] = in[std::int64_t{i} * kStrip];
    }
    for (int j = 0; j < m; ++j) {
      double* out = front.data() + (k + j) * height + k;
      const double* in = w.rows.data() + std::int64_t{j} * kStrip;
      for (int i = j; i < m; ++i) out[i] = in[w.places[std::size_t(i)]];
    }
  }

  static double columnsEntry(const Supernode& s, const Workspace& w, std::int64_t i,
                             std::int64_t j) {
    return w.columns[std::size_t((i / kStrip) * kStrip * s.columns + j * kStrip + i % kStrip)];
  }

  void extract(const Supernode& s, const Workspace& w, std::size_t pair) {
    const auto [row, column] = pairs_[pair];
    Eigen::MatrixXd& out = results_[pair];
    out.resize(dims()[std::size_t(row)], dims()[std::size_t(column)]);
    const std::int64_t first_row = localOf(s, scalarOf(row));
    const std::int64_t first_column = localOf(s, scalarOf(column));
    for (Eigen::Index c = 0; c < out.cols(); ++c) {
      for (Eigen::Index r = 0; r < out.rows(); ++r) {
        const std::int64_t i = std::max(first_row + r, first_column + c);
        const std::int64_t j = std::min(first_row + r, first_column + c);
        out(r, c) = i < s.columns ? columnsEntry(s, w, i, j)
                                  : w.coupling[std::size_t((j / kStrip) * kStrip * s.rows +
                                                           (i - s.columns) * kStrip + j % kStrip)];
      }
    }
  }

  /// Columns of the inverse by solving, each once.
  void solveUnassigned() {
    const auto byColumn = [&](std::size_t a, std::size_t b) {
      return pairs_[a].column != pairs_[b].column ? pairs_[a].column < pairs_[b].column : a < b;
    };
    std::sort(unassigned_.begin(), unassigned_.end(), byColumn);
    std::vector<std::size_t> begin;
    for (std::size_t i = 0; i < unassigned_.size(); ++i) {
      if (i == 0 || pairs_[unassigned_[i]].column != pairs_[unassigned_[i - 1]].column) {
        begin.push_back(i);
      }
    }
    begin.push_back(unassigned_.size());
    const auto solveColumn = [&](std::int64_t piece) {
      const auto first = begin[std::size_t(piece)];
      const auto last = begin[std::size_t(piece) + 1];
      const auto column = std::size_t(pairs_[unassigned_[first]].column);
      Eigen::VectorXd unit = Eigen::VectorXd::Zero(symbolic_.dim);
      Eigen::VectorXd solution(symbolic_.dim);
      for (int c = 0; c < dims()[column]; ++c) {
        const std::int64_t entry = cholesky_.offsets()[column] + c;
        unit[entry] = 1;
        cholesky_.solve(unit.data(), solution.data());
        unit[entry] = 0;
        for (std::size_t i = first; i < last; ++i) {
          const auto row = std::size_t(pairs_[unassigned_[i]].row);
          Eigen::MatrixXd& out = results_[unassigned_[i]];
          out.conservativeResize(dims()[row], dims()[column]);
          out.col(c) = solution.segment(cholesky_.offsets()[row], dims()[row]);
        }
      }
    };
    const auto count = std::int64_t(begin.size()) - 1;
    if (pool_ != nullptr && count > 1) {
      pool_->run(count, solveColumn);
    } else {
      for (std::int64_t piece = 0; piece < count; ++piece) solveColumn(piece);
    }
  }

  const BlockCholesky& cholesky_;
  const SymbolicFactor& symbolic_;
  const FrontKernels& kernels_;
  const std::vector<BlockPair>& pairs_;
  ThreadPool* pool_;
  std::vector<Eigen::MatrixXd> results_;
  std::vector<std::vector<std::size_t>> wanted_;  ///< pairs by supernode
  std::vector<std::size_t> unassigned_;           ///< pairs outside the factor's pattern
  std::vector<std::uint8_t> needed_;
  std::unique_ptr<std::atomic<std::int32_t>[]> pending_;  ///< needed children to come
  std::vector<std::vector<double>> fronts_;               ///< while children are to come
};

}  // namespace

std::vector<Eigen::MatrixXd> inverseBlocks(const BlockCholesky& cholesky,
                                           const std::vector<BlockPair>& pairs, ThreadPool* pool) {
  return Inversion(cholesky, pairs, pool).run();
}

}  // namespace graft
