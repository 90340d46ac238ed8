// SPDX-License-Identifier: BSD-3-Clause
// Projection onto the border of the reachable set: from the nearest box onwards.
#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "types_lfd/reach/kept_set.hpp"

namespace graft::lfd {

namespace {

using Eigen::Vector3d;

// Distances are piecewise linear along each coordinate, so a difference is exact
// but at nodes; in units of sigma, meters and radians.
constexpr double kDifference = 1e-5;
constexpr double kConverged = 1e-9;

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

/// Half of space in which normal . x >= offset.
struct HalfSpace {
  Vector3d normal;
  double offset = 0;
  double violation(const Vector3d& x) const { return offset - normal.dot(x); }
};

/// The last few planes that bound the set where the projection runs.
class HalfSpaces {
 public:
  /// Forgets those that a point known to be inside contradicts.
  void add(const HalfSpace& plane, const Vector3d& inside) {
    int kept = 0;
    for (int i = 0; i < count_; ++i) {
      if (all_[i].violation(inside) <= kConverged) all_[kept++] = all_[i];
    }
    count_ = kept;
    if (count_ == kMost) {
      for (int i = 1; i < kMost; ++i) all_[i - 1] = all_[i];
      --count_;
    }
    all_[count_++] = plane;
  }

  /// The point of their intersection that is nearest to q: the best of all
  /// choices of active planes.
  Vector3d nearest(const Vector3d& q) const {
    Vector3d best = q;
    double best_square = std::numeric_limits<double>::infinity();
    for (unsigned active = 0; active < 1U << count_; ++active) {
      const Vector3d x = onPlanes(q, active);
      const double square = (x - q).squaredNorm();
      if (!(square < best_square)) continue;
      bool inside = true;
      for (int i = 0; i < count_; ++i) inside = inside && all_[i].violation(x) <= kConverged;
      if (!inside) continue;
      best = x;
      best_square = square;
    }
    return best;
  }

 private:
  static constexpr int kMost = 3;

  Vector3d onPlanes(const Vector3d& q, unsigned active) const {
    Eigen::Matrix3d gram = Eigen::Matrix3d::Identity();
    Vector3d right = Vector3d::Zero();
    for (int i = 0; i < count_; ++i) {
      if ((active >> i & 1U) == 0) continue;
      right[i] = all_[i].violation(q);
      for (int j = 0; j < count_; ++j) {
        if ((active >> j & 1U) != 0) gram(i, j) = all_[i].normal.dot(all_[j].normal);
      }
    }
    const Vector3d factors = gram.ldlt().solve(right);
    Vector3d x = q;
    for (int i = 0; i < count_; ++i) {
      if ((active >> i & 1U) != 0) x += factors[i] * all_[i].normal;
    }
    return x;
  }

  int count_ = 0;
  std::array<HalfSpace, kMost> all_;
};

/// The set that a query is projected onto, in units of sigma.
class Projection {
 public:
  Projection(const KeptSet& kept, const Scale& scale, const Vector3d& query)
      : kept_(kept), scale_(scale), query_(query) {}

  double excess(const Vector3d& p) const { return kept_.excess(scale_.pose(p)); }
  double cost(const Vector3d& p) const { return (p - query_).squaredNorm(); }

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

  /// From a point of the set to one that is no further from the query, and
  /// nearest among those around it: sequential projection onto the tangent planes.
  Vector3d approach(Vector3d p) const {
    HalfSpaces planes;
    for (int i = 0; i < kSteps; ++i) {
      const Vector3d g = gradient(p);
      const double length = g.norm();
      if (!(length > 0)) break;
      const HalfSpace plane{g / length, g.dot(p) / length - excess(p) / length};
      planes.add(plane, p);
      const Vector3d wanted = planes.nearest(query_);
      const double before = cost(p);
      Vector3d next = p;
      bool lower = false;
      for (double share = 1; share > kLeastShare; share *= 0.5) {
        const std::optional<Vector3d> point = enter(p + share * (wanted - p));
        if (!point || !(cost(*point) < before)) continue;
        next = *point;
        lower = true;
        break;
      }
      if (!lower) break;
      const bool converged = before - cost(next) <= kConverged * kConverged;
      p = next;
      if (converged) break;
    }
    return p;
  }

  const Vector3d& query() const { return query_; }

 private:
  static constexpr int kRestorations = 6;
  static constexpr int kSteps = 30;
  static constexpr double kLeastShare = 1e-3;
  const KeptSet& kept_;
  const Scale& scale_;
  Vector3d query_;
};

/// From a point that is allowed to one that is nearer, by asking only whether points
/// are allowed: along the ray from the query, and along rays turned by ever smaller
/// angles. Obstacles tell no gradient.
template <class Allowed>
Vector3d slide(const Vector3d& query, Vector3d p, const Allowed& allowed) {
  constexpr double kFirstAngle = 0.5;
  constexpr double kLastAngle = 1e-4;
  constexpr int kBisections = 30;
  const auto drawn = [&](const Vector3d& far) {
    double out = 0;
    double in = 1;
    for (int i = 0; i < kBisections; ++i) {
      const double middle = 0.5 * (in + out);
      (allowed(query + middle * (far - query)) ? in : out) = middle;
    }
    return Vector3d(query + in * (far - query));
  };
  p = drawn(p);
  for (double angle = kFirstAngle; angle > kLastAngle;) {
    const Vector3d off = p - query;
    const double length = off.norm();
    if (!(length > kConverged)) break;
    const Vector3d direction = off / length;
    const Vector3d side = direction.unitOrthogonal();
    const Vector3d up = direction.cross(side);
    // Beyond its own square nothing is to be won on a smooth border.
    const double shorter = length * (1 - 0.1 * angle * angle);
    bool moved = false;
    for (int k = 0; k < 8 && !moved; ++k) {
      const double around = k * (3.14159265358979323846 / 4);
      const Vector3d turned = std::cos(angle) * direction +
                              std::sin(angle) * (std::cos(around) * side + std::sin(around) * up);
      const Vector3d candidate = query + shorter * turned;
      if (!allowed(candidate)) continue;
      p = drawn(candidate);
      moved = true;
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
  std::optional<Vector3d> best;
  const auto consider = [&](const std::optional<Vector3d>& entered) {
    if (!entered) return;
    const Vector3d p = projection.approach(*entered);
    if (isFree(p) && (!best || projection.cost(p) < projection.cost(*best))) best = p;
  };
  consider(projection.enter(from_box));
  consider(projection.enter(query));
  if (!best) {
    const auto allowed = [&](const Vector3d& p) { return projection.excess(p) >= 0 && isFree(p); };
    best = allowed(from_box) ? slide(query, from_box, allowed) : from_box;
    constexpr double kBack = 1e-3;
    result.at_obstacle = projection.excess(*best + kBack * (query - *best)) >= 0;
  }
  result.base = inWorld(*best);
  result.cost = projection.cost(*best);
  if (result.at_obstacle) return result;

  const double length = projection.gradient(*best).norm();
  if (!(length > 0)) return result;
  const Pose2 at = scale.pose(*best);
  const auto slope = [&](double height, double elevation, double roll) {
    const auto excess = [&](double share) {
      const TiltSlice other(*this, view.position[2] + share * height,
                            view.elevation + share * elevation, view.roll + share * roll);
      return KeptSet(other, grid_.resolution, margin_t_, margin_r_).excess(at);
    };
    return -(excess(kDifference) - excess(-kDifference)) / (2 * kDifference * length);
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
