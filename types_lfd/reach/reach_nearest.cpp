// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include "types_lfd/reach/reach_map.hpp"

namespace graft::lfd {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// What is projected goes this far past the face: on it, and even more so on a
// corner where one of the cells around is infeasible, rounding would decide.
constexpr double kNudge = 1e-9;

struct Candidate {
  double cost = kInfinity;
  Pose2 point;  // in the view
};

double square(double x) { return x * x; }

}  // namespace

/// Branch and bound through one (height, tilt) slice: layers of psi in the
/// order of their distance, rows outwards, cells outwards, each until its
/// lower bound exceeds what is looked for. Exact, and needs no table per
/// combination of sigmas.
class SliceSearch {
 public:
  SliceSearch(const ReachMap& map, std::size_t slice, const Pose2& query, double sigma_t,
              double sigma_r)
      : grid_(map.grid_),
        cells_(map.cells_.data() + slice * map.grid_.sliceSize()),
        query_(query),
        weight_t_(1 / square(sigma_t)),
        weight_r_(1 / square(sigma_r)),
        margin_t_(map.margin_t_),
        margin_r_(map.margin_r_),
        column_(startCell(query.x, grid_.x0, grid_.nx)),
        row_(startCell(query.y, grid_.y0, grid_.ny)) {}

  Candidate best() {
    Candidate found;
    visit(kInfinity, [&](const Candidate& c) {
      if (c.cost < found.cost) found = c;
      return found.cost;
    });
    return found;
  }

