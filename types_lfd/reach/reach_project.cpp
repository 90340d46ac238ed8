// SPDX-License-Identifier: BSD-3-Clause
// Projection onto the border of the reachable set: from the nearest box onwards.
#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "types_lfd/reach/kept_set.hpp"

namespace graft::lfd {

namespace {

using Eigen::Vector3d;

// Distances are piecewise linear along each coordinate, so a difference is exact
// but at nodes; in units of sigma, meters and radians.
constexpr double kDifference = 1e-5;
constexpr double kConverged = 1e-9;  // in units of sigma, and of the map's distances
// Squared, in units of sigma: rounding alone may tell a scene from the same scene moved.
constexpr double kStandstill = 1e-20;

/// Base poses in the gripper's view in units of sigma: (x / s_t, y / s_t, psi / s_r).
class Scale {
 public:
  Scale(double sigma_t, double sigma_r) : sigma_(sigma_t, sigma_t, sigma_r) {}
  Vector3d scaled(const Pose2& b) const {
    return Vector3d(b.x, b.y, b.theta).cwiseQuotient(sigma_);
  }
  Pose2 pose(const Vector3d& p) const {
    const Vector3d b = p.cwiseProduct(sigma_);
    return Pose2(b[0], b[1], b[2]);
  }
  const Vector3d& sigma() const { return sigma_; }

 private:
  Vector3d sigma_;
};

/// Half of space in which normal . x >= offset, and where its plane was found.
struct HalfSpace {
  Vector3d normal;
  double offset = 0;
  double length = 0;  ///< of the gradient there
  Vector3d point;
  double violation(const Vector3d& x) const { return offset - normal.dot(x); }
};

/// The last few planes that bound the set where the projection runs.
class HalfSpaces {
 public:
  struct Nearest {
    Vector3d point;
    unsigned active = 0;
    Vector3d factors = Vector3d::Zero();  ///< of the active normals, in order
  };

  /// Forgets those that a point known to be inside contradicts, and beyond that the oldest.
  void add(const HalfSpace& plane, const Vector3d& inside) {
    int kept = 0;
    for (int i = 0; i < count_; ++i) {
      if (all_[i].violation(inside) <= kTight) all_[kept++] = all_[i];
    }
    count_ = kept;
    if (count_ == kMost) {
      for (int i = 1; i < kMost; ++i) all_[i - 1] = all_[i];
      --count_;
    }
    all_[count_++] = plane;
  }

  /// The point of their intersection that is nearest to q: the nearest of all choices of
  /// at most three active planes.
  Nearest nearest(const Vector3d& q) const {
    Nearest best;
    best.point = q;
    double best_square = std::numeric_limits<double>::infinity();
    for (unsigned active = 0; active < 1U << count_; ++active) {
      if (__builtin_popcount(active) > 3) continue;
      const Nearest on = onPlanes(q, active);
      const double square = (on.point - q).squaredNorm();
      if (!(square < best_square) || !contains(on.point)) continue;
      best = on;
      best_square = square;
    }
    return best;
  }

  /// Sum over the active planes of factor times what `of` makes of the plane.
  template <class Of>
  double sumOfActive(const Nearest& at, const Of& of) const {
    double sum = 0;
    int next = 0;
    for (int i = 0; i < count_; ++i) {
      if ((at.active >> i & 1U) != 0) sum += at.factors[next++] * of(all_[i]);
    }
    return sum;
  }

 private:
  static constexpr int kMost = 4;
  static constexpr double kTight = 1e-7;

  bool contains(const Vector3d& x) const {
    for (int i = 0; i < count_; ++i) {
      if (!(all_[i].violation(x) <= kTight)) return false;
    }
    return true;
  }

  Nearest onPlanes(const Vector3d& q, unsigned active) const {
    Nearest result{q, active, Vector3d::Zero()};
    int chosen[3];
    int n = 0;
    for (int i = 0; i < count_; ++i) {
      if ((active >> i & 1U) != 0) chosen[n++] = i;
    }
    if (n == 0) return result;
    Eigen::Matrix3d gram = Eigen::Matrix3d::Identity();
    Vector3d right = Vector3d::Zero();
    for (int i = 0; i < n; ++i) {
      right[i] = all_[chosen[i]].violation(q);
      for (int j = 0; j < n; ++j) gram(i, j) = all_[chosen[i]].normal.dot(all_[chosen[j]].normal);
    }
    result.factors = n == 1 ? right : Vector3d(gram.inverse() * right);
    for (int i = 0; i < n; ++i) result.point += result.factors[i] * all_[chosen[i]].normal;
    return result;
  }

  int count_ = 0;
  std::array<HalfSpace, kMost> all_;
};

/// Where a projection has come to.
struct Approached {
  Vector3d point;
  HalfSpaces planes;
};

/// The set that a query is projected onto, in units of sigma.
class Projection {
 public:
  Projection(const KeptSet& kept, const Scale& scale, const Vector3d& query)
      : kept_(kept), scale_(scale), query_(query) {}

  double excess(const Vector3d& p) const { return kept_.excess(scale_.pose(p)); }
  double cost(const Vector3d& p) const { return (p - query_).squaredNorm(); }

