// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "types_lfd/robot/arm_ik.hpp"

namespace graft::lfd {

namespace {

using Candidates = std::vector<std::vector<Eigen::VectorXd>>;

/// Largest ratio of a joint's speed to its limit; 0 where none moves.
double speedRatio(const Chain& chain, const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                  double seconds, double scale) {
  double ratio = 0;
  for (int i = 0; i < chain.dof(); ++i) {
    const double allowed = chain.velocity()[i] * scale * seconds;
    if (std::isfinite(allowed)) ratio = std::max(ratio, std::abs(b[i] - a[i]) / allowed);
  }
  return ratio;
}

/// Follows one posture through the poses; where it is lost, another near it is
/// looked for, so that the rest is not lost, too.
class Follower {
 public:
  Follower(const Chain& chain, const std::vector<Pose>& poses, const std::vector<double>& times,
           const IkTrackOptions& options)
      : chain_(chain), poses_(poses), times_(times), options_(options) {}

  void follow(Eigen::VectorXd q, bool backwards, std::uint64_t seed, Candidates& found) const {
    const std::size_t n = poses_.size();
    IkOptions ik = options_.ik;
    // A search with restarts is made once per loss of contact: a motion that
    // leaves the arm's reach for long would else cost it at every pose.
    bool may_search = true;
    std::size_t last = backwards ? n - 1 : 0;
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = backwards ? n - 1 - k : k;
      Eigen::VectorXd next = q;
      bool ok = k > 0 && refineIk(chain_, poses_[i], ik, withinSpeed(q, i, last), next);
      if (!ok) {
        next = q;
        ok = refineIk(chain_, poses_[i], ik, next);
      }
      if (!ok && (may_search || k % 8 == 0)) {
        ik.seed = seed + i;
        const auto other = solveIk(chain_, poses_[i], q, ik);
        ok = other.has_value();
        if (ok) next = *other;
      }
      may_search = ok;
      if (!ok) continue;
      q = next;
      last = i;
      found[i].push_back(q);
    }
  }

 private:
  /// What the joints reach from q in the time between two poses.
  IkBox withinSpeed(const Eigen::VectorXd& q, std::size_t a, std::size_t b) const {
    IkBox box(chain_);
    const double seconds = std::abs(times_[b] - times_[a]);
    const double fastest =
        chain_.velocity().unaryExpr([](double v) { return std::isfinite(v) ? v : 0.0; }).maxCoeff();
    for (int i = 0; i < chain_.dof(); ++i) {
      const double v = chain_.velocity()[i] * options_.velocity_scale;
      if (!std::isfinite(v)) continue;
      // A hair less than allowed, so that rounding does not count as too fast.
      const double reach = v * seconds * (1 - 1e-9);
      box.lower[i] = std::max(box.lower[i], q[i] - reach);
      box.upper[i] = std::min(box.upper[i], q[i] + reach);
      box.scale[i] = std::clamp(chain_.velocity()[i] / fastest, 0.05, 1.0);
    }
    return box;
  }

  const Chain& chain_;
  const std::vector<Pose>& poses_;
  const std::vector<double>& times_;
  const IkTrackOptions& options_;
};

/// Postures for the pose, far from each other where there are such.
std::vector<Eigen::VectorXd> findPostures(const Chain& chain, const Pose& pose,
                                          const IkTrackOptions& options) {
  std::mt19937_64 random(options.ik.seed);
  std::vector<Eigen::VectorXd> postures;
  const int attempts = std::max(options.ik.restarts, 8 * options.postures);
  for (int i = 0; i < attempts && static_cast<int>(postures.size()) < options.postures; ++i) {
    Eigen::VectorXd q = i == 0 ? Eigen::VectorXd(0.5 * (chain.lower() + chain.upper()))
                               : sampleJoints(chain, random);
    if (!refineIk(chain, pose, options.ik, q)) continue;
    const bool known = std::any_of(postures.begin(), postures.end(), [&](const auto& p) {
      return (p - q).cwiseAbs().maxCoeff() < 0.3;
    });
    if (!known) postures.push_back(q);
  }
  return postures;
}

/// Cheapest way through the candidates by dynamic programming: steps above the
/// speed limits weigh most, then the motion.
class CheapestWay {
 public:
  CheapestWay(const Chain& chain, const Candidates& candidates, const std::vector<double>& times,
              double scale)
      : chain_(chain), candidates_(candidates), times_(times), scale_(scale) {}

