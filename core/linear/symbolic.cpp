// SPDX-License-Identifier: BSD-3-Clause
#include "core/linear/symbolic.hpp"

#include <algorithm>
#include <numeric>

#include "core/base/memory.hpp"

namespace graft {

namespace {

using Index = std::int32_t;

/// Below this a factorisation is over before threads are awake.
constexpr double kFlopsWorthThreads = 3e6;

/// Small leaves under one front, from which on they have no update matrices.
constexpr std::ptrdiff_t kLeavesWorthAbsorbing = 8;

/// Nanoseconds that a front of k columns and m rows takes, roughly: what it
/// costs to begin one, to move its numbers, and to compute (on whole strips).
/// Only ratios matter, and those only for how much is merged.
double frontCost(double k, double m) {
  constexpr double kPerFront = 300;
  constexpr double kPerFactorEntry = 0.3;
  constexpr double kPerUpdateEntry = 0.6;
  constexpr double kPerFlop = 1.0 / 24;
  const double ks = stripsOf(int(k)) * kStrip;
  const double ms = stripsOf(int(m)) * kStrip;
  const double flops = ks * ks * k / 3 + ms * k * k + ms * ms * k;
  return kPerFront + kPerFactorEntry * (ks + ms) * k + kPerUpdateEntry * m * m / 2 +
         kPerFlop * flops;
}

/// A supernode while supernodes are being merged. Columns and rows are positions
/// of the order before merging.
struct Node {
  std::vector<Index> columns;
  std::vector<Index> rows;
  std::vector<Index> children;
  double column_dim = 0;
  double row_dim = 0;
  bool merged = false;
};

class Analysis {
 public:
  Analysis(const graft_block_pattern& pattern, bool parallel)
      : pattern_(pattern), graph_(pattern), parallel_(parallel) {}

  SymbolicFactor run(const std::vector<Index>& order) {
    result_.ordering = order.empty() ? chooseOrdering(graph_) : keepOrdering(graph_, order);
    // What the factor takes at least; found out exactly, it takes memory itself.
    requireMemory(result_.ordering.entries * sizeof(double), kFactorOfEquations, kWithoutFactor);
    orderByTree();
    findRows();
    merge();
    renumber();
    layOut();
    findTargets();
    requireMemory(result_.bytes(), kFactorOfEquations, kWithoutFactor);
    return std::move(result_);
  }

 private:
  int dimAt(Index position) const {
    return graph_.dims[std::size_t(order_[std::size_t(position)])];
  }

  /// Makes the order a postorder of its elimination tree.
  void orderByTree() {
    const std::vector<Index>& order = result_.ordering.order;
    const std::vector<Index> parent = eliminationTree(graph_, order);
    const std::size_t n = order.size();
    std::vector<std::vector<Index>> children(n);
    std::vector<Index> roots;
    for (std::size_t i = 0; i < n; ++i) {
      (parent[i] < 0 ? roots : children[std::size_t(parent[i])]).push_back(Index(i));
    }
    order_.reserve(n);
    std::vector<Index> moved(n);
    std::vector<std::pair<Index, std::size_t>> stack;
    for (const Index root : roots) {
      stack.emplace_back(root, 0);
      while (!stack.empty()) {
        auto& [node, next] = stack.back();
        if (next < children[std::size_t(node)].size()) {
          const Index child = children[std::size_t(node)][next++];
          stack.emplace_back(child, 0);
        } else {
          moved[std::size_t(node)] = Index(order_.size());
          order_.push_back(order[std::size_t(node)]);
          stack.pop_back();
        }
      }
    }
    parent_.assign(n, -1);
    for (std::size_t i = 0; i < n; ++i) {
      if (parent[i] >= 0) parent_[std::size_t(moved[i])] = moved[std::size_t(parent[i])];
    }
  }