  /// Newton's method from anywhere to the set, along the gradient at each point.
  std::optional<Vector3d> enter(Vector3d p) const {
    for (int i = 0; i < kRestorations; ++i) {
      const double e = excess(p);
      if (e >= 0) return p;
      const Vector3d g = gradient(p);
      const double square = g.squaredNorm();
      if (!(square > 0)) return std::nullopt;
      // A little more than needed, lest rounding leaves it outside.
      p += (kConverged - e) / square * g;
    }
    return excess(p) >= 0 ? std::optional<Vector3d>(p) : std::nullopt;
  }

  /// From a point of the set to one that is no further from the query, and nearest among
  /// those around it: a bundle of tangent planes, to whose intersection's nearest point it
  /// goes where that is nearer, and which otherwise takes in the plane found there.
  Approached approach(Vector3d p) const {
    Approached at{draw(p), HalfSpaces()};
    at.planes.add(tangent(at.point), at.point);
    int rejected = 0;
    for (int i = 0; i < kSteps; ++i) {
      const Vector3d wanted = at.planes.nearest(query_).point;
      if ((wanted - at.point).squaredNorm() < kStandstill) break;
      if (advance(wanted, at)) {
        rejected = 0;
        continue;
      }
      const HalfSpace there = tangent(wanted);
      if (++rejected <= kMostRejected && there.length > 0 && there.violation(wanted) > 1e-8 &&
          there.violation(at.point) <= 1e-7) {
        at.planes.add(there, at.point);
        continue;
      }
      bool moved = false;
      for (double share = 0.5; share > kLeastShare && !moved; share *= 0.5) {
        moved = advance(at.point + share * (wanted - at.point), at);
      }
      if (!moved) break;
      rejected = 0;
    }
    return at;
  }

  /// The planes that hold the point where it is, found next to it.
  HalfSpaces holding(const Approached& at) const {
    constexpr double kNear = 1e-3;
    HalfSpaces held;
    at.planes.sumOfActive(at.planes.nearest(query_), [&](const HalfSpace& plane) {
      const Vector3d aside = plane.point - at.point;
      const double share = std::min(1.0, kNear / aside.norm());
      const HalfSpace here = tangent(aside.norm() > 0 ? at.point + share * aside : at.point);
      if (here.length > 0) held.add(here, at.point);
      return 0.0;
    });
    return held;
  }

  const Vector3d& query() const { return query_; }

 private:
  Vector3d gradient(const Vector3d& p) const {
    Vector3d g;
    for (int i = 0; i < 3; ++i) {
      const double step = kDifference / scale_.sigma()[i];
      Vector3d low = p;
      Vector3d high = p;
      low[i] -= step;
      high[i] += step;
      g[i] = (excess(high) - excess(low)) / (2 * step);
    }
    return g;
  }

  HalfSpace tangent(const Vector3d& p) const {
    const Vector3d g = gradient(p);
    const double length = g.norm();
    if (!(length > 0)) return {Vector3d::Zero(), 0, 0, p};
    return {g / length, (g.dot(p) - excess(p)) / length, length, p};
  }

  /// Goes to the set near `wanted`, if that is nearer to the query.
  bool advance(const Vector3d& wanted, Approached& at) const {
    const std::optional<Vector3d> entered = enter(wanted);
    if (!entered) return false;
    const Vector3d p = draw(*entered);
    if (!(cost(p) < cost(at.point) * (1 - 1e-9))) return false;
    at.point = p;
    at.planes.add(tangent(p), p);
    return true;
  }

  /// From a point of the set towards the query to where the set ends, by secants that keep
  /// the border between them.
  Vector3d draw(const Vector3d& p) const {
    double in = 1;
    double out = 0;
    double in_excess = excess(p);
    double out_excess = excess(query_);
    if (out_excess >= 0) return query_;
    for (int i = 0; i < kDraws && in_excess > 4 * kConverged; ++i) {
      // Every other time by halves, lest one end stays.
      const double share = i % 2 == 0 ? -out_excess / (in_excess - out_excess) : 0.5;
      const double middle = out + std::clamp(share, 0.01, 0.99) * (in - out);
      const double e = excess(query_ + middle * (p - query_));
      (e >= 0 ? in : out) = middle;
      (e >= 0 ? in_excess : out_excess) = e;
    }
    return query_ + in * (p - query_);
  }