  /// All cells' nearest points with lower < cost <= upper, nearest first.
  std::vector<Candidate> between(double lower, double upper) {
    std::vector<Candidate> found;
    visit(upper, [&](const Candidate& c) {
      if (c.cost > lower && c.cost <= upper) found.push_back(c);
      return upper;
    });
    std::stable_sort(found.begin(), found.end(),
                     [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
    return found;
  }

 private:
  struct Interval {
    double low;
    double high;
  };

  int startCell(double x, int first, int count) const {
    const double cell = std::floor(x / grid_.resolution) - first;
    return static_cast<int>(std::clamp(cell, 0.0, static_cast<double>(count - 1)));
  }

  bool filled(int p, int y, int x) const {
    if (x < 0 || y < 0 || x >= grid_.nx || y >= grid_.ny) return false;
    return cells_[(static_cast<std::size_t>(p) * static_cast<std::size_t>(grid_.ny) +
                   static_cast<std::size_t>(y)) *
                      static_cast<std::size_t>(grid_.nx) +
                  static_cast<std::size_t>(x)] != 0;
  }

  /// Distance from x to the cell, without margins: a lower bound.
  double bound(double x, int first, int cell) const {
    const double low = (first + cell) * grid_.resolution;
    return std::max({0.0, low - x, x - low - grid_.resolution});
  }

  /// psi's distance to the interval [center + low, center + high] on the
  /// circle, signed: psi + result is the nearest point.
  double toInterval(double psi, double center, const Interval& i) const {
    const double d = wrapAngle(psi - center);
    if (d >= i.low && d <= i.high) return 0;
    const double up = d < i.low ? i.low - d : i.low + 2 * kPi - d;
    const double down = d > i.high ? d - i.high : d - i.high + 2 * kPi;
    return up <= down ? up : -down;
  }

  double layerBound(int p) const {
    const double half = 0.5 * grid_.step();
    return square(toInterval(query_.theta, p * grid_.step(), {-half, half})) * weight_r_;
  }

  Candidate project(int p, int y, int x) const {
    const double r = grid_.resolution;
    const auto clampAxis = [&](double value, int first, int cell, bool low_open, bool high_open) {
      const double low = (first + cell) * r + (low_open ? 0 : margin_t_);
      const double high = (first + cell + 1) * r - (high_open ? 0 : margin_t_);
      if (value < low) return low + kNudge;
      return value > high ? high - kNudge : value;
    };
    const double half = 0.5 * grid_.step();
    const int before = p == 0 ? grid_.turn - 1 : p - 1;
    const int after = p + 1 == grid_.turn ? 0 : p + 1;
    const Interval angles{filled(before, y, x) ? -half : margin_r_ - half,
                          filled(after, y, x) ? half : half - margin_r_};
    double dpsi = toInterval(query_.theta, p * grid_.step(), angles);
    if (dpsi != 0) dpsi += dpsi > 0 ? kNudge : -kNudge;
    Candidate c;
    c.point.x = clampAxis(query_.x, grid_.x0, x, filled(p, y, x - 1), filled(p, y, x + 1));
    c.point.y = clampAxis(query_.y, grid_.y0, y, filled(p, y - 1, x), filled(p, y + 1, x));
    c.point.theta = query_.theta + dpsi;
    c.cost = (square(c.point.x - query_.x) + square(c.point.y - query_.y)) * weight_t_ +
             square(dpsi) * weight_r_;
    return c;
  }

  /// Calls take(candidate) for every filled cell whose lower bound does not
  /// exceed `limit`; take returns the new limit.
  template <class Take>
  void visit(double limit, const Take& take) {
    // Layers alternate to both sides of the query's own angle.
    const int own = grid_.angleBin(query_.theta);
    const bool right_first = wrapAngle(query_.theta - own * grid_.step()) > 0;
    for (int k = 0; k < grid_.turn; ++k) {
      const int offset = (k + 1) / 2 * ((k % 2 == 1) == right_first ? 1 : -1);
      const int p = ((own + offset) % grid_.turn + grid_.turn) % grid_.turn;
      const double layer = layerBound(p);
      if (layer > limit) continue;
      limit = visitRow(p, row_, layer, limit, take);
      bool up = true;
      bool down = true;
      for (int d = 1; up || down; ++d) {
        up = up && row_ + d < grid_.ny;
        down = down && row_ - d >= 0;
        if (up) {
          const double b = layer + square(bound(query_.y, grid_.y0, row_ + d)) * weight_t_;
          up = b <= limit;
          if (up) limit = visitRow(p, row_ + d, b, limit, take);
        }
        if (down) {
          const double b = layer + square(bound(query_.y, grid_.y0, row_ - d)) * weight_t_;
          down = b <= limit;
          if (down) limit = visitRow(p, row_ - d, b, limit, take);
        }
      }
    }
  }

  template <class Take>
  double visitRow(int p, int y, double row_bound, double limit, const Take& take) {
    if (filled(p, y, column_)) limit = take(project(p, y, column_));
    for (const int direction : {1, -1}) {
      for (int x = column_ + direction; x >= 0 && x < grid_.nx; x += direction) {
        if (row_bound + square(bound(query_.x, grid_.x0, x)) * weight_t_ > limit) break;
        if (filled(p, y, x)) limit = take(project(p, y, x));
      }
    }
    return limit;
  }

  const ReachGrid& grid_;
  const std::uint8_t* cells_;
  Pose2 query_;
  double weight_t_;
  double weight_r_;
  double margin_t_;
  double margin_r_;
  int column_;
  int row_;
};

NearestBase ReachMap::nearest(const Pose& world_T_gripper, const Pose2& world_T_base,
                              double sigma_t, double sigma_r, const BaseFilter* filter) const {
  if (!(sigma_t > 0 && sigma_r > 0)) {
    throw Error(ExitCode::kInternal, "ReachMap::nearest: sigmas have to be positive");
  }
  NearestBase result;
  result.base = world_T_base;
  result.cost = kInfinity;
  const GripperView view = grid_.view(world_T_gripper);
  int z = grid_.heightBin(view.position[2]);
  const bool reachable = z >= 0 && z < grid_.nz && filled_[grid_.slice(z, view.tilt)] > 0;
  if (!reachable) z = nearestFilledHeight(z, view.tilt);
  if (z < 0) return result;

  const Pose2 query = baseInView(view, world_T_base);
  SliceSearch search(*this, grid_.slice(z, view.tilt), query, sigma_t, sigma_r);
  const auto place = [&](const Candidate& c) {
    return c.cost == 0 ? world_T_base : baseInWorld(view, c.point);
  };
  const Candidate best = search.best();
  result.base = place(best);
  result.cost = best.cost;
  if (!reachable) return result;
  result.found = filter == nullptr || filter->isFree(result.base);
  result.inside = result.found && best.cost == 0;
  if (result.found) return result;

  // Widen until a point is free; each shell is tested nearest first.
  double lower = best.cost;
  double upper = best.cost + square(2 * grid_.resolution / sigma_t);
  const double everything = square((grid_.nx + grid_.ny) * grid_.resolution / sigma_t) +
                            square(kPi / sigma_r) + 2 * best.cost +
                            square((std::abs(query.x) + std::abs(query.y)) / sigma_t);
  // The first shell also holds other cells as near as the best.
  bool first = true;
  for (;;) {
    for (const Candidate& c : search.between(first ? -1 : lower, upper)) {
      const Pose2 base = place(c);
      if (!filter->isFree(base)) continue;
      result.found = true;
      result.inside = c.cost == 0;
      result.base = base;
      result.cost = c.cost;
      return result;
    }
    if (upper > 4 * everything) return result;
    first = false;
    lower = upper;
    upper = best.cost + 4 * (upper - best.cost);
  }
}

}  // namespace graft::lfd