  /// One node per block column, with the rows of the factor.
  void findRows() {
    const std::size_t n = order_.size();
    position_.resize(n);
    for (std::size_t i = 0; i < n; ++i) position_[std::size_t(order_[i])] = Index(i);
    nodes_.resize(n);
    std::vector<Index> mark(n, -1);
    for (std::size_t j = 0; j < n; ++j) {
      Node& node = nodes_[j];
      const auto add = [&](Index row) {
        if (row <= Index(j) || mark[std::size_t(row)] == Index(j)) return;
        mark[std::size_t(row)] = Index(j);
        node.rows.push_back(row);
        node.row_dim += dimAt(row);
      };
      const auto block = std::size_t(order_[j]);
      for (Index k = graph_.begin[block]; k < graph_.begin[block + 1]; ++k) {
        add(position_[std::size_t(graph_.neighbours[std::size_t(k)])]);
      }
      for (const Index child : node.children) {
        for (const Index row : nodes_[std::size_t(child)].rows) add(row);
      }
      node.columns = {Index(j)};
      node.column_dim = dimAt(Index(j));
      if (parent_[j] >= 0) nodes_[std::size_t(parent_[j])].children.push_back(Index(j));
    }
  }

  /// Merges children into parents, bottom up, where that is predicted to be
  /// faster. The merged front has the rows of the parent: those of the child are
  /// among the parent's columns and rows.
  void merge() {
    for (Node& parent : nodes_) {
      std::vector<Index> candidates;
      candidates.swap(parent.children);
      const auto byRows = [&](Index a, Index b) {
        const Node& na = nodes_[std::size_t(a)];
        const Node& nb = nodes_[std::size_t(b)];
        return na.row_dim != nb.row_dim ? na.row_dim > nb.row_dim : a < b;
      };
      std::sort(candidates.begin(), candidates.end(), byRows);
      std::vector<std::vector<Index>> parts;
      for (std::size_t c = 0; c < candidates.size(); ++c) {
        Node& child = nodes_[std::size_t(candidates[c])];
        const double apart = frontCost(child.column_dim, child.row_dim) +
                             frontCost(parent.column_dim, parent.row_dim);
        const double together = frontCost(child.column_dim + parent.column_dim, parent.row_dim);
        if (together >= apart) {
          parent.children.push_back(candidates[c]);
          continue;
        }
        parent.column_dim += child.column_dim;
        parts.push_back(std::move(child.columns));
        candidates.insert(candidates.end(), child.children.begin(), child.children.end());
        child.merged = true;
      }
      if (!parts.empty()) {
        std::vector<Index> columns;
        for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
          columns.insert(columns.end(), part->begin(), part->end());
        }
        columns.insert(columns.end(), parent.columns.begin(), parent.columns.end());
        // A grandchild that was merged after its parent comes first, as it must.
        parent.columns = std::move(columns);
      }
      std::sort(parent.children.begin(), parent.children.end());
    }
  }

  /// Numbers blocks anew so that the columns of a supernode follow each other,
  /// children before parents.
  void renumber() {
    std::vector<Index> number(nodes_.size(), -1);
    std::vector<Index> moved(nodes_.size());
    const std::vector<Index> before = order_;
    Index next_block = 0;
    // The node order is a postorder; merging keeps children before parents.
    for (std::size_t j = 0; j < nodes_.size(); ++j) {
      Node& node = nodes_[j];
      if (node.merged) continue;
      number[j] = Index(result_.supernodes.size());
      Supernode s;
      s.first_block = next_block;
      for (const Index column : node.columns) {
        moved[std::size_t(column)] = next_block;
        order_[std::size_t(next_block)] = before[std::size_t(column)];
        ++next_block;
      }
      s.last_block = next_block;
      for (const Index child : node.children) s.children.push_back(number[std::size_t(child)]);
      for (const Index child : s.children) {
        result_.supernodes[std::size_t(child)].parent = number[j];
      }
      absorbLeaves(s);
      s.columns = int(node.column_dim);
      s.rows = int(node.row_dim);
      s.row_blocks = std::move(node.rows);
      result_.supernodes.push_back(std::move(s));
    }
    for (Supernode& s : result_.supernodes) {
      for (Index& row : s.row_blocks) row = moved[std::size_t(row)];
      std::sort(s.row_blocks.begin(), s.row_blocks.end());
    }
    for (std::size_t i = 0; i < order_.size(); ++i) position_[std::size_t(order_[i])] = Index(i);
    result_.blocks = order_;
  }