  static constexpr int kRestorations = 6;
  static constexpr int kSteps = 30;
  static constexpr int kMostRejected = 6;
  static constexpr int kDraws = 40;
  static constexpr double kLeastShare = 1e-2;
  const KeptSet& kept_;
  const Scale& scale_;
  Vector3d query_;
};

/// From a point that is allowed to one that is nearer, by asking only whether points
/// are allowed: along the ray from the query, and along rays turned by ever smaller
/// angles. Obstacles tell no gradient.
template <class Allowed>
Vector3d slide(const Vector3d& query, Vector3d p, const Allowed& allowed) {
  constexpr double kFirstAngle = 0.4;
  constexpr double kLastAngle = 1e-3;
  constexpr int kBisections = 20;
  // Nearer along the ray, first by `gap` of its length, then by twice that, and so on, then
  // to the border in between.
  const auto draw = [&](const Vector3d& far, double gap) {
    double in = 1;
    double out = std::max(0.0, in - gap);
    while (out > 0 && allowed(query + out * (far - query))) {
      in = out;
      gap *= 2;
      out = std::max(0.0, in - gap);
    }
    for (int i = 0; i < kBisections; ++i) {
      const double middle = 0.5 * (in + out);
      (allowed(query + middle * (far - query)) ? in : out) = middle;
    }
    return Vector3d(query + in * (far - query));
  };
  p = draw(p, 1);
  for (double angle = kFirstAngle; angle > kLastAngle;) {
    const Vector3d off = p - query;
    const double length = off.norm();
    if (!(length > kConverged)) break;
    const Vector3d direction = off / length;
    const Vector3d side = direction.unitOrthogonal();
    const Vector3d up = direction.cross(side);
    // On a smooth border there is no more to be won by a turn than its square.
    const double gain = 0.1 * angle * angle;
    bool moved = false;
    for (const Vector3d& aside : {side, Vector3d(-side), up, Vector3d(-up)}) {
      const Vector3d candidate =
          query + (1 - gain) * length * (std::cos(angle) * direction + std::sin(angle) * aside);
      if (!allowed(candidate)) continue;
      p = draw(candidate, gain);
      moved = true;
      break;
    }
    if (!moved) angle *= 0.5;
  }
  return p;
}

}  // namespace

ProjectedBase ReachMap::project(const Pose& world_T_gripper, const Pose2& world_T_base,
                                double sigma_t, double sigma_r, const BaseFilter* filter) const {
  ProjectedBase result;
  static_cast<NearestBase&>(result) =
      nearest(world_T_gripper, world_T_base, sigma_t, sigma_r, filter);
  const GripperView view = ReachGrid::view(world_T_gripper);
  const TiltSlice slice(*this, view.position[2], view.elevation, view.roll);
  if (result.inside || !result.found || !slice.any()) return result;

  const KeptSet kept(slice, grid_.resolution, margin_t_, margin_r_);
  const Scale scale(sigma_t, sigma_r);
  const Pose2 in_view = baseInView(view, world_T_base);
  const Projection projection(kept, scale, scale.scaled(in_view));
  const Vector3d& query = projection.query();
  Pose2 start = baseInView(view, result.base);
  start.theta = in_view.theta + wrapAngle(start.theta - in_view.theta);
  const Vector3d from_box = scale.scaled(start);
  const auto inWorld = [&](const Vector3d& p) { return baseInWorld(view, scale.pose(p)); };
  const auto isFree = [&](const Vector3d& p) {
    return filter == nullptr || filter->isFree(inWorld(p));
  };

  // From the box, and straight from the query, which may be nearer to the border
  // than to any box.
  std::optional<Approached> best;
  const auto consider = [&](const std::optional<Vector3d>& entered) {
    if (!entered) return;
    const Approached at = projection.approach(*entered);
    if (best && projection.cost(at.point) >= projection.cost(best->point)) return;
    if (isFree(at.point)) best = at;
  };
  consider(projection.enter(from_box));
  if (std::getenv("QS")) consider(projection.enter(query));
  if (!best) {
    const auto allowed = [&](const Vector3d& p) { return projection.excess(p) >= 0 && isFree(p); };
    const Vector3d p = allowed(from_box) ? slide(query, from_box, allowed) : from_box;
    constexpr double kBack = 1e-3;
    result.at_obstacle = projection.excess(p + kBack * (query - p)) >= 0;
    result.base = inWorld(p);
    result.cost = projection.cost(p);
    return result;
  }
  result.base = inWorld(best->point);
  result.cost = projection.cost(best->point);
  const HalfSpaces held = projection.holding(*best);
  const HalfSpaces::Nearest at = held.nearest(query);
  const double distance = std::sqrt(result.cost);
  if (!(distance > 0)) return result;
  // By the envelope theorem: the planes' factors times how the planes move.
  const auto slope = [&](double height, double elevation, double roll) {
    const auto excess = [&](double share, const Vector3d& p) {
      const TiltSlice other(*this, view.position[2] + share * height,
                            view.elevation + share * elevation, view.roll + share * roll);
      return KeptSet(other, grid_.resolution, margin_t_, margin_r_).excess(scale.pose(p));
    };
    return -held.sumOfActive(at, [&](const HalfSpace& plane) {
      return (excess(kDifference, plane.point) - excess(-kDifference, plane.point)) /
             (2 * kDifference * plane.length);
    }) / distance;
  };
  result.by_height = slope(1, 0, 0);
  constexpr double kSteep = 1.17809724509617246;  // 67.5 degrees
  if (std::abs(view.elevation) < kSteep) {
    result.by_elevation = slope(0, 1, 0);
    if (grid_.rolls > 1) result.by_roll = slope(0, 0, 1);
  }
  return result;
}

}  // namespace graft::lfd