  IkTrack run() {
    IkTrack track;
    track.joints.resize(candidates_.size());
    std::vector<std::size_t> solved;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (!candidates_[i].empty()) solved.push_back(i);
    }
    track.solved = solved.size();
    if (solved.empty()) return track;
    std::vector<std::vector<double>> cost(solved.size());
    std::vector<std::vector<std::size_t>> from(solved.size());
    cost[0].assign(candidates_[solved[0]].size(), 0.0);
    for (std::size_t k = 1; k < solved.size(); ++k) {
      advance(solved[k - 1], solved[k], cost[k - 1], cost[k], from[k]);
    }
    const auto& last = cost.back();
    auto choice =
        static_cast<std::size_t>(std::min_element(last.begin(), last.end()) - last.begin());
    for (std::size_t k = solved.size(); k-- > 0;) {
      track.joints[solved[k]] = candidates_[solved[k]][choice];
      if (k > 0) choice = from[k][choice];
    }
    for (std::size_t k = 1; k < solved.size(); ++k) {
      if (solved[k] == solved[k - 1] + 1 && ratio(solved[k - 1], track.joints[solved[k - 1]],
                                                  solved[k], track.joints[solved[k]]) > 1) {
        ++track.too_fast;
      }
    }
    return track;
  }

 private:
  double ratio(std::size_t i, const Eigen::VectorXd& a, std::size_t j,
               const Eigen::VectorXd& b) const {
    return speedRatio(chain_, a, b, times_[j] - times_[i], scale_);
  }

  void advance(std::size_t i, std::size_t j, const std::vector<double>& before,
               std::vector<double>& after, std::vector<std::size_t>& from) const {
    constexpr double kTooFast = 1e3;
    after.assign(candidates_[j].size(), std::numeric_limits<double>::infinity());
    from.assign(candidates_[j].size(), 0);
    for (std::size_t b = 0; b < candidates_[j].size(); ++b) {
      for (std::size_t a = 0; a < candidates_[i].size(); ++a) {
        const Eigen::VectorXd& qa = candidates_[i][a];
        const Eigen::VectorXd& qb = candidates_[j][b];
        const double excess = std::max(0.0, ratio(i, qa, j, qb) - 1);
        const double step = (qb - qa).norm() + (excess > 0 ? kTooFast * (1 + excess) : 0);
        if (before[a] + step < after[b]) {
          after[b] = before[a] + step;
          from[b] = a;
        }
      }
    }
  }

  const Chain& chain_;
  const Candidates& candidates_;
  const std::vector<double>& times_;
  double scale_;
};

}  // namespace

IkTrack solveIkAlong(const Chain& chain, const std::vector<Pose>& base_T_gripper,
                     const std::vector<double>& times, const IkTrackOptions& options) {
  if (base_T_gripper.size() != times.size()) {
    throw Error(ExitCode::kInternal, "solveIkAlong: as many times as poses are needed");
  }
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (!(times[i] > times[i - 1])) {
      throw Error(ExitCode::kInternal, "solveIkAlong: times have to rise strictly");
    }
  }
  const std::size_t n = times.size();
  Candidates found(n);
  const Follower follower(chain, base_T_gripper, times, options);
  // Postures are taken at the first pose that has any.
  std::vector<Eigen::VectorXd> postures;
  const std::size_t stride = std::max<std::size_t>(1, n / 16);
  for (std::size_t i = 0; i < n && postures.empty(); i += stride) {
    postures = findPostures(chain, base_T_gripper[i], options);
  }
  if (postures.empty() && n > 0) postures = {0.5 * (chain.lower() + chain.upper())};
  for (std::size_t p = 0; p < postures.size(); ++p) {
    const std::uint64_t seed = options.ik.seed + 1000003 * (p + 1);
    Candidates forwards(n);
    follower.follow(postures[p], false, seed, forwards);
    // Backwards from where the forward pass ended.
    const auto last =
        std::find_if(forwards.rbegin(), forwards.rend(), [](const auto& c) { return !c.empty(); });
    Eigen::VectorXd end = last != forwards.rend() ? last->front() : postures[p];
    for (std::size_t i = 0; i < n; ++i) {
      found[i].insert(found[i].end(), forwards[i].begin(), forwards[i].end());
    }
    follower.follow(std::move(end), true, seed + 7, found);
  }
  return CheapestWay(chain, found, times, options.velocity_scale).run();
}

}  // namespace graft::lfd
