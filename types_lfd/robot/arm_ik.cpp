// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/robot/arm_ik.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace graft::lfd {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kMaxDof = Chain::kMaximumDof;
using JointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxDof, kMaxDof>;
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxDof, 1>;
using Error6 = Eigen::Matrix<double, 6, 1>;

/// [target - position; rotation vector that turns the gripper to the target],
/// in the base frame, as the Jacobian is.
Error6 poseDifference(const Pose& target, const Pose& current) {
  Error6 e;
  e.head<3>() = target.translation - current.translation;
  e.tail<3>() = logSO3(Eigen::Quaterniond(target.rotation * current.rotation.conjugate()));
  return e;
}

bool within(const Error6& e, const IkOptions& options) {
  return e.head<3>().norm() <= options.tolerance_t && e.tail<3>().norm() <= options.tolerance_r;
}

void clampToBox(const IkBox& box, Eigen::VectorXd& q) {
  q = q.cwiseMax(box.lower).cwiseMin(box.upper);
}

/// Joints that stand at a limit and would be pushed further are held.
int freeJoints(const IkBox& box, const Eigen::VectorXd& q, const JointVector& gradient, int* free) {
  int count = 0;
  for (int i = 0; i < q.size(); ++i) {
    const bool held =
        (q[i] <= box.lower[i] && gradient[i] < 0) || (q[i] >= box.upper[i] && gradient[i] > 0);
    if (!held) free[count++] = i;
  }
  return count;
}

/// (J'J + damping I) step = J'e over the free joints.
void dampedStep(const JointMatrix& normal, const JointVector& gradient, const int* free, int count,
                double damping, JointVector& step) {
  JointMatrix a(count, count);
  JointVector b(count);
  for (int i = 0; i < count; ++i) {
    b[i] = gradient[free[i]];
    for (int j = 0; j < count; ++j) a(i, j) = normal(free[i], free[j]);
    a(i, i) += damping;
  }
  const JointVector x = a.llt().solve(b);
  step.setZero();
  for (int i = 0; i < count; ++i) step[free[i]] = x[i];
}

/// Moves continuous joints by whole turns next to `reference`.
void unwind(const Chain& chain, const Eigen::VectorXd& reference, Eigen::VectorXd& q) {
  for (int i = 0; i < chain.dof(); ++i) {
    if (chain.continuous(i)) q[i] -= 2 * kPi * std::round((q[i] - reference[i]) / (2 * kPi));
  }
}

}  // namespace

IkBox::IkBox(const Chain& chain)
    : lower(chain.lower()), upper(chain.upper()), scale(Eigen::VectorXd::Ones(chain.dof())) {
  for (int i = 0; i < chain.dof(); ++i) {
    if (!chain.continuous(i)) continue;
    upper[i] = std::numeric_limits<double>::infinity();
    lower[i] = -upper[i];
  }
}

bool refineIk(const Chain& chain, const Pose& base_T_gripper, const IkOptions& options,
              Eigen::VectorXd& q) {
  return refineIk(chain, base_T_gripper, options, IkBox(chain), q);
}

bool refineIk(const Chain& chain, const Pose& base_T_gripper, const IkOptions& options,
              const IkBox& box, Eigen::VectorXd& q) {
  clampToBox(box, q);
  const int n = chain.dof();
  Chain::Jacobian jacobian(6, n);
  Chain::Jacobian trial_jacobian(6, n);
  Chain::Jacobian scaled(6, n);
  Pose pose;
  chain.jacobian(q.data(), pose, jacobian);
  Error6 e = poseDifference(base_T_gripper, pose);
  double cost = e.squaredNorm();
  double damping_factor = 1e-2;
  JointMatrix normal(n, n);
  JointVector gradient(n);
  JointVector step(n);
  Eigen::VectorXd trial(n);
  int free[kMaxDof];
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    if (within(e, options)) return !chain.hitsItself(q);
    scaled = jacobian * box.scale.asDiagonal();
    normal.noalias() = scaled.transpose().lazyProduct(scaled);
    gradient.noalias() = scaled.transpose().lazyProduct(e);
    const int count = freeJoints(box, q, gradient, free);
    if (count == 0) return false;
    dampedStep(normal, gradient, free, count, damping_factor * cost + 1e-9, step);
    step = step.cwiseProduct(box.scale);
    // Far steps leave the region where the Jacobian says anything.
    const double longest = step.cwiseAbs().maxCoeff();
    if (!std::isfinite(longest)) return false;
    if (longest > 1) step *= 1 / longest;
    trial = q + step;
    clampToBox(box, trial);
    chain.jacobian(trial.data(), pose, trial_jacobian);
    const Error6 trial_e = poseDifference(base_T_gripper, pose);
    const double trial_cost = trial_e.squaredNorm();
    if (trial_cost < cost) {
      const bool stalled = trial_cost > cost * (1 - options.stall);
      q = trial;
      e = trial_e;
      cost = trial_cost;
      jacobian.swap(trial_jacobian);
      damping_factor = std::max(damping_factor * 0.2, 1e-6);
      if (stalled && !within(e, options)) return false;
    } else {
      damping_factor *= 8;
      if (damping_factor > 1e8) return false;
    }
  }
  return within(e, options) && !chain.hitsItself(q);
}

std::optional<Eigen::VectorXd> solveIk(const Chain& chain, const Pose& base_T_gripper,
                                       const Eigen::VectorXd& start, const IkOptions& options) {
  if (start.size() != chain.dof()) {
    throw Error(ExitCode::kInternal, "solveIk: the start has " + std::to_string(start.size()) +
                                         " joints, the chain " + std::to_string(chain.dof()));
  }
  Eigen::VectorXd q = start;
  if (refineIk(chain, base_T_gripper, options, q)) {
    unwind(chain, start, q);
    return q;
  }
  // After the first success a few more attempts, to come nearer to the start.
  constexpr int kMoreAttempts = 4;
  std::mt19937_64 random(options.seed);
  std::optional<Eigen::VectorXd> best;
  double best_distance = 0;
  int left = options.restarts;
  while (left-- > 0) {
    q = sampleJoints(chain, random);
    if (!refineIk(chain, base_T_gripper, options, q)) continue;
    unwind(chain, start, q);
    const double distance = (q - start).squaredNorm();
    if (!best) left = std::min(left, kMoreAttempts);
    if (!best || distance < best_distance) {
      best = q;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace graft::lfd