  /// Many small leaves under one front, as landmarks make them, would need more memory
  /// for their updates than the factor has; few are faster with an update of their own.
  void absorbLeaves(Supernode& s) {
    const auto isSmallLeaf = [&](Index child) {
      const Supernode& c = result_.supernodes[std::size_t(child)];
      return c.children.empty() && c.columns <= kStrip;
    };
    const auto count = std::count_if(s.children.begin(), s.children.end(), isSmallLeaf);
    if (count < kLeavesWorthAbsorbing) return;
    s.absorbed_children = int(count);
    for (const Index child : s.children) {
      result_.supernodes[std::size_t(child)].absorbed = isSmallLeaf(child);
    }
  }

  void layOut() {
    std::vector<std::int64_t> scalar(order_.size() + 1, 0);
    for (std::size_t i = 0; i < order_.size(); ++i) scalar[i + 1] = scalar[i] + dimAt(Index(i));
    result_.dim = scalar.back();
    result_.scalar_position.resize(order_.size());
    for (std::size_t i = 0; i < order_.size(); ++i) {
      result_.scalar_position[std::size_t(order_[i])] = scalar[i];
    }
    for (Supernode& s : result_.supernodes) {
      s.first_scalar = scalar[std::size_t(s.first_block)];
      s.row_scalars.reserve(std::size_t(s.rows));
      for (const Index row : s.row_blocks) {
        for (int c = 0; c < dimAt(row); ++c) {
          s.row_scalars.push_back(Index(scalar[std::size_t(row)] + c));
        }
      }
      s.factor_offset = result_.factor_size;
      result_.factor_size += std::int64_t{s.columnStrips() + s.rowStrips()} * kStrip * s.columns;
    }
    for (Supernode& s : result_.supernodes) {
      if (s.parent < 0) continue;
      const Supernode& parent = result_.supernodes[std::size_t(s.parent)];
      s.in_parent.reserve(s.row_scalars.size());
      auto row = parent.row_scalars.begin();
      for (const Index position : s.row_scalars) {
        if (position < parent.first_scalar + parent.columns) {
          s.in_parent.push_back(Index(position - parent.first_scalar));
        } else {
          while (*row != position) ++row;
          s.in_parent.push_back(Index(row - parent.row_scalars.begin()) + parent.columns);
        }
      }
    }
    if (parallel_ && result_.ordering.flops > kFlopsWorthThreads) findTasks();
    layOutAllUpdates();
    if (result_.tasks.empty() || fitsIntoMemory(result_.bytes())) return;
    // Tasks share no memory for updates, which together may be three times as large.
    result_.tasks.clear();
    for (Supernode& s : result_.supernodes) s.task = -1;
    result_.update_size = 0;
    layOutAllUpdates();
  }

  void layOutAllUpdates() {
    for (const auto& task : result_.tasks) layOutUpdates(task);
    std::vector<Index> rest;
    for (std::size_t k = 0; k < result_.supernodes.size(); ++k) {
      if (result_.supernodes[k].task < 0) rest.push_back(Index(k));
    }
    layOutUpdates(rest);
  }

