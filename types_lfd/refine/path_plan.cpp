// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/refine/path_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace graft::lfd {

namespace {

// Costs, in metres of change of the offset. Standing 1 m off for a second costs
// as much as moving there; what must not be outweighs any way around.
constexpr double kPerMetreSecond = 1;
constexpr double kPerSpeedRatio = 0.02;
constexpr double kPerRadian = 1e-3;  // where the fastest joint is the same, less motion
constexpr double kFastStep = 20;
constexpr double kBlocked = 50;
constexpr double kUnsolved = 50;    // per tuple
constexpr double kUnstanding = 50;  // per tuple

struct State {
  Placed placed;
  Eigen::VectorXd seed;  ///< joints here, or the last known before
  double own = 0;        ///< cost of being here
  double cost = std::numeric_limits<double>::infinity();
  int from = -1;
};
using Layer = std::vector<State>;

class Planner {
 public:
  Planner(const Placement& placement, const std::vector<BaseOffset>& lattice,
          const std::vector<Eigen::VectorXd>& postures, const RefineOptions& options,
          const PathRequest& request)
      : placement_(placement),
        lattice_(lattice),
        postures_(postures),
        options_(options),
        request_(request) {}

  PlannedPath run() {
    const std::size_t n = request_.keys.size();
    std::vector<Layer> layers(n);
    for (std::size_t k = 0; k < n; ++k) {
      const Layer none;
      const Layer& before = k > 0 ? layers[k - 1] : none;
      if (k == 0 && request_.first != nullptr) {
        layers[k].push_back(makeState(k, *request_.first));
      } else if (k + 1 == n && request_.last != nullptr) {
        layers[k].push_back(makeState(k, *request_.last));
      } else {
        layers[k] = makeLayer(k, before);
      }
      for (State& state : layers[k]) {
        if (k == 0) {
          state.cost = state.own;
        } else {
          connect(k, before, state);
        }
      }
    }
    return backtrack(layers);
  }

 private:
  std::size_t key(std::size_t k) const { return request_.keys[k]; }

  /// Tuples that a key stands for.
  double weight(std::size_t k) const {
    const std::size_t low = k > 0 ? key(k - 1) : key(k);
    const std::size_t high = k + 1 < request_.keys.size() ? key(k + 1) : key(k);
    return std::max(1.0, 0.5 * double(high - low));
  }
  double duration(std::size_t k) const {
    const std::size_t low = k > 0 ? key(k - 1) : key(k);
    const std::size_t high = k + 1 < request_.keys.size() ? key(k + 1) : key(k);
    return 0.5 * placement_.seconds(low, high);
  }

  State makeState(std::size_t k, const Placed& placed) const {
    State state;
    state.placed = placed;
    state.seed = placed.solved() ? placed.joints : postures_.front();
    state.own = kPerMetreSecond * duration(k) * placed.offset.length();
    if (!placed.solved()) state.own += kUnsolved * weight(k);
    return state;
  }

  /// Cost of a step as far as it is known without looking at the map.
  double stepCost(std::size_t k, const State& a, const State& b) const {
    double cost = (b.placed.offset - a.placed.offset).length();
    const double base =
        placement_.baseSpeedRatio(key(k - 1), a.placed.offset, key(k), b.placed.offset);
    if (base > 1) cost += kFastStep * std::min(4.0, base);
    if (!a.placed.solved() || !b.placed.solved()) return cost;
    const double ratio = placement_.speedRatio(a.placed.joints, b.placed.joints,
                                               placement_.seconds(key(k - 1), key(k)));
    cost += kPerSpeedRatio * ratio;
    cost += kPerRadian * placement_.jointStep(a.placed.joints, b.placed.joints).norm();
    // Between the keys joints do not move evenly.
    const double allowed = options_.speed_factor * (key(k) > key(k - 1) + 1 ? 0.75 : 1.0);
    if (ratio > allowed) cost += kFastStep * std::min(2.0, ratio / allowed);
    return cost;
  }

