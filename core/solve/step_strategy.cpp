// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/step_strategy.hpp"

#include <algorithm>
#include <cmath>

namespace graft {

namespace {

using Kind = StepResult::Kind;

constexpr double kSmallestGain = 1e-4;    ///< a step must bring this share of what is predicted
constexpr double kRounding = 1e-13;       ///< of chi2: less is not a change
constexpr double kLargestDamping = 1e12;  ///< beyond, steps are too short to matter
constexpr double kSmallestDamping = 1e-16;
/// Less damping than this hardly shortens a step: after a refusal there is no need to
/// climb through what full steps have lowered it to.
constexpr double kSmallestRaised = 1e-8;
/// With edges that choose what they measure to: full steps have no quadratic end there,
/// and with less damping directions that hardly anything holds amplify rounding.
constexpr double kSmallestAssociated = 1e-6;
/// Nor do dampings below this keep a step from running into what anticipation did not
/// clear: those that work again are larger.
constexpr double kSmallestRaisedAssociated = 1e-3;
constexpr double kFullStepDamping = 1e-6;
constexpr int kTrials = 10;  ///< per iteration
/// Refused steps that are taken anew with what they ran into, per iteration. Half-planes
/// that are out of sight until crossed (dead zones) need it as active sets do.
constexpr int kAnticipations = 2;

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// sum of a_i^2 w_i.
double weightedSquare(const std::vector<double>& a, const std::vector<double>& w) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * a[i] * w[i];
  return sum;
}

bool isRounding(double predicted, double chi2) { return predicted <= kRounding * chi2; }

StepResult stuck(double damping, const char* reason) {
  return {Kind::kStuck, damping, true, reason};
}

const char* const kNothingToGain = "the predicted change of chi2 is below rounding";
const char* const kNoLowerChi2 = "no step along the gradient lowers chi2 further";

/// Damped normal equations (H + lambda D) dx = -g with D = diag(H) (Marquardt
/// 1963). The gain ratio compares the true robust chi2 with the model. After
/// refused steps damping grows as in Nielsen, "Damping parameter in Marquardt's
/// method", 1999: by 2, 4, 8, ... so that a wrong start costs few trials.
class LevenbergMarquardt : public StepStrategy {
 public:
  explicit LevenbergMarquardt(double damping) : damping_(damping) {}

  StepResult iterate(SolveContext& context) override {
    std::vector<double>& step = context.step();
    diagonal_.resize(step.size());
    StepResult result;
    if (context.hasAssociations()) damping_ = std::max(damping_, kSmallestAssociated);
    int anticipations = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      if (damping_ > kLargestDamping) {
        if (!last_failure_.empty()) return {Kind::kFailed, damping_, false, last_failure_};
        return stuck(damping_, kNoLowerChi2);
      }
      result.damping = damping_;
      for (std::size_t i = 0; i < step.size(); ++i) diagonal_[i] = damping_ * context.scale()[i];
      LinearOutcome outcome = context.factorize(diagonal_.data());
      if (outcome.ok) outcome = context.solveForStep();
      if (!outcome.ok) {
        last_failure_ = context.describe(outcome);
        raise();
        continue;
      }
      last_failure_.clear();
      // F - model(dx) = -2 g'dx - dx'H dx = -g'dx + dx'(lambda D)dx.
      const double predicted = -dot(context.gradient(), step) + weightedSquare(step, diagonal_);
      const bool finite = context.evaluateTrial();
      const double gain = finite ? (context.chi2() - context.trialChi2()) / predicted : -1;
      if (finite && predicted > 0 && gain > kSmallestGain) {
        result.kind = Kind::kAccepted;
        result.full = damping_ <= kFullStepDamping;
        context.acceptTrial();
        lower(gain);
        growth_ = 2;
        return result;
      }
      if (finite && context.hasAssociations() && anticipations < kAnticipations) {
        ++anticipations;
        if (context.anticipate()) continue;
      }
      if (!context.withdraw()) return result;
      if (finite && context.hasAssociations()) {
        damping_ = std::max(damping_, kSmallestRaisedAssociated / growth_);
      }
      if (isRounding(predicted, context.chi2())) return stuck(damping_, kNothingToGain);
      raise();
    }
    return result;
  }

 private:
  void raise() {
    damping_ = std::max(damping_ * growth_, kSmallestRaised);
    growth_ *= 2;
  }
  /// Faster down than Nielsen's rule where the model is merely fair: long loops
  /// bend, so that their gain stays near one half, and the least damping makes
  /// their long waves creep.
  void lower(double gain) {
    const double factor = gain > 0.75 ? 0.1 : (gain > 0.25 ? 0.3 : 2.0);
    damping_ = std::max(damping_ * factor, kSmallestDamping);
  }

  double damping_;
  double growth_ = 2;
  std::string last_failure_;
  std::vector<double> diagonal_;
};

/// Full steps of the undamped model, halved until chi2 falls.
class GaussNewton : public StepStrategy {
 public:
  StepResult iterate(SolveContext& context) override {
    LinearOutcome outcome = context.factorize(nullptr);
    if (outcome.ok) outcome = context.solveForStep();
    if (!outcome.ok) return {Kind::kFailed, 0, false, context.describe(outcome)};
    std::vector<double>& step = context.step();
    const double slope = -dot(context.gradient(), step);
    for (int trial = 0; trial < kHalvings; ++trial) {
      const bool finite = context.evaluateTrial();
      if (finite && context.chi2() - context.trialChi2() > 0) {
        context.acceptTrial();
        return {Kind::kAccepted, 0, trial == 0, {}};
      }
      if (isRounding(slope, context.chi2())) return stuck(0, kNothingToGain);
      for (double& entry : step) entry *= 0.5;
    }
    return stuck(0, kNoLowerChi2);
  }