  /// Cuts the tree into subtrees of less than a sixteenth of the work each.
  void findTasks() {
    std::vector<Supernode>& nodes = result_.supernodes;
    std::vector<double> work(nodes.size(), 0);
    double total = 0;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const double own = frontCost(nodes[k].columns, nodes[k].rows);
      work[k] += own;
      total += own;
      if (nodes[k].parent >= 0) work[std::size_t(nodes[k].parent)] += work[k];
    }
    // From the roots down: small enough under a parent that is not begins a task.
    for (std::size_t k = nodes.size(); k-- > 0;) {
      const Index parent = nodes[k].parent;
      if (parent >= 0 && (nodes[k].absorbed || nodes[std::size_t(parent)].task >= 0)) {
        nodes[k].task = nodes[std::size_t(parent)].task;
      } else if (work[k] < total / 16 && work[k] > total / 1024) {
        nodes[k].task = Index(result_.tasks.size());
        result_.tasks.emplace_back();
      }
    }
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      if (nodes[k].task >= 0) result_.tasks[std::size_t(nodes[k].task)].push_back(Index(k));
    }
  }

  /// Plans where update matrices live: first fit among what is free at the time,
  /// in the order of the factorisation. What other lists use is not touched.
  void layOutUpdates(const std::vector<Index>& list) {
    struct Interval {
      std::int64_t begin;
      std::int64_t end;
    };
    std::vector<Interval> used;
    const std::int64_t base = result_.update_size;
    for (const Index k : list) {
      Supernode& s = result_.supernodes[std::size_t(k)];
      const std::int64_t size = s.absorbed ? 0 : std::int64_t{s.rows} * s.updateStride();
      if (size > 0) {
        std::int64_t begin = base;
        auto place = used.begin();
        while (place != used.end() && place->begin < begin + size) {
          begin = place->end;
          ++place;
        }
        s.update_offset = begin;
        used.insert(place, {begin, begin + size});
        result_.update_size = std::max(result_.update_size, begin + size);
      }
      for (const Index c : s.children) {
        const Supernode& child = result_.supernodes[std::size_t(c)];
        if (child.task != s.task || child.absorbed) continue;
        const std::int64_t begin = child.update_offset;
        used.erase(std::find_if(used.begin(), used.end(),
                                [&](const Interval& i) { return i.begin == begin; }));
      }
    }
  }

  int localOf(const Supernode& s, std::int64_t scalar) const {
    if (scalar < s.first_scalar + s.columns) return int(scalar - s.first_scalar);
    const auto row = std::lower_bound(s.row_scalars.begin(), s.row_scalars.end(), Index(scalar));
    return int(row - s.row_scalars.begin()) + s.columns;
  }

  void findTargets() {
    std::vector<Index> owner(order_.size());
    for (std::size_t k = 0; k < result_.supernodes.size(); ++k) {
      const Supernode& s = result_.supernodes[k];
      std::fill(owner.begin() + s.first_block, owner.begin() + s.last_block, Index(k));
    }
    std::vector<std::int64_t>& begin = result_.target_begin;
    begin.assign(result_.supernodes.size() + 1, 0);
    const auto forEach = [&](auto&& visit) {
      for (Index j = 0; j < pattern_.block_count; ++j) {
        for (std::int64_t b = pattern_.columns[j]; b < pattern_.columns[j + 1]; ++b) {
          const Index row = position_[std::size_t(pattern_.rows[b])];
          const Index column = position_[std::size_t(j)];
          visit(b, j, owner[std::size_t(std::min(row, column))], row < column);
        }
      }
    };
    forEach([&](std::int64_t, Index, Index s, bool) { ++begin[std::size_t(s) + 1]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    result_.targets.resize(std::size_t(begin.back()));
    std::vector<std::int64_t> next(begin.begin(), begin.end() - 1);
    forEach([&](std::int64_t b, Index j, Index owner_index, bool transposed) {
      const Supernode& s = result_.supernodes[std::size_t(owner_index)];
      const auto i = std::size_t(pattern_.rows[b]);
      const int row = localOf(s, result_.scalar_position[i]);
      const int column = localOf(s, result_.scalar_position[std::size_t(j)]);
      result_.targets[std::size_t(next[std::size_t(owner_index)]++)] = {
          pattern_.offsets[b],         graph_.dims[i],
          graph_.dims[std::size_t(j)], transposed ? column : row,
          transposed ? row : column,   transposed};
    });
  }

  const graft_block_pattern& pattern_;
  BlockGraph graph_;
  bool parallel_;
  SymbolicFactor result_;
  std::vector<Index> order_;
  std::vector<Index> position_;
  std::vector<Index> parent_;
  std::vector<Node> nodes_;
};

}  // namespace

SymbolicFactor analyzePattern(const graft_block_pattern& pattern, bool parallel,
                              const std::vector<std::int32_t>& order) {
  return Analysis(pattern, parallel).run(order);
}

}  // namespace graft
