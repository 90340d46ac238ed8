// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "types_lfd/motion/reproduce.hpp"

namespace graft::lfd {

/// How far the base is from touching anything, as a function of its position:
/// metres, positive where it is free, zero at contact, negative inside.
class ClearanceField {
 public:
  virtual ~ClearanceField() = default;
  virtual double clearance(double x, double y) const = 0;
  /// Gradient of the clearance; by default central differences over
  /// `differenceStep()` to each side.
  virtual Vec<double, 2> gradient(double x, double y) const;

 protected:
  /// Half the cell size for a field that is made from a grid.
  virtual double differenceStep() const { return 0.025; }
};

/// A field given by a function of x and y.
class FunctionField : public ClearanceField {
 public:
  explicit FunctionField(std::function<double(double, double)> clearance, double step = 0.025)
      : clearance_(std::move(clearance)), step_(step) {}
  double clearance(double x, double y) const override { return clearance_(x, y); }

 protected:
  double differenceStep() const override { return step_; }

 private:
  std::function<double(double, double)> clearance_;
  double step_;
};

struct AvoidanceOptions {
  double safety = 0.02;              ///< m of clearance that are kept free
  double reference_distance = 0.3;   ///< m: Gamma = 1 + (clearance - safety) / this
  double reactivity = 0.5;           ///< rho: influence falls off as Gamma^(-1/rho)
  bool release_when_leaving = true;  ///< no modulation of a velocity that leads away
  double base_speed = 0.5;           ///< m/s while following
  double largest_lag = 0.02;         ///< m behind the reference before it is slowed down
  double slowest = 5;                ///< largest factor by which it is slowed down
};

/// The velocity with its part towards the obstacle shrunk and the part along it
/// grown: M f with M = E diag(1 - g, 1 + g) E^-1, g = Gamma^(-1/rho), E = [n, t]. At
/// the boundary nothing leads inwards, so a body that follows it never enters; a
/// velocity exactly against the normal of a boundary ends there (the saddle
/// point of the method). Inside, an inward velocity becomes one that leads out.
/// Source: Khansari-Zadeh and Billard, "A dynamical system approach to realtime
/// obstacle avoidance", Autonomous Robots 32, 2012, with the clearance in place
/// of an analytic obstacle.
Vec<double, 2> modulateVelocity(const ClearanceField& field, const Vec<double, 2>& position,
                                const Vec<double, 2>& velocity, const AvoidanceOptions& options);

/// What happened on the way; nothing of it is an error by itself.
struct AvoidanceReport {
  double least_clearance = 0;    ///< m, over all points
  double largest_deviation = 0;  ///< m, base from its reference
  double final_deviation = 0;    ///< m, at the last point
  int stalled = 0;  ///< points at which the base was to move and could not (saddle, dead end)
  int inside = 0;   ///< points with less clearance than the safety distance
};

/// Follows the base of an evenly sampled motion around obstacles: at every period it heads for
/// the reference at no more than base_speed, modulated as above, a step that would
/// lose the safety distance being halved until it does not. Where the base
/// lags, the reference (gripper and yaw with it) advances more slowly, up to
/// `slowest`, as on the authors' robot; the end of every segment stays a point.
/// Gripper poses are those of the reference. Throws Error(kUsage) for options out of
/// range.
std::vector<MotionPoint> avoidObstacles(const std::vector<MotionPoint>& motion,
                                        const ClearanceField& field,
                                        const AvoidanceOptions& options,
                                        AvoidanceReport* report = nullptr);

}  // namespace graft::lfd