  /// Whether the tuples between two keys stand well on the way.
  bool wayFree(std::size_t k, const State& from, const State& to) const {
    const BaseOffset& a = from.placed.offset;
    const BaseOffset& b = to.placed.offset;
    const std::size_t begin = key(k - 1);
    const std::size_t end = key(k);
    BaseOffset last = a;
    for (std::size_t i = begin + 1; i <= end; ++i) {
      const BaseOffset next = i == end ? b : placement_.between(i, begin, a, end, b);
      if (i < end && !placement_.reaches(i, next)) return false;
      if (!placement_.wayFree(i - 1, last, next)) return false;
      last = next;
    }
    return armFollows(k, from, to);
  }

  /// Where the base goes far between two keys: whether the arm can follow.
  bool armFollows(std::size_t k, const State& from, const State& to) const {
    constexpr double kFar = 0.1;  // m
    const BaseOffset& a = from.placed.offset;
    const BaseOffset& b = to.placed.offset;
    const std::size_t begin = key(k - 1);
    const std::size_t end = key(k);
    if (!from.placed.solved() || !to.placed.solved()) return true;
    if (a.zero() && b.zero()) return true;
    const Pose2 p = placement_.base(begin, a);
    const Pose2 q = placement_.base(end, b);
    if ((b - a).length() < kFar && std::hypot(q.x - p.x, q.y - p.y) < 2 * kFar) return true;
    for (std::size_t i = begin + 1; i < end; ++i) {
      const double f = placement_.seconds(begin, i) / placement_.seconds(begin, end);
      const Eigen::VectorXd start =
          from.placed.joints + f * placement_.jointStep(from.placed.joints, to.placed.joints);
      if (!placement_.solveArm(i, placement_.between(i, begin, a, end, b), start)) return false;
    }
    return true;
  }

  void connect(std::size_t k, const Layer& before, State& state) const {
    std::vector<std::pair<double, int>> order;
    for (std::size_t a = 0; a < before.size(); ++a) {
      order.emplace_back(before[a].cost + stepCost(k, before[a], state), int(a));
    }
    std::sort(order.begin(), order.end());
    double best = order.front().first + kBlocked;
    state.from = order.front().second;
    for (const auto& [cost, a] : order) {
      if (cost >= best) break;
      if (!wayFree(k, before[std::size_t(a)], state)) continue;
      best = cost;
      state.from = a;
      break;
    }
    state.cost = best + state.own;
    if (!state.placed.solved()) state.seed = before[std::size_t(state.from)].seed;
  }

  Layer makeLayer(std::size_t k, const Layer& before) const {
    Layer layer;
    std::vector<BaseOffset> offsets = lattice_;
    if (!before.empty()) {
      const auto best =
          std::min_element(before.begin(), before.end(),
                           [](const State& a, const State& b) { return a.cost < b.cost; });
      if (!best->placed.offset.zero()) offsets.insert(offsets.begin() + 1, best->placed.offset);
    }
    std::size_t found = 0;
    std::size_t tried = 0;
    for (const BaseOffset& offset : offsets) {
      if (found >= options_.candidates || tried >= options_.attempts) break;
      if (!placement_.stands(key(k), offset)) continue;
      ++tried;
      if (addSolutions(k, offset, before, layer)) ++found;
    }
    if (found == 0) addUnsolved(k, layer);
    return layer;
  }

  bool known(const Layer& layer, std::size_t begin, const Eigen::VectorXd& q) const {
    constexpr double kSame = 0.05;
    return std::any_of(layer.begin() + std::ptrdiff_t(begin), layer.end(), [&](const State& s) {
      return placement_.jointStep(s.placed.joints, q).cwiseAbs().maxCoeff() < kSame;
    });
  }

