// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/refine/track_refiner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace graft::lfd {

namespace {

constexpr std::size_t kWideFactor = 4;
// Faults that are left: about one step a little too fast; a jump.
constexpr double kMinor = 2;
constexpr double kSerious = 5;
constexpr double kFine = 10;  ///< cost of a plan, below that of any fault
constexpr double kNoHold = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TrackRefiner::TrackRefiner(const DemonstrationEstimate& demo, const TaskScene& scene,
                           const RefineOptions& options)
    : demo_(demo), options_(options), placement_(demo, scene) {}

bool TrackRefiner::tupleGood(const Path& path, std::size_t i) const {
  return path[i].solved() && placement_.stands(i, path[i].offset);
}

bool TrackRefiner::wayFree(const Path& path, std::size_t i) const {
  return placement_.wayFree(i, path[i].offset, path[i + 1].offset);
}

double TrackRefiner::haste(const Path& path, std::size_t i) const {
  double ratio = placement_.baseSpeedRatio(i, path[i].offset, i + 1, path[i + 1].offset);
  if (path[i].solved() && path[i + 1].solved()) {
    const double seconds = placement_.seconds(i, i + 1);
    ratio = std::max(ratio, placement_.speedRatio(path[i].joints, path[i + 1].joints, seconds) /
                                options_.speed_factor);
  }
  return ratio;
}

double TrackRefiner::hasteAround(const Path& path, std::size_t i) const {
  return std::max(i > 0 ? haste(path, i - 1) : 0.0, i + 1 < path.size() ? haste(path, i) : 0.0);
}

double TrackRefiner::faults(const Path& path, std::size_t begin, std::size_t end) const {
  constexpr double kSevere = 10;
  double sum = 0;
  for (std::size_t i = begin; i <= end; ++i) {
    if (!path[i].solved()) sum += kSevere;
    if (!placement_.stands(i, path[i].offset)) sum += kSevere;
    if (i == end) break;
    if (!wayFree(path, i)) sum += kSevere;
    if (const double h = haste(path, i); h > 1) sum += std::min(h, kSevere);
  }
  return sum;
}

TrackRefiner::Path TrackRefiner::asOptimized() const {
  std::vector<Pose> base_T_gripper;
  for (std::size_t i = 0; i < demo_.size(); ++i) {
    base_T_gripper.push_back(placement_.baseToGripper(i, {}));
  }
  // Only to see whether all is well already: no long search where it is not.
  IkTrackOptions options;
  options.ik.iterations = 30;
  options.ik.restarts = 6;
  IkTrack track = solveIkAlong(placement_.chain(), base_T_gripper, demo_.times, options);
  Path path(demo_.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    path[i].joints = std::move(track.joints[i]);
    if (path[i].solved() && !placement_.sees(i, path[i])) path[i].joints.resize(0);
  }
  return path;
}

std::vector<std::size_t> TrackRefiner::keysFrom(std::size_t begin, std::size_t end,
                                                std::size_t stride) const {
  std::vector<std::size_t> keys;
  for (std::size_t i = begin; i < end; i += stride) keys.push_back(i);
  keys.push_back(end);
  return keys;
}

std::vector<double> TrackRefiner::torsoHeights(const Path& optimized) const {
  const Chain& chain = placement_.chain();
  const int joint = chain.heightJoint();
  if (joint < 0) return {kNoHold};
  // What the arm liked alone, then all over its range.
  std::vector<double> heights;
  std::vector<double> liked;
  for (const Placed& placed : optimized) {
    if (placed.solved()) liked.push_back(placed.joints[joint]);
  }
  if (!liked.empty()) {
    const auto middle = liked.begin() + std::ptrdiff_t(liked.size() / 2);
    std::nth_element(liked.begin(), middle, liked.end());
    heights.push_back(*middle);
  }
  for (const double share : {0.5, 0.1, 0.9}) {
    heights.push_back(chain.lower()[joint] + share * (chain.upper()[joint] - chain.lower()[joint]));
  }
  return heights;
}

TrackRefiner::Path TrackRefiner::search(const Path& optimized) {
  const std::size_t end = demo_.size() - 1;
  PathRequest request;
  request.keys = keysFrom(0, end, options_.stride);
  Path best = optimized;
  double best_faults = faults(best, 0, end);
  double lowest_cost = std::numeric_limits<double>::infinity();
  double height_of_lowest = kNoHold;
  double best_height = kNoHold;
  const auto attempt = [&](double height, Spread spread) {
    RefineOptions options = options_;
    if (spread == Spread::kWide) {
      options.candidates *= kWideFactor;
      options.attempts *= kWideFactor;
    }
    placement_.holdHeight(height);
    postures_ = placement_.findPostures(options_.seed);
    const PlannedPath plan =
        planPath(placement_, offsetLattice(spread), postures_, options, request);
    if (plan.cost < lowest_cost) {
      lowest_cost = plan.cost;
      height_of_lowest = height;
    }
    // A plan with a fault is worth the work only where all have one.
    if (plan.cost >= kFine && spread == Spread::kUsual) return;
    Path path(demo_.size());
    for (std::size_t k = 0; k < request.keys.size(); ++k) path[request.keys[k]] = plan.at[k];
    for (std::size_t k = 1; k < request.keys.size(); ++k) {
      fillBetween(path, request.keys[k - 1], request.keys[k]);
    }
    repair(path);
    const double left = faults(path, 0, end);
    if (left >= best_faults) return;
    best = std::move(path);
    best_faults = left;
    best_height = height;
  };
  for (const double height : torsoHeights(optimized)) {
    attempt(height, Spread::kUsual);
    if (best_faults < kMinor) break;
  }
  const double liked = torsoHeights(optimized).front();
  if (best_faults >= kSerious) attempt(height_of_lowest, Spread::kWide);
  if (best_faults >= kSerious && liked != height_of_lowest) attempt(liked, Spread::kWide);
  placement_.holdHeight(best_height);
  return best;
}

void TrackRefiner::fillBetween(Path& path, std::size_t begin, std::size_t end) const {
  const Placed& a = path[begin];
  const Placed& b = path[end];
  const bool both = a.solved() && b.solved();
  for (std::size_t i = begin + 1; i < end; ++i) {
    const double f = placement_.seconds(begin, i) / placement_.seconds(begin, end);
    Placed& here = path[i];
    here.offset = placement_.between(i, begin, a.offset, end, b.offset);
    here.joints.resize(0);
    if (!both && !a.solved() && !b.solved()) continue;
    const Eigen::VectorXd start =
        both ? Eigen::VectorXd(a.joints + f * placement_.jointStep(a.joints, b.joints))
             : (a.solved() ? a.joints : b.joints);
    const Eigen::VectorXd* before = path[i - 1].solved() ? &path[i - 1].joints : nullptr;
    for (const double factor : {1.0, options_.speed_factor}) {
      const auto q = placement_.solveArmBetween(i, here.offset, start, before, nullptr, factor);
      if (!q) continue;
      here.joints = *q;
      break;
    }
    if (here.solved()) continue;
    for (const Eigen::VectorXd* seed : {&start, &a.joints, &b.joints}) {
      if (seed->size() == 0) continue;
      const auto q = placement_.solveArm(i, here.offset, *seed);
      if (!q) continue;
      here.joints = *q;
      break;
    }
  }
}

void TrackRefiner::replanBadStretches(Path& path, const Replan& replan) const {
  const std::size_t margin = replan.margin;
  RefineOptions options = options_;
  if (replan.spread == Spread::kFine) {
    options.candidates *= 3;
    options.attempts *= 2;
  }
  const std::vector<BaseOffset> lattice = offsetLattice(replan.spread);
  const std::size_t n = path.size();
  std::vector<bool> bad(n, false);
  for (std::size_t i = 0; i < n; ++i) {
    const bool step = i + 1 < n && (!wayFree(path, i) || haste(path, i) > 1);
    if (tupleGood(path, i) && !step) continue;
    const std::size_t low = i > margin ? i - margin : 0;
    const std::size_t high = std::min(n, i + margin + 2);
    for (std::size_t j = low; j < high; ++j) bad[j] = true;
  }
  for (std::size_t begin = 0; begin < n; ++begin) {
    if (!bad[begin]) continue;
    std::size_t end = begin;
    while (end + 1 < n && bad[end + 1]) ++end;
    PathRequest request;
    request.keys = keysFrom(begin, end, replan.stride);
    const Placed first = path[begin];
    const Placed last = path[end];
    request.around = &path;
    if (begin > 0) request.first = &first;
    if (end + 1 < n) request.last = &last;
    std::vector<Eigen::VectorXd> postures;
    for (const std::size_t i : {begin, end}) {
      if (path[i].solved()) postures.push_back(path[i].joints);
    }
    postures.insert(postures.end(), postures_.begin(), postures_.end());
    const PlannedPath plan = planPath(placement_, lattice, postures, options, request);
    Path trial = path;
    for (std::size_t k = 0; k < request.keys.size(); ++k) trial[request.keys[k]] = plan.at[k];
    for (std::size_t k = 1; k < request.keys.size(); ++k) {
      fillBetween(trial, request.keys[k - 1], request.keys[k]);
    }
    if (faults(trial, begin, end) < faults(path, begin, end)) path = std::move(trial);
    begin = end;
  }
}

/// Takes a new offset for a tuple if nothing gets worse by it.
bool TrackRefiner::improve(Path& path, std::size_t i, const BaseOffset& offset) const {
  if (!placement_.stands(i, offset)) return false;
  const bool has_before = i > 0;
  const bool has_after = i + 1 < path.size();
  if (has_before && !placement_.wayFree(i - 1, path[i - 1].offset, offset)) return false;
  if (has_after && !placement_.wayFree(i, offset, path[i + 1].offset)) return false;
  const auto joints = [&](std::size_t k) { return path[k].solved() ? &path[k].joints : nullptr; };
  const auto q =
      placement_.solveArmBetween(i, offset, path[i].joints, has_before ? joints(i - 1) : nullptr,
                                 has_after ? joints(i + 1) : nullptr, options_.speed_factor);
  if (!q) return false;
  const Placed old = path[i];
  const double before = hasteAround(path, i);
  path[i] = {offset, *q};
  if (hasteAround(path, i) <= std::max(1.0, before)) return true;
  path[i] = old;
  return false;
}

void TrackRefiner::smooth(Path& path) const {
  const std::size_t n = path.size();
  constexpr double kNothing = 1e-4;
  for (int sweep = 0; sweep < options_.smoothing_sweeps; ++sweep) {
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = sweep % 2 == 0 ? k : n - 1 - k;
      const BaseOffset& here = path[i].offset;
      if (here.zero() || !tupleGood(path, i)) continue;
      const BaseOffset& before = path[i > 0 ? i - 1 : i].offset;
      const BaseOffset& after = path[i + 1 < n ? i + 1 : i].offset;
      const BaseOffset mean = interpolate(before, after, 0.5);
      // A little less than the mean, as long as the arm still reaches.
      BaseOffset less = interpolate(mean, {}, 0.1);
      if (less.length() < kNothing) less = {};
      if (improve(path, i, less)) continue;
      if ((mean - here).length() > kNothing) improve(path, i, interpolate(here, mean, 0.7));
    }
  }
}

