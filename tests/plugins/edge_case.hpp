// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <random>
#include <string>
#include <vector>

namespace graft::testing {

/// The truth about edges: formulas in long double that share nothing with graft.
using Real = long double;
using Numbers = std::vector<Real>;

struct PlanePose {
  Real x, y, t;
};
PlanePose planePose(const Numbers& n);
PlanePose operator*(const PlanePose& a, const PlanePose& b);
PlanePose inverse(const PlanePose& a);
/// a * (x, y).
Numbers transformed(const PlanePose& a, Real x, Real y);
/// The angle in [-pi, pi] modulo a turn.
Real wrapped(Real angle);

struct SpacePose {
  Real r[3][3];
  Real t[3];
};
/// From x y z qx qy qz qw (normalised), or x y z roll pitch yaw.
SpacePose spacePose(const Numbers& n);
SpacePose eulerPose(const Numbers& n);
SpacePose operator*(const SpacePose& a, const SpacePose& b);
SpacePose inverse(const SpacePose& a);
Numbers transformed(const SpacePose& a, const Numbers& p);
/// x y z w of the unit quaternion of a rotation matrix, largest component positive.
Numbers quaternionOf(const Real r[3][3]);
/// [t; vector part of the quaternion with w >= 0].
Numbers quaternionChart(const SpacePose& m);

Numbers minus(const Numbers& a, const Numbers& b);

/// One kind of edge (tags with LOTSOF take any number of vertices): what stands in a file, and what
/// its error is.
struct EdgeCase {
  std::string tag;
  std::vector<std::string> slots;      ///< vertex tags
  std::vector<std::string> resources;  ///< resource tags
  std::string measurement;             ///< one letter a number, see randomNumber()
  std::function<Numbers(const std::vector<Numbers>& x, const std::vector<Numbers>& resources,
                        const Numbers& z)>
      error;
  /// Whether the error can be differentiated here (no jump of an angle near by).
  std::function<bool(const Numbers& e)> smooth = [](const Numbers&) { return true; };
  /// The error that smooth() looks at, if not error().
  decltype(error) looked_at = nullptr;
};

/// Random graphs of one edge: chi2 against the formula, derivatives against
/// Ridders', text through two round trips.
void checkEdgeCase(const EdgeCase& one, unsigned seed);

/// What loading a text says: all messages, or "loaded".
std::string messagesOf(const std::string& text);

}  // namespace graft::testing
