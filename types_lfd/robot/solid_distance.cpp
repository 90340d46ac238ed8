// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/robot/solid_distance.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace graft::lfd {

namespace {

using Vector = Eigen::Vector3d;

constexpr int kMostIterations = 100;
constexpr double kTolerance = 1e-7;  // m, of the distance
constexpr double kTouching = 1e-10;  // m

/// A solid is a core, whose furthest points are known, and a ball around it.
double ballRadius(const PlacedSolid& solid) {
  return solid.type == UrdfSolid::Type::kSphere ? solid.half[0] : 0;
}

/// The core's furthest point in a direction.
Vector furthest(const PlacedSolid& solid, const Vector& direction) {
  if (solid.type == UrdfSolid::Type::kSphere) return solid.center;
  const Vector d = solid.rotation.transpose() * direction;
  Vector p = Vector::Zero();
  if (solid.type == UrdfSolid::Type::kBox) {
    for (int k = 0; k < 3; ++k) p[k] = d[k] < 0 ? -solid.half[k] : solid.half[k];
  } else {
    const double across = std::hypot(d[0], d[1]);
    if (across > 0) {
      p[0] = solid.half[0] * d[0] / across;
      p[1] = solid.half[0] * d[1] / across;
    }
    p[2] = d[2] < 0 ? -solid.half[1] : solid.half[1];
  }
  return solid.center + solid.rotation * p;
}

/// Points of the difference of two cores, at most four.
struct Simplex {
  Vector points[4];
  int count = 0;
};

/// The point of a face of the simplex (its points by bits) that is nearest to the
/// origin; false if that lies not within the face.
bool nearestOfFace(const Simplex& simplex, int face, Vector& nearest) {
  int index[4];
  int n = 0;
  for (int i = 0; i < simplex.count; ++i) {
    if ((face >> i & 1) != 0) index[n++] = i;
  }
  if (n == 0) return false;
  const Vector& base = simplex.points[index[0]];
  if (n == 1) {
    nearest = base;
    return true;
  }
  // base + edges x, with x such that the residual is square to all edges.
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> edges(3, n - 1);
  for (int k = 1; k < n; ++k) edges.col(k - 1) = simplex.points[index[k]] - base;
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> gram =
      edges.transpose().lazyProduct(edges);
  const Eigen::FullPivLU<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>> lu(gram);
  if (!lu.isInvertible()) return false;
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> right = -(edges.transpose() * base);
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> x = lu.solve(right);
  if (x.minCoeff() < 0 || x.sum() > 1) return false;
  nearest = base + edges * x;
  return true;
}

/// Keeps of the simplex the face nearest to the origin; its nearest point.
Vector reduce(Simplex& simplex) {
  Vector best = Vector::Zero();
  double best_length = std::numeric_limits<double>::infinity();
  int best_face = 1;
  for (int face = 1; face < 1 << simplex.count; ++face) {
    Vector nearest;
    if (!nearestOfFace(simplex, face, nearest)) continue;
    const double length = nearest.squaredNorm();
    if (length < best_length) {
      best = nearest;
      best_length = length;
      best_face = face;
    }
  }
  int kept = 0;
  for (int i = 0; i < simplex.count; ++i) {
    if ((best_face >> i & 1) != 0) simplex.points[kept++] = simplex.points[i];
  }
  simplex.count = kept;
  return best;
}

/// Distance of the cores; stops where it is known to exceed `enough`.
double coreDistance(const PlacedSolid& a, const PlacedSolid& b, double enough) {
  Simplex simplex;
  Vector nearest = a.center - b.center;
  simplex.points[simplex.count++] = nearest;
  // The centers' difference is a point of the difference, though no corner of it.
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const double distance = nearest.norm();
    if (distance < kTouching) return 0;
    const Vector point = furthest(a, -nearest) - furthest(b, nearest);
    // All of the difference lies beyond the plane through `point`.
    const double least = point.dot(nearest) / distance;
    if (least > enough || distance - least < kTolerance) return distance;
    simplex.points[simplex.count++] = point;
    nearest = reduce(simplex);
    if (simplex.count == 4) return 0;
  }
  return nearest.norm();
}

}  // namespace

double PlacedSolid::bound() const {
  switch (type) {
    case UrdfSolid::Type::kBox:
      return half.norm();
    case UrdfSolid::Type::kCylinder:
      return std::hypot(half[0], half[1]);
    case UrdfSolid::Type::kSphere:
      break;
  }
  return half[0];
}

double solidDistance(const PlacedSolid& a, const PlacedSolid& b) {
  const double balls = ballRadius(a) + ballRadius(b);
  return std::max(0.0, coreDistance(a, b, std::numeric_limits<double>::infinity()) - balls);
}

bool solidsOverlap(const PlacedSolid& a, const PlacedSolid& b) {
  const double balls = ballRadius(a) + ballRadius(b);
  return coreDistance(a, b, balls) <= balls + kTolerance;
}

}  // namespace graft::lfd