RefinedTrack TrackRefiner::summarize(Path path) const {
  RefinedTrack track;
  const Chain& chain = placement_.chain();
  const Eigen::VectorXd* before = nullptr;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const BaseOffset& offset = path[i].offset;
    track.base.push_back(placement_.base(i, offset));
    if (!offset.zero()) {
      const double distance = std::hypot(offset.x, offset.y);
      ++track.moved;
      track.moved_distance += distance;
      track.moved_angle += std::abs(offset.yaw);
      track.farthest = std::max(track.farthest, distance);
      track.farthest_turn = std::max(track.farthest_turn, std::abs(offset.yaw));
    }
    if (!tupleGood(path, i)) ++track.unresolved;
    if (i + 1 < path.size()) {
      if (!wayFree(path, i)) ++track.blocked_steps;
      if (haste(path, i) > 1) ++track.fast_steps;
    }
  }
  for (std::size_t i = 0; i < path.size(); ++i) {
    Eigen::VectorXd& q = path[i].joints;
    for (int j = 0; before != nullptr && q.size() > 0 && j < chain.dof(); ++j) {
      if (chain.continuous(j)) q[j] = (*before)[j] + wrapAngle(q[j] - (*before)[j]);
    }
    if (q.size() > 0) ++track.joints.solved;
    const bool pair = i > 0 && q.size() > 0 && path[i - 1].joints.size() > 0;
    if (pair && placement_.speedRatio(path[i - 1].joints, q, placement_.seconds(i - 1, i)) > 1) {
      ++track.joints.too_fast;
    }
    if (q.size() > 0) before = &q;
  }
  for (Placed& placed : path) track.joints.joints.push_back(std::move(placed.joints));
  return track;
}

void TrackRefiner::repair(Path& path) const {
  const std::size_t stride = options_.stride;
  const Replan usual{stride, 1, Spread::kUsual};
  const Replan fine{2 * stride, 1, Spread::kFine};
  for (const Replan& replan : {fine, usual}) {
    if (faults(path, 0, path.size() - 1) == 0) return;
    replanBadStretches(path, replan);
  }
}

RefinedTrack TrackRefiner::run() {
  if (demo_.size() == 0) return {};
  Path optimized = asOptimized();
  const std::size_t end = demo_.size() - 1;
  if (faults(optimized, 0, end) == 0) return summarize(std::move(optimized));
  Path path = search(optimized);
  smooth(path);
  return summarize(std::move(path));
}

}  // namespace graft::lfd
