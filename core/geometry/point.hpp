// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/so3.hpp"

namespace graft {

/// A vector space as a vertex value: ambient and tangent are the same numbers.
template <class T, int N>
struct Euclidean {
  static constexpr int kAmbientDim = N;
  static constexpr int kTangentDim = N;

  Vec<T, N> coordinates = Vec<T, N>::Constant(T(0));

  static const char* normalize(double*) { return nullptr; }
  void toArray(double* p) const {
    for (int i = 0; i < N; ++i) p[i] = valueOf(coordinates[i]);
  }
  void renormalize() {}

 protected:
  void read(const double* p) {
    for (int i = 0; i < N; ++i) coordinates[i] = T(p[i]);
  }
};

/// A point in the plane, x y in metres.
template <class T = double>
struct Point2 : Euclidean<T, 2> {
  static constexpr const char* kFields = "x y";
  static Point2 fromArray(const double* p) {
    Point2 r;
    r.read(p);
    return r;
  }
  Point2 plus(const Vec<T, 2>& d) const {
    Point2 r = *this;
    r.coordinates += d;
    return r;
  }
  Vec<T, 2> minus(const Point2& o) const { return this->coordinates - o.coordinates; }
};

/// A point in space, x y z in metres.
template <class T = double>
struct Point3 : Euclidean<T, 3> {
  static constexpr const char* kFields = "x y z";
  static Point3 fromArray(const double* p) {
    Point3 r;
    r.read(p);
    return r;
  }
  Point3 plus(const Vec<T, 3>& d) const {
    Point3 r = *this;
    r.coordinates += d;
    return r;
  }
  Vec<T, 3> minus(const Point3& o) const { return this->coordinates - o.coordinates; }
};

}  // namespace graft