 private:
  static constexpr int kHalvings = 30;
};

/// Powell's dogleg: the shorter way from the steepest-descent minimum to the
/// Gauss-Newton point, cut at a radius that follows the gain ratio. Lengths are
/// measured in units of sqrt(diag(H)). Source: Powell, "A new algorithm for
/// unconstrained optimization", 1970.
class Dogleg : public StepStrategy {
 public:
  StepResult iterate(SolveContext& context) override {
    StepResult result;
    if (!factorize(context, result)) return result;
    std::vector<double>& step = context.step();
    const std::vector<double> newton = step;
    const std::vector<double> cauchy = cauchyStep(context);
    const double newton_length = std::sqrt(weightedSquare(newton, context.scale()));
    if (radius_ <= 0) radius_ = newton_length;
    for (int trial = 0; trial < kTrials; ++trial) {
      combine(context, newton, cauchy, newton_length, step);
      const double length = std::sqrt(weightedSquare(step, context.scale()));
      const double predicted =
          -2 * dot(context.gradient(), step) - context.equations().quadraticForm(step);
      const bool finite = context.evaluateTrial();
      const double gain = finite ? (context.chi2() - context.trialChi2()) / predicted : -1;
      const bool accepted = finite && predicted > 0 && gain > kSmallestGain;
      result.full = newton_length <= radius_;
      if (accepted && gain > 0.75) radius_ = std::max(radius_, 3 * length);
      if (!accepted || gain < 0.25) radius_ = 0.25 * length;
      if (accepted) {
        result.kind = Kind::kAccepted;
        context.acceptTrial();
        return result;
      }
      if (isRounding(predicted, context.chi2())) return stuck(result.damping, kNothingToGain);
      if (length < 1e-12 * newton_length) return stuck(result.damping, kNoLowerChi2);
    }
    return result;
  }

 private:
  /// The Gauss-Newton step; where H is singular, that of H + mu D with the
  /// smallest mu that works.
  bool factorize(SolveContext& context, StepResult& result) {
    double mu = 0;
    while (mu < 1) {
      damping_.resize(context.scale().size());
      for (std::size_t i = 0; i < damping_.size(); ++i) damping_[i] = mu * context.scale()[i];
      LinearOutcome outcome = context.factorize(mu == 0 ? nullptr : damping_.data());
      if (outcome.ok) outcome = context.solveForStep();
      result.damping = mu;
      if (outcome.ok) return true;
      result.reason = context.describe(outcome);
      mu = mu == 0 ? 1e-12 : 10 * mu;
    }
    result.kind = Kind::kFailed;
    return false;
  }

  static std::vector<double> cauchyStep(const SolveContext& context) {
    std::vector<double> direction(context.gradient().size());
    for (std::size_t i = 0; i < direction.size(); ++i) {
      direction[i] = -context.gradient()[i] / context.scale()[i];
    }
    const double slope = -dot(context.gradient(), direction);
    const double curvature = context.equations().quadraticForm(direction);
    const double length = curvature > 0 ? slope / curvature : 1;
    for (double& entry : direction) entry *= length;
    return direction;
  }

  void combine(const SolveContext& context, const std::vector<double>& newton,
               const std::vector<double>& cauchy, double newton_length,
               std::vector<double>& step) const {
    if (newton_length <= radius_) {
      step = newton;
      return;
    }
    const double cauchy_square = weightedSquare(cauchy, context.scale());
    if (cauchy_square >= radius_ * radius_) {
      const double factor = radius_ / std::sqrt(cauchy_square);
      for (std::size_t i = 0; i < step.size(); ++i) step[i] = factor * cauchy[i];
      return;
    }
    // |c + t (n - c)|^2 = radius^2, the root in [0, 1].
    double cross = 0;
    double square = 0;
    for (std::size_t i = 0; i < step.size(); ++i) {
      const double leg = newton[i] - cauchy[i];
      cross += context.scale()[i] * cauchy[i] * leg;
      square += context.scale()[i] * leg * leg;
    }
    const double rest = radius_ * radius_ - cauchy_square;
    const double root = std::sqrt(cross * cross + square * rest);
    const double t = cross > 0 ? rest / (cross + root) : (root - cross) / square;
    for (std::size_t i = 0; i < step.size(); ++i) {
      step[i] = cauchy[i] + t * (newton[i] - cauchy[i]);
    }
  }

  double radius_ = 0;
  std::vector<double> damping_;
};

}  // namespace

std::unique_ptr<StepStrategy> StepStrategy::create(const SolveOptions& options) {
  switch (options.algorithm) {
    case Algorithm::kGaussNewton:
      return std::make_unique<GaussNewton>();
    case Algorithm::kDogleg:
      return std::make_unique<Dogleg>();
    case Algorithm::kLevenbergMarquardt:
      break;
  }
  return std::make_unique<LevenbergMarquardt>(options.initial_damping);
}

}  // namespace graft
