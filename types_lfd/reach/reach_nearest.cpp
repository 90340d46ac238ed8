// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "types_lfd/reach/reach_distance.hpp"
#include "types_lfd/reach/tilt_slice.hpp"

namespace graft::lfd {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Rounding of transforms between world and view must not leave the set.
constexpr double kLeastMargin = 1e-6;
constexpr int kBisections = 6;
constexpr int kMostLayers = 2 * ReachGrid::kMostTurn;
constexpr int kMostWords = (ReachGrid::kMostNodes + 63) / 64;

struct Candidate {
  double cost = kInfinity;
  Pose2 point;  // in the view
};

double square(double x) { return x * x; }

/// Branch and bound through the boxes between nodes: layers of psi in the order
/// of their lower bounds, rows outwards, boxes outwards, each until its lower bound
/// exceeds what is looked for. Exact, and needs no table per combination of
/// sigmas. Most boxes are decided, a row at a time, by bits.
class BoxSearch {
 public:
  BoxSearch(const ReachGrid& grid, const TiltSlice& slice, const Pose2& query, double sigma_t,
            double sigma_r, double margin_t, double margin_r)
      : grid_(grid),
        slice_(slice),
        query_(query),
        weight_t_(1 / square(sigma_t)),
        weight_r_(1 / square(sigma_r)),
        units_(ReachDistance::kDistanceUnits / grid.resolution),
        margin_(std::max(margin_t, kLeastMargin) * units_),
        margin_r_(margin_r),
        turn_share_(margin_r / grid.nodeStep()) {}

  /// Reachable with the margins.
  bool keeps(const Pose2& b) const {
    if (!(slice_.at(b) >= margin_)) return false;
    return margin_r_ == 0 || (slice_.at(Pose2(b.x, b.y, b.theta - margin_r_)) >= margin_ &&
                              slice_.at(Pose2(b.x, b.y, b.theta + margin_r_)) >= margin_);
  }

  Candidate best() const {
    Candidate found;
    visit(kInfinity, [&](const Candidate& c) {
      if (c.cost < found.cost) found = c;
      // Only what is nearer is of interest from here on.
      return std::nextafter(found.cost, 0.0);
    });
    return found;
  }

