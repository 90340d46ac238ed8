// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace graft {

/// Forward-mode dual number: a value and N partial derivatives, propagated by
/// the chain rule. Exact to rounding; no step size. N is fixed at compile time
/// so that the loops below unroll and nothing is allocated.
/// Source: Griewank and Walther, "Evaluating Derivatives", 2nd ed., ch. 3.
template <int N>
struct Dual {
  double v = 0;
  double d[N] = {};

  Dual() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): numbers mix freely in formulas.
  Dual(double value) : v(value) {}

  /// The independent variable with index `i`.
  static Dual variable(double value, int i) {
    Dual x(value);
    x.d[i] = 1;
    return x;
  }

  /// f(x) given f and f' at x.v.
  Dual chain(double f, double slope) const {
    Dual r(f);
    for (int i = 0; i < N; ++i) r.d[i] = slope * d[i];
    return r;
  }

  Dual operator-() const { return chain(-v, -1.0); }

  Dual& operator+=(const Dual& o) {
    v += o.v;
    for (int i = 0; i < N; ++i) d[i] += o.d[i];
    return *this;
  }
  Dual& operator-=(const Dual& o) {
    v -= o.v;
    for (int i = 0; i < N; ++i) d[i] -= o.d[i];
    return *this;
  }
  Dual& operator*=(const Dual& o) {
    for (int i = 0; i < N; ++i) d[i] = d[i] * o.v + v * o.d[i];
    v *= o.v;
    return *this;
  }
  Dual& operator/=(const Dual& o) {
    const double inverse = 1.0 / o.v;
    const double quotient = v * inverse;
    for (int i = 0; i < N; ++i) d[i] = (d[i] - quotient * o.d[i]) * inverse;
    v = quotient;
    return *this;
  }

  friend Dual operator+(Dual a, const Dual& b) { return a += b; }
  friend Dual operator-(Dual a, const Dual& b) { return a -= b; }
  friend Dual operator*(Dual a, const Dual& b) { return a *= b; }
  friend Dual operator/(Dual a, const Dual& b) { return a /= b; }
  friend Dual operator+(Dual a, double b) {
    a.v += b;
    return a;
  }
  friend Dual operator+(double a, Dual b) { return b + a; }
  friend Dual operator-(Dual a, double b) {
    a.v -= b;
    return a;
  }
  friend Dual operator-(double a, const Dual& b) { return b.chain(a - b.v, -1.0); }
  friend Dual operator*(const Dual& a, double b) { return a.chain(a.v * b, b); }
  friend Dual operator*(double a, const Dual& b) { return b.chain(a * b.v, a); }
  friend Dual operator/(const Dual& a, double b) { return a * (1.0 / b); }

  // Comparisons look at the value alone: a branch has the derivative of the
  // side that is taken.
  friend bool operator<(const Dual& a, const Dual& b) { return a.v < b.v; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.v > b.v; }
  friend bool operator<=(const Dual& a, const Dual& b) { return a.v <= b.v; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.v >= b.v; }
  friend bool operator==(const Dual& a, const Dual& b) { return a.v == b.v; }
  friend bool operator!=(const Dual& a, const Dual& b) { return a.v != b.v; }

  friend Dual sqrt(const Dual& x) {
    const double root = std::sqrt(x.v);
    return x.chain(root, 0.5 / root);
  }
  friend Dual sin(const Dual& x) { return x.chain(std::sin(x.v), std::cos(x.v)); }
  friend Dual cos(const Dual& x) { return x.chain(std::cos(x.v), -std::sin(x.v)); }
  friend Dual tan(const Dual& x) {
    const double t = std::tan(x.v);
    return x.chain(t, 1 + t * t);
  }
  friend Dual exp(const Dual& x) {
    const double e = std::exp(x.v);
    return x.chain(e, e);
  }
  friend Dual log(const Dual& x) { return x.chain(std::log(x.v), 1.0 / x.v); }
  friend Dual abs(const Dual& x) { return x.v < 0 ? -x : x; }
  friend Dual asin(const Dual& x) {
    return x.chain(std::asin(x.v), 1.0 / std::sqrt(1 - x.v * x.v));
  }
  friend Dual acos(const Dual& x) {
    return x.chain(std::acos(x.v), -1.0 / std::sqrt(1 - x.v * x.v));
  }
  /// At the origin, where there is no direction, all derivatives are 0: a number
  /// that is not finite would spoil more than this edge.
  friend Dual atan2(const Dual& y, const Dual& x) {
    Dual r(std::atan2(y.v, x.v));
    if (x.v == 0 && y.v == 0) return r;
    const double scale = 1.0 / (x.v * x.v + y.v * y.v);
    for (int i = 0; i < N; ++i) r.d[i] = scale * (x.v * y.d[i] - y.v * x.d[i]);
    return r;
  }
};

/// The plain value of a scalar, for branches on it.
inline double valueOf(double x) { return x; }
template <int N>
double valueOf(const Dual<N>& x) {
  return x.v;
}

}  // namespace graft

namespace Eigen {
template <int N>
struct NumTraits<graft::Dual<N>> : NumTraits<double> {
  using Real = graft::Dual<N>;
  using NonInteger = graft::Dual<N>;
  using Nested = graft::Dual<N>;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = N,
    AddCost = N,
    MulCost = 3 * N
  };
};
template <int N, class BinaryOp>
struct ScalarBinaryOpTraits<graft::Dual<N>, double, BinaryOp> {
  using ReturnType = graft::Dual<N>;
};
template <int N, class BinaryOp>
struct ScalarBinaryOpTraits<double, graft::Dual<N>, BinaryOp> {
  using ReturnType = graft::Dual<N>;
};
}  // namespace Eigen
