// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/map/distance_transform.hpp"

namespace graft::lfd {

namespace {

/// Per column: squared distance to the nearest marked cell of that column.
void columnDistances(const std::vector<bool>& marked, int width, int height,
                     std::vector<std::int32_t>& squared) {
  const auto at = [width](int column, int row) {
    return static_cast<std::size_t>(row) * width + column;
  };
  for (int column = 0; column < width; ++column) {
    int last = -1;
    for (int row = 0; row < height; ++row) {
      if (marked[at(column, row)]) last = row;
      if (last >= 0) squared[at(column, row)] = (row - last) * (row - last);
    }
    last = -1;
    for (int row = height - 1; row >= 0; --row) {
      if (marked[at(column, row)]) last = row;
      if (last < 0) continue;
      const std::int32_t below = (last - row) * (last - row);
      std::int32_t& value = squared[at(column, row)];
      if (below < value) value = below;
    }
  }
}

/// Lower envelope of the parabolas (x - i)^2 + values[i] over one row.
class RowEnvelope {
 public:
  explicit RowEnvelope(int width) : roots_(width), from_(width), result_(width) {}

  void apply(std::int32_t* values, int width) {
    int top = -1;
    for (int i = 0; i < width; ++i) {
      if (values[i] == kNoDistance) continue;
      double from = -1;
      while (top >= 0) {
        from = crossing(values, roots_[top], i);
        if (from > from_[top]) break;
        --top;
      }
      if (top < 0) from = -1;
      ++top;
      roots_[top] = i;
      from_[top] = from;
    }
    if (top < 0) return;
    int k = 0;
    for (int i = 0; i < width; ++i) {
      while (k < top && from_[k + 1] < i) ++k;
      const std::int32_t offset = i - roots_[k];
      result_[i] = offset * offset + values[roots_[k]];
    }
    for (int i = 0; i < width; ++i) values[i] = result_[i];
  }

 private:
  /// Where the parabola rooted at `b` begins to lie below that at `a` < b.
  static double crossing(const std::int32_t* values, int a, int b) {
    const double at_a = static_cast<double>(values[a]) + static_cast<double>(a) * a;
    const double at_b = static_cast<double>(values[b]) + static_cast<double>(b) * b;
    return (at_b - at_a) / (2.0 * (b - a));
  }

  std::vector<int> roots_;
  std::vector<double> from_;
  std::vector<std::int32_t> result_;
};

}  // namespace

std::vector<std::int32_t> squaredDistances(const std::vector<bool>& marked, int width, int height) {
  std::vector<std::int32_t> squared(marked.size(), kNoDistance);
  columnDistances(marked, width, height, squared);
  RowEnvelope envelope(width);
  for (int row = 0; row < height; ++row) {
    envelope.apply(squared.data() + static_cast<std::size_t>(row) * width, width);
  }
  return squared;
}

}  // namespace graft::lfd