  /// Arm solutions at an offset: continued from the layer before, from the
  /// cheapest state and from the cheapest of another posture; from the given
  /// postures where that fails, and always at the optimized base.
  bool addSolutions(std::size_t k, const BaseOffset& offset, const Layer& before,
                    Layer& layer) const {
    constexpr double kOtherPosture = 0.7;
    const std::size_t begin = layer.size();
    const auto attempt = [&](const Eigen::VectorXd& start) {
      const auto q = placement_.solveArm(key(k), offset, start);
      if (q && !known(layer, begin, *q)) layer.push_back(makeState(k, {offset, *q}));
    };
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t a = 0; a < before.size(); ++a) {
      order.emplace_back(before[a].cost + (offset - before[a].placed.offset).length(), a);
    }
    std::sort(order.begin(), order.end());
    if (!order.empty()) {
      const Eigen::VectorXd& nearest = before[order.front().second].seed;
      attempt(nearest);
      for (const auto& [cost, a] : order) {
        const Eigen::VectorXd apart = placement_.jointStep(nearest, before[a].seed);
        if (apart.cwiseAbs().maxCoeff() < kOtherPosture) continue;
        attempt(before[a].seed);
        break;
      }
    }
    if (before.empty() || offset.zero()) {
      for (const Eigen::VectorXd& posture : postures_) attempt(posture);
    } else if (layer.size() == begin && !postures_.empty()) {
      attempt(postures_[(k + layer.size()) % postures_.size()]);
    }
    return layer.size() > begin;
  }

  void addUnsolved(std::size_t k, Layer& layer) const {
    constexpr std::size_t kStates = 4;
    for (const BaseOffset& offset : lattice_) {
      if (layer.size() >= kStates) return;
      if (placement_.stands(key(k), offset)) layer.push_back(makeState(k, {offset, {}}));
    }
    if (!layer.empty()) return;
    for (const BaseOffset& offset : lattice_) {
      if (placement_.collides(key(k), offset)) continue;
      layer.push_back(makeState(k, {offset, {}}));
      break;
    }
    if (layer.empty()) layer.push_back(makeState(k, {}));
    for (State& state : layer) state.own += kUnstanding * weight(k);
  }

  PlannedPath backtrack(const std::vector<Layer>& layers) const {
    PlannedPath path;
    const Layer& end = layers.back();
    const auto best = std::min_element(
        end.begin(), end.end(), [](const State& a, const State& b) { return a.cost < b.cost; });
    path.cost = best->cost;
    path.at.resize(layers.size());
    int at = int(best - end.begin());
    for (std::size_t k = layers.size(); k-- > 0;) {
      const State& state = layers[k][std::size_t(at)];
      path.at[k] = state.placed;
      at = state.from;
    }
    return path;
  }

  const Placement& placement_;
  const std::vector<BaseOffset>& lattice_;
  const std::vector<Eigen::VectorXd>& postures_;
  const RefineOptions& options_;
  const PathRequest& request_;
};

}  // namespace

std::vector<BaseOffset> offsetLattice(Spread spread) {
  constexpr double kPi = 3.14159265358979323846;
  std::vector<double> rings{0, 0.05, 0.1, 0.18, 0.3, 0.45};
  std::vector<double> turns{0, -0.15, 0.15, -0.4, 0.4, -0.8, 0.8};
  if (spread == Spread::kFine) {
    rings = {0, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2};
    turns = {0, -0.05, 0.05, -0.1, 0.1, -0.2, 0.2, -0.3, 0.3};
  } else if (spread == Spread::kWide) {
    rings.insert(rings.end(), {0.6, 0.8, 1.0});
    turns.insert(turns.end(), {-1.2, 1.2, -1.6, 1.6, -2.2, 2.2, kPi});
  }
  constexpr int kDirections = 8;
  std::vector<BaseOffset> lattice;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    for (int d = 0; d < (r == 0 ? 1 : kDirections); ++d) {
      const double angle = (d + 0.5 * double(r % 2)) * 2 * kPi / kDirections;
      for (std::size_t t = 0; t < turns.size(); ++t) {
        // Every other turn on every other spoke: half the poses spread alike.
        if (r > 0 && t > 0 && ((t + 1) / 2 + std::size_t(d)) % 2 == 0) continue;
        lattice.push_back({rings[r] * std::cos(angle), rings[r] * std::sin(angle), turns[t]});
      }
    }
  }
  std::stable_sort(lattice.begin(), lattice.end(),
                   [](const auto& a, const auto& b) { return a.length() < b.length(); });
  return lattice;
}

PlannedPath planPath(const Placement& placement, const std::vector<BaseOffset>& lattice,
                     const std::vector<Eigen::VectorXd>& postures, const RefineOptions& options,
                     const PathRequest& request) {
  return Planner(placement, lattice, postures, options, request).run();
}

}  // namespace graft::lfd
