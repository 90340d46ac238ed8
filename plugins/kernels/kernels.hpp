// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

// Robust kernels: rho, rho' and rho'' as functions of the squared error s >= 0,
// with w the width in g2o's conventions: in units of the error (its square for
// GemanMcClure and DCS). Values and weights are those of g2o's kernels of the
// same names, except for DCS, see there. All have rho(0) = 0 and rho'(0) = 1.

namespace graft {

struct Huber {
  static constexpr auto name = "Huber";
  static constexpr auto doc = "quadratic up to the width, then linear";
  static void evaluate(double s, double w, double* rho) {
    if (s <= w * w) {
      rho[0] = s;
      rho[1] = 1;
      rho[2] = 0;
    } else {
      const double error = std::sqrt(s);
      rho[0] = 2 * error * w - w * w;
      rho[1] = w / error;
      rho[2] = -0.5 * rho[1] / s;
    }
  }
};

struct PseudoHuber {
  static constexpr auto name = "PseudoHuber";
  static constexpr auto doc = "smooth form of Huber, 2 w^2 (sqrt(1 + s/w^2) - 1)";
  static void evaluate(double s, double w, double* rho) {
    const double scaled = 1 + s / (w * w);
    const double root = std::sqrt(scaled);
    // 2 w^2 (root - 1) without the cancellation near s = 0.
    rho[0] = 2 * s / (root + 1);
    rho[1] = 1 / root;
    rho[2] = -0.5 / (w * w * scaled * root);
  }
};

struct Cauchy {
  static constexpr auto name = "Cauchy";
  static constexpr auto doc = "w^2 log(1 + s/w^2)";
  static void evaluate(double s, double w, double* rho) {
    const double w2 = w * w;
    rho[0] = w2 * std::log1p(s / w2);
    rho[1] = 1 / (1 + s / w2);
    rho[2] = -rho[1] * rho[1] / w2;
  }
};

struct GemanMcClure {
  static constexpr auto name = "GemanMcClure";
  static constexpr auto doc = "w s / (w + s); the width is in units of the squared error";
  static void evaluate(double s, double w, double* rho) {
    const double share = w / (w + s);
    rho[0] = s * share;
    rho[1] = share * share;
    rho[2] = -2 * rho[1] * share / w;
  }
};

struct Welsch {
  static constexpr auto name = "Welsch";
  static constexpr auto doc = "w^2 (1 - exp(-s/w^2))";
  static void evaluate(double s, double w, double* rho) {
    const double w2 = w * w;
    rho[0] = -w2 * std::expm1(-s / w2);
    rho[1] = std::exp(-s / w2);
    rho[2] = -rho[1] / w2;
  }
};

struct Fair {
  static constexpr auto name = "Fair";
  static constexpr auto doc = "2 w^2 (e/w - log(1 + e/w)) with e = sqrt(s)";
  static void evaluate(double s, double w, double* rho) {
    const double error = std::sqrt(s);
    const double ratio = error / w;
    rho[0] = 2 * w * w * (ratio - std::log1p(ratio));
    rho[1] = 1 / (1 + ratio);
    // rho'' grows without bound at s = 0; s * rho'', which is what a solver
    // uses, goes to 0, and a finite value keeps it so.
    rho[2] = s > 0 ? -0.5 * rho[1] * rho[1] / (error * w) : 0;
    if (ratio < 1e-4) rho[0] = s * (1 - ratio * (2.0 / 3.0) + ratio * ratio * 0.5);
  }
};

struct Tukey {
  static constexpr auto name = "Tukey";
  static constexpr auto doc = "biweight: constant w^2/3 beyond the width";
  static void evaluate(double s, double w, double* rho) {
    const double w2 = w * w;
    if (s <= w2) {
      const double rest = 1 - s / w2;
      // w^2 (1 - rest^3) / 3, expanded.
      rho[0] = s * (1 + rest + rest * rest) / 3;
      rho[1] = rest * rest;
      rho[2] = -2 * rest / w2;
    } else {
      rho[0] = w2 / 3;
      rho[1] = rho[2] = 0;
    }
  }
};

struct Saturated {
  static constexpr auto name = "Saturated";
  static constexpr auto doc = "quadratic up to the width, then constant";
  static void evaluate(double s, double w, double* rho) {
    const bool inside = s <= w * w;
    rho[0] = inside ? s : w * w;
    rho[1] = inside ? 1 : 0;
    rho[2] = 0;
  }
};

/// Dynamic covariance scaling (Agarwal, Tipaldi, Spinello, Stachniss, Burgard, ICRA 2013):
/// weight min(1, 2w/(w+s))^2. The cost is the one whose derivative is that weight
/// (MacTavish and Barfoot, "At all costs", 2015, table 1). The only kernel that is not
/// g2o's: there the cost is weight times s, which beyond w falls from w back to 0, so
/// that its derivative, which g2o takes as the weight, is negative. Errors would be
/// driven apart, and no solver that lets its cost fall could use it.
struct Dcs {
  static constexpr auto name = "DCS";
  static constexpr auto doc =
      "dynamic covariance scaling; the width is in units of the squared error";
  static void evaluate(double s, double w, double* rho) {
    if (s <= w) {
      rho[0] = s;
      rho[1] = 1;
      rho[2] = 0;
    } else {
      const double share = w / (w + s);
      rho[0] = share * (3 * s - w);
      rho[1] = 4 * share * share;
      rho[2] = -2 * rho[1] / (w + s);
    }
  }
};

}  // namespace graft