  /// All boxes' nearest points with lower < cost <= upper, nearest first.
  std::vector<Candidate> between(double lower, double upper) const {
    std::vector<Candidate> found;
    visit(upper, [&](const Candidate& c) {
      if (c.cost > lower && c.cost <= upper) found.push_back(c);
      return upper;
    });
    std::stable_sort(found.begin(), found.end(),
                     [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
    return found;
  }

  /// The point of a box drawn back towards the query to where the margins
  /// begin, by a cell at most.
  Candidate drawnBack(const Candidate& c) const {
    const double dx = c.point.x - query_.x;
    const double dy = c.point.y - query_.y;
    const double dpsi = c.point.theta - query_.theta;
    const double cells =
        std::max(std::hypot(dx, dy) / grid_.resolution, std::abs(dpsi) / grid_.nodeStep());
    if (cells == 0) return c;
    const auto along = [&](double s) {
      return Pose2(query_.x + s * dx, query_.y + s * dy, query_.theta + s * dpsi);
    };
    double out = std::max(0.0, 1 - 1 / cells);
    double in = 1;
    if (keeps(along(out))) in = out;
    for (int i = 0; in > out && i < kBisections; ++i) {
      const double middle = 0.5 * (in + out);
      (keeps(along(middle)) ? in : out) = middle;
    }
    return {square(in) * c.cost, along(in)};
  }

 private:
  struct Range {
    int low;
    int high;
  };

  /// Distance from `value` to the box number `cell` of an axis: signed, so that
  /// value + result is the nearest point.
  double toBox(double value, int first, int cell) const {
    const double low = (first + cell) * grid_.resolution;
    const double high = (first + cell + 1) * grid_.resolution;
    return value < low ? low - value : (value > high ? high - value : 0.0);
  }

  double toLayer(int p) const {
    const double half = 0.5 * grid_.nodeStep();
    const double d = wrapAngle(query_.theta - (2 * p + 1) * half);
    if (std::abs(d) <= half) return 0;
    return d > 0 ? half - d : -half - d;
  }

  int next(int p) const { return p + 1 == grid_.psiCount() ? 0 : p + 1; }

  int previous(int p) const { return p == 0 ? grid_.psiCount() - 1 : p - 1; }

  /// The node keeps the margins.
  bool keepsAt(int p, int y, int x) const {
    const double here = slice_.node(p, y, x);
    if (!(here >= margin_)) return false;
    if (margin_r_ == 0) return true;
    // Linear between nodes, so that with this all in between keep them, too.
    return here + turn_share_ * (slice_.node(previous(p), y, x) - here) >= margin_ &&
           here + turn_share_ * (slice_.node(next(p), y, x) - here) >= margin_;
  }

  /// All corners of the box keep the margins.
  bool allKeep(int p, int y, int x) const {
    for (int i = 0; i < 8; ++i) {
      if (!keepsAt((i & 4) != 0 ? next(p) : p, y + (i >> 1 & 1), x + (i & 1))) return false;
    }
    return true;
  }

  /// A bit per box of a row (of its lower node in x): worth a look, as no
  /// corner is surely out of reach. False if there is none.
  bool findBoxes(int p, int y, std::uint64_t* row) const {
    const int words = grid_.rowWords();
    const int after = next(p);
    for (int w = 0; w < words; ++w) {
      row[w] = slice_.maybe(p, y, w) & slice_.maybe(p, y + 1, w);
      if (row[w] != 0) row[w] &= slice_.maybe(after, y, w) & slice_.maybe(after, y + 1, w);
    }
    return toBoxes(row, words);
  }

  /// The boxes that keep the margins for sure.
  void findSureBoxes(int p, int y, std::uint64_t* row) const {
    const int words = grid_.rowWords();
    const int after = next(p);
    for (int w = 0; w < words; ++w) {
      row[w] = slice_.sure(p, y, w) & slice_.sure(p, y + 1, w) & slice_.sure(after, y, w) &
               slice_.sure(after, y + 1, w);
      if (margin_r_ == 0 || row[w] == 0) continue;
      for (const int layer : {previous(p), next(after)}) {
        row[w] &= slice_.sure(layer, y, w) & slice_.sure(layer, y + 1, w);
      }
    }
    toBoxes(row, words);
  }

  /// Nodes that are followed by another; false if there is none.
  static bool toBoxes(std::uint64_t* row, int words) {
    std::uint64_t any = 0;
    for (int w = 0; w < words; ++w) {
      const std::uint64_t following = w + 1 < words ? row[w + 1] << 63 : 0;
      row[w] &= row[w] >> 1 | following;
      any |= row[w];
    }
    return any != 0;
  }

  /// The first bit at x or beyond it in the direction; -1 if there is none.
  static int firstBit(const std::uint64_t* row, int words, int x, int direction) {
    if (x < 0 || x >= 64 * words) return -1;
    int w = x / 64;
    const int bit = x % 64;
    std::uint64_t left =
        row[w] & (direction > 0 ? ~std::uint64_t{0} << bit : ~std::uint64_t{0} >> (63 - bit));
    while (left == 0) {
      w += direction;
      if (w < 0 || w >= words) return -1;
      left = row[w];
    }
    return 64 * w + (direction > 0 ? __builtin_ctzll(left) : 63 - __builtin_clzll(left));
  }

  Candidate project(int p, int y, int x) const {
    const double dx = toBox(query_.x, grid_.x0, x);
    const double dy = toBox(query_.y, grid_.y0, y);
    const double dpsi = toLayer(p);
    return {(square(dx) + square(dy)) * weight_t_ + square(dpsi) * weight_r_,
            Pose2(query_.x + dx, query_.y + dy, query_.theta + dpsi)};
  }

  static int startCell(double cell, const Range& range) {
    return static_cast<int>(std::clamp(std::floor(cell), static_cast<double>(range.low),
                                       static_cast<double>(range.high)));
  }

  /// The boxes of one psi, within which all that may be reachable is.
  struct Layer {
    double bound;  ///< of the costs
    int p;
    Range columns;
    Range rows;
  };

  double toRange(double value, int first, const Range& range) const {
    const double low = (first + range.low) * grid_.resolution;
    const double high = (first + range.high + 1) * grid_.resolution;
    return std::max({0.0, low - value, value - high});
  }

  int findLayers(Layer* layers) const {
    int count = 0;
    const int all = grid_.psiCount();
    ReachMap::Extent a = slice_.extent(0);
    const ReachMap::Extent first = a;
    for (int p = 0; p < all; ++p) {
      const ReachMap::Extent b = p + 1 < all ? slice_.extent(p + 1) : first;
      Layer& layer = layers[count];
      layer.p = p;
      layer.columns = {std::max(a.x_low, b.x_low), std::min(a.x_high, b.x_high) - 1};
      layer.rows = {std::max(a.y_low, b.y_low), std::min(a.y_high, b.y_high) - 1};
      a = b;
      if (layer.columns.low > layer.columns.high || layer.rows.low > layer.rows.high) continue;
      layer.bound =
          square(toLayer(p)) * weight_r_ + (square(toRange(query_.x, grid_.x0, layer.columns)) +
                                            square(toRange(query_.y, grid_.y0, layer.rows))) *
                                               weight_t_;
      ++count;
    }
    std::sort(layers, layers + count, [](const Layer& l, const Layer& r) {
      return l.bound != r.bound ? l.bound < r.bound : l.p < r.p;
    });
    return count;
  }

  /// Calls take(candidate) for every box that keeps the margins and whose lower
  /// bound does not exceed `limit`; take returns the new limit.
  template <class Take>
  void visit(double limit, const Take& take) const {
    Layer layers[kMostLayers];
    const int count = findLayers(layers);
    for (int i = 0; i < count && layers[i].bound <= limit; ++i) {
      limit = visitLayer(layers[i], limit, take);
    }
  }

  template <class Take>
  double visitLayer(const Layer& l, double limit, const Take& take) const {
    const double layer = square(toLayer(l.p)) * weight_r_;
    // No box of any row is nearer in x than this.
    const double across = square(toRange(query_.x, grid_.x0, l.columns)) * weight_t_;
    const Range& rows = l.rows;
    const int p = l.p;
    const int column = startCell(query_.x / grid_.resolution - grid_.x0, l.columns);
    const int row = startCell(query_.y / grid_.resolution - grid_.y0, rows);
    limit = visitRow(p, row, column, layer, limit, take);
    bool up = true;
    bool down = true;
    for (int d = 1; up || down; ++d) {
      up = up && row + d <= rows.high;
      down = down && row - d >= rows.low;
      if (up) up = tryRow(p, row + d, column, layer, across, limit, take);
      if (down) down = tryRow(p, row - d, column, layer, across, limit, take);
    }
    return limit;
  }

  template <class Take>
  bool tryRow(int p, int y, int column, double layer, double across, double& limit,
              const Take& take) const {
    const double bound = layer + square(toBox(query_.y, grid_.y0, y)) * weight_t_;
    if (bound + across > limit) return false;
    limit = visitRow(p, y, column, layer, limit, take);
    return true;
  }

  template <class Take>
  double visitRow(int p, int y, int column, double layer, double limit, const Take& take) const {
    std::uint64_t maybe[kMostWords];
    std::uint64_t sure[kMostWords];
    if (!findBoxes(p, y, maybe)) return limit;
    bool have_sure = false;
    const int words = grid_.rowWords();
    const double row = layer + square(toBox(query_.y, grid_.y0, y)) * weight_t_;
    for (const int direction : {1, -1}) {
      int x = direction > 0 ? column : column - 1;
      while ((x = firstBit(maybe, words, x, direction)) >= 0) {
        if (row + square(toBox(query_.x, grid_.x0, x)) * weight_t_ > limit) break;
        if (!have_sure) findSureBoxes(p, y, sure);
        have_sure = true;
        if ((sure[x / 64] >> (x % 64) & 1) != 0 || allKeep(p, y, x)) {
          limit = take(project(p, y, x));
        }
        x += direction;
      }
    }
    return limit;
  }

  const ReachGrid& grid_;
  const TiltSlice& slice_;
  Pose2 query_;
  double weight_t_;
  double weight_r_;
  double units_;
  double margin_;
  double margin_r_;
  double turn_share_;
};

}  // namespace

NearestBase ReachMap::nearest(const Pose& world_T_gripper, const Pose2& world_T_base,
                              double sigma_t, double sigma_r, const BaseFilter* filter) const {
  if (!(sigma_t > 0 && sigma_r > 0)) {
    throw Error(ExitCode::kInternal, "ReachMap::nearest: sigmas have to be positive");
  }
  NearestBase result;
  result.base = world_T_base;
  result.cost = kInfinity;
  const GripperView view = ReachGrid::view(world_T_gripper);
  const Pose2 query = baseInView(view, world_T_base);
  if (!std::isfinite(query.x + query.y + query.theta + view.elevation + view.roll)) return result;
  const TiltSlice slice(*this, view.position[2], view.elevation, view.roll);
  const BoxSearch search(grid_, slice, query, sigma_t, sigma_r, margin_t_, margin_r_);
  if (slice.any() && search.keeps(query) && (filter == nullptr || filter->isFree(world_T_base))) {
    result.found = true;
    result.inside = true;
    result.cost = 0;
    return result;
  }
  const auto accept = [&](const Candidate& c) {
    result.base = c.cost == 0 ? world_T_base : baseInWorld(view, c.point);
    result.cost = c.cost;
    result.found = filter == nullptr || filter->isFree(result.base);
    return result.found;
  };
  const Candidate best = slice.any() ? search.best() : Candidate();
  if (best.cost == kInfinity) {
    // Of another height, so that there is somewhere to go.
    const int own = static_cast<int>(
        std::lround(std::clamp(view.position[2] / grid_.resolution - grid_.z0, -1e6, 1e6)));
    std::vector<int> heights(static_cast<std::size_t>(grid_.nz));
    std::iota(heights.begin(), heights.end(), 0);
    std::stable_sort(heights.begin(), heights.end(),
                     [own](int a, int b) { return std::abs(a - own) < std::abs(b - own); });
    for (const int z : heights) {
      const TiltSlice other(*this, (grid_.z0 + z) * grid_.resolution, view.elevation, view.roll);
      if (!other.any()) continue;
      const BoxSearch there(grid_, other, query, sigma_t, sigma_r, margin_t_, margin_r_);
      const Candidate nearest = there.best();
      if (nearest.cost == kInfinity) continue;
      accept(there.drawnBack(nearest));
      result.found = false;
      break;
    }
    return result;
  }
  const Candidate drawn = search.drawnBack(best);
  if (accept(drawn)) return result;

  // Widen until a point is free; each shell is tested nearest first.
  double lower = best.cost;
  double upper = best.cost + square(2 * grid_.resolution / sigma_t);
  const double everything = square((grid_.nx + grid_.ny) * grid_.resolution / sigma_t) +
                            square(kPi / sigma_r) + 2 * best.cost +
                            square((std::abs(query.x) + std::abs(query.y)) / sigma_t);
  // The first shell also holds other boxes as near as the best.
  bool first = true;
  for (;;) {
    for (const Candidate& c : search.between(first ? -1 : lower, upper)) {
      if (accept(search.drawnBack(c)) || accept(c)) return result;
    }
    if (upper > 4 * everything) break;
    first = false;
    lower = upper;
    upper = best.cost + 4 * (upper - best.cost);
  }
  result.base = baseInWorld(view, drawn.point);
  result.cost = drawn.cost;
  return result;
}

}  // namespace graft::lfd
