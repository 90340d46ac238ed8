// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/graduated.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/solve/chi_square.hpp"
#include "core/solve/step_strategy.hpp"

namespace graft {

namespace {

constexpr double kSteeper = 1.4;   ///< from round to round, as in the paper
constexpr double kSmoother = 0.1;  ///< where the next pass begins, from where the last did
constexpr int kPatience = 3;       ///< passes without progress that end the first search
constexpr int kLaterPatience = 2;  ///< ... and those for the noise that it found
constexpr double kSameCost = 1e-9;
constexpr int kSettlingRounds = 30;
/// Kept edges whose errors are above this share of their thresholds are tried without, and
/// others with, until so many in a row have brought nothing.
constexpr double kSuspicious = 0.1;
constexpr int kSuspects = 8;
/// Weights this near 0 or 1 count as decided.
constexpr double kDecided = 1e-4;
/// Weights of Geman and McClure below this are 0, so that false edges, which tie together
/// what is far apart, do not fill the factor.
constexpr double kNegligible = 1e-3;
/// Iterations of a round, and the relative change of F that ends it. Between two rounds
/// the cost changes anyway, so early rounds need no exact minimum.
constexpr int kRoundIterations = 5;
constexpr int kExactIterations = 30;
constexpr double kRoundTolerance = 1e-4;
constexpr double kExactTolerance = 1e-9;
/// Thresholds are as for noise of this many times the variance that the kept edges show.
constexpr double kMargin = 9;
constexpr double kSameNoise = 0.8;
constexpr double kLeastRedundancy = 30;
constexpr int kNoiseRounds = 5;

/// Degrees of freedom of an edge: the rank of its information matrix.
int rankOf(const double* root, int dim) {
  double largest = 0;
  std::vector<double> rows(std::size_t(dim), 0.0);
  for (int c = 0; c < dim; ++c) {
    for (int r = 0; r < dim; ++r) rows[std::size_t(r)] += root[c * dim + r] * root[c * dim + r];
  }
  for (const double row : rows) largest = std::max(largest, row);
  return int(
      std::count_if(rows.begin(), rows.end(), [&](double row) { return row > 1e-12 * largest; }));
}

}  // namespace

Graduated::Graduated(Problem& problem, const SolveOptions& options, GraduationReport& report)
    : problem_(&problem), options_(&options), report_(&report) {
  report.kind = options.graduation.kind;
  const Graph& graph = problem.graph();
  ranks_.resize(graph.vertexBlocks().size());
  std::vector<std::int64_t> counts(ranks_.size(), 0);
  for (std::size_t t = 0; t < ranks_.size(); ++t) {
    ranks_[t].resize(graph.vertexBlocks()[t].ids.size());
  }
  for (const VertexRef v : graph.verticesById()) {
    ranks_[std::size_t(v.type)][std::size_t(v.index)] = counts[std::size_t(v.type)]++;
  }
  findCandidates();
  findFreedoms();
  findThresholds();
}

bool Graduated::isTrusted(const EdgeGroup& group, std::int64_t edge) const {
  if (!options_->graduation.trust_consecutive || group.arity > 2) return false;
  const VertexRef* v = &group.vertices[std::size_t(edge * group.arity)];
  if (group.arity == 1) return true;
  const auto rank = [this](VertexRef w) {
    return ranks_[std::size_t(w.type)][std::size_t(w.index)];
  };
  return v[0].type == v[1].type && std::abs(rank(v[0]) - rank(v[1])) <= 1;
}

void Graduated::findCandidates() {
  const std::vector<std::string>& tags = options_->graduation.trusted_tags;
  std::set<std::string> unused(tags.begin(), tags.end());
  for (std::size_t g = 0; g < problem_->groups().size(); ++g) {
    const EdgeGroup& group = problem_->groups()[g];
    const bool trusted = std::find(tags.begin(), tags.end(), group.type->tag) != tags.end();
    unused.erase(group.type->tag);
    candidates_.emplace_back(std::size_t(group.count), trusted ? char{0} : char{1});
    for (std::int64_t e = 0; e < group.count && !trusted; ++e) {
      if (isTrusted(group, e)) candidates_[g][std::size_t(e)] = 0;
    }
    for (std::int64_t e = 0; e < group.count; ++e) {
      if (candidates_[g][std::size_t(e)] == 0) continue;
      ++report_->candidates;
      if (group.kernels[std::size_t(e)] < 0) continue;
      ++report_->kernels_left_out;
      problem_->dropKernel(g, e);
    }
  }
  if (!unused.empty()) {
    throw Error(ExitCode::kUsage, "no edge has the tag " + graft::quoted(*unused.begin()) +
                                      ", which is to be trusted");
  }
}

void Graduated::findFreedoms() {
  for (const EdgeGroup& group : problem_->groups()) {
    const auto dim = std::size_t(group.error_dim);
    freedoms_.emplace_back();
    for (std::size_t e = 0; e < std::size_t(group.count); ++e) {
      freedoms_.back().push_back(rankOf(group.roots.data() + e * dim * dim, group.error_dim));
    }
  }
}

void Graduated::findThresholds() {
  std::vector<double> quantiles{0};
  thresholds_.clear();
  for (const std::vector<int>& freedoms : freedoms_) {
    thresholds_.emplace_back();
    for (const int freedom : freedoms) {
      while (quantiles.size() <= std::size_t(freedom)) {
        quantiles.push_back(
            chiSquareQuantile(options_->graduation.inlier_probability, int(quantiles.size())));
      }
      thresholds_.back().push_back(report_->noise_factor * quantiles[std::size_t(freedom)]);
    }
  }
}

void Graduated::trustOnly() {
  for (std::size_t g = 0; g < candidates_.size(); ++g) {
    std::vector<double> weights(candidates_[g].size());
    for (std::size_t e = 0; e < weights.size(); ++e) weights[e] = candidates_[g][e] ? 0.0 : 1.0;
    problem_->setWeights(g, std::move(weights));
  }
}

Evaluation Graduated::truncatedCost(const Linearizer& linearizer, const State& state) const {
  std::vector<std::vector<double>> squares;
  Evaluation evaluation = linearizer.squaredErrors(state, squares);
  for (std::size_t g = 0; g < squares.size() && evaluation.ok(); ++g) {
    for (std::size_t e = 0; e < squares[g].size(); ++e) {
      const double s = squares[g][e];
      evaluation.chi2 += candidates_[g][e] != 0 ? std::min(s, thresholds_[g][e]) : s;
    }
  }
  return evaluation;
}

double Graduated::smoothestParameter() const {
  double largest = 0;  // of s / c2
  for (std::size_t g = 0; g < candidates_.size(); ++g) {
    for (std::size_t e = 0; e < candidates_[g].size(); ++e) {
      if (candidates_[g][e] == 0 || thresholds_[g][e] == 0) continue;
      largest = std::max(largest, squares_[g][e] / thresholds_[g][e]);
    }
  }
  const double doubled = std::max(2.0, 2 * largest);
  return options_->graduation.kind == RobustEstimation::kGemanMcClure ? doubled : 1 / (doubled - 1);
}

double Graduated::weightOf(double square, double threshold, double parameter) const {
  if (threshold == 0) return 1;
  if (options_->graduation.kind == RobustEstimation::kGemanMcClure) {
    const double scaled = parameter * threshold;
    const double weight = std::pow(scaled / (square + scaled), 2);
    return weight < kNegligible ? 0 : weight;
  }
  if (square * parameter >= (parameter + 1) * threshold) return 0;
  if (square * (parameter + 1) <= parameter * threshold) return 1;
  const double weight = std::sqrt(threshold * parameter * (parameter + 1) / square) - parameter;
  return std::min(1.0, std::max(0.0, weight));
}

bool Graduated::setWeights(double parameter) {
  bool decided = true;
  for (std::size_t g = 0; g < candidates_.size(); ++g) {
    std::vector<double> weights(candidates_[g].size(), 1.0);
    for (std::size_t e = 0; e < weights.size(); ++e) {
      if (candidates_[g][e] == 0) continue;
      weights[e] = weightOf(squares_[g][e], thresholds_[g][e], parameter);
      decided = decided && std::min(weights[e], 1 - weights[e]) <= kDecided;
    }
    problem_->setWeights(g, std::move(weights));
  }
  return decided;
}

bool Graduated::setSides() {
  bool changed = false;
  for (std::size_t g = 0; g < candidates_.size(); ++g) {
    std::vector<double> weights(candidates_[g].size(), 1.0);
    for (std::size_t e = 0; e < weights.size(); ++e) {
      if (candidates_[g][e] != 0 && squares_[g][e] > thresholds_[g][e]) weights[e] = 0;
      changed = changed || weights[e] != problem_->groups()[g].weight(std::int64_t(e));
    }
    problem_->setWeights(g, std::move(weights));
  }
  return changed;
}

bool Graduated::edgesHaveChanged() {
  std::vector<char> active;
  for (std::size_t g = 0; g < candidates_.size(); ++g) {
    for (std::size_t e = 0; e < candidates_[g].size(); ++e) {
      active.push_back(problem_->groups()[g].weight(std::int64_t(e)) > 0 ? 1 : 0);
    }
  }
  const bool changed = active != active_;
  active_ = std::move(active);
  return changed;
}

Evaluation Graduated::round(const Tools& tools, bool exact, State& state) {
  ++report_->rounds;
  Evaluation evaluation = tools.linearizer.evaluate(state);
  if (!evaluation.ok()) return evaluation;
  SolveOptions options;
  options.initial_damping = options_->initial_damping;
  const std::unique_ptr<StepStrategy> strategy = StepStrategy::create(options);
  // An order of elimination that was found among other edges would be a poor one.
  if (edgesHaveChanged()) tools.memory.forget();
  SolveContext context(*problem_, tools.solver, tools.memory, tools.pool, tools.seconds);
  context.start(std::move(state), evaluation.chi2);
  const double tolerance = exact ? kExactTolerance : kRoundTolerance;
  bool linearized = false;
  for (int i = 0; i < (exact ? kExactIterations : kRoundIterations) && !tools.must_stop(); ++i) {
    if (!linearized) evaluation = context.linearize();
    if (!evaluation.ok()) break;
    linearized = true;
    if (context.gradientMax() <= options.gradient_tolerance) break;
    const double before = context.chi2();
    const StepResult result = strategy->iterate(context);
    ++report_->iterations;
    if (result.kind == StepResult::Kind::kFailed) evaluation.failure = result.reason;
    if (result.kind == StepResult::Kind::kFailed || result.kind == StepResult::Kind::kStuck) break;
    if (result.kind != StepResult::Kind::kAccepted) continue;
    linearized = false;
    if (before - context.chi2() <= tolerance * before) break;
  }
  evaluation.chi2 = context.chi2();
  state = context.state();
  if (!evaluation.ok()) return evaluation;
  evaluation.failure = tools.linearizer.squaredErrors(state, squares_).failure;
  return evaluation;
}

Evaluation Graduated::pass(const Tools& tools, double parameter, State& state) {
  const bool truncated = options_->graduation.kind == RobustEstimation::kTruncatedLeastSquares;
  Evaluation evaluation;
  while (!tools.must_stop()) {
    const bool decided = setWeights(parameter);
    if (truncated && decided && parameter > 1) break;
    evaluation = round(tools, false, state);
    if (!evaluation.ok()) return evaluation;
    if (!truncated && parameter <= 1) break;
    parameter = truncated ? parameter * kSteeper : std::max(1.0, parameter / kSteeper);
  }
  setSides();
  return settle(tools, state);
}

Evaluation Graduated::settle(const Tools& tools, State& state) {
  Evaluation evaluation;
  for (int i = 0; i < kSettlingRounds; ++i) {
    evaluation = round(tools, true, state);
    if (!evaluation.ok() || tools.must_stop() || !setSides()) break;
  }
  return evaluation;
}

bool Graduated::findSuspect(bool kept, const std::set<Place>& known, Place& suspect) const {
  double worst = kept ? kSuspicious : std::numeric_limits<double>::infinity();
  bool found = false;
  for (std::size_t g = 0; g < candidates_.size(); ++g) {
    for (std::size_t e = 0; e < candidates_[g].size(); ++e) {
      const double s = squares_[g][e];
      const double limit = worst * thresholds_[g][e];
      if (candidates_[g][e] == 0 || (kept ? s <= limit : s >= limit)) continue;
      if ((problem_->groups()[g].weight(std::int64_t(e)) != 0) != kept) continue;
      if (known.count({g, e}) > 0) continue;
      worst = s / thresholds_[g][e];
      suspect = {g, e};
      found = true;
    }
  }
  return found;
}

Evaluation Graduated::flipSuspects(const Tools& tools, bool kept, State& state) {
  Evaluation evaluation = tools.linearizer.evaluate(state);
  double cost = truncatedCost(evaluation.chi2);
  std::set<Place> known;
  Place suspect;
  for (int failures = 0; failures < kSuspects && evaluation.ok() && !tools.must_stop();) {
    if (!findSuspect(kept, known, suspect)) break;
    known.insert(suspect);
    const State before = state;
    const std::vector<std::vector<double>> squares = squares_;
    std::vector<double> weights = problem_->groups()[suspect.first].weights;
    weights[suspect.second] = kept ? 0 : 1;
    problem_->setWeights(suspect.first, std::move(weights));
    const Evaluation flipped = settle(tools, state);
    const double flipped_cost = truncatedCost(flipped.chi2);
    if (flipped.ok() && flipped_cost < cost * (1 - kSameCost)) {
      evaluation = flipped;
      cost = flipped_cost;
      failures = 0;
      continue;
    }
    ++failures;
    state = before;
    squares_ = squares;
    setSides();
    if (!flipped.ok()) evaluation = flipped;
  }
  return evaluation;
}

double Graduated::truncatedCost(double kept) const {
  for (std::size_t g = 0; g < candidates_.size(); ++g) {
    for (std::size_t e = 0; e < candidates_[g].size(); ++e) {
      if (problem_->groups()[g].weight(std::int64_t(e)) == 0) kept += thresholds_[g][e];
    }
  }
  return kept;
}

Evaluation Graduated::search(const Tools& tools, State& state) {
  const bool truncated = options_->graduation.kind == RobustEstimation::kTruncatedLeastSquares;
  double best_cost = std::numeric_limits<double>::infinity();
  State best = state;
  std::vector<std::vector<double>> best_squares = squares_;
  double parameter = 1;
  const int patience = report_->passes == 0 ? kPatience : kLaterPatience;
  for (int worse = 0; worse < patience;) {
    const double smoothest = smoothestParameter();
    state = best;
    squares_ = best_squares;
    Evaluation evaluation = pass(tools, parameter, state);
    ++report_->passes;
    if (!evaluation.ok()) return evaluation;
    const double cost = truncatedCost(evaluation.chi2);
    worse = cost < best_cost * (1 - kSameCost) ? 0 : worse + 1;
    if (cost < best_cost) {
      best_cost = cost;
      best = state;
      best_squares = squares_;
    }
    if (tools.must_stop()) break;
    if (truncated ? parameter <= smoothest : parameter >= smoothest) break;
    parameter = truncated ? std::max(parameter * kSmoother, smoothest)
                          : std::min(parameter / kSmoother, smoothest);
  }
  state = std::move(best);
  squares_ = std::move(best_squares);
  setSides();
  const Evaluation evaluation = flipSuspects(tools, true, state);
  return evaluation.ok() ? flipSuspects(tools, false, state) : evaluation;
}

bool Graduated::fitNoise(double kept) {
  if (!options_->graduation.fit_noise) return false;
  double redundancy = -double(problem_->dim());
  for (std::size_t g = 0; g < candidates_.size(); ++g) {
    for (std::size_t e = 0; e < candidates_[g].size(); ++e) {
      if (problem_->groups()[g].weight(std::int64_t(e)) != 0) redundancy += freedoms_[g][e];
    }
  }
  if (redundancy < kLeastRedundancy) return false;
  const double factor = std::min(1.0, kMargin * kept / redundancy);
  if (factor > kSameNoise * report_->noise_factor) return false;
  report_->noise_factor = factor;
  findThresholds();
  return true;
}

Evaluation Graduated::run(const Tools& tools, State& state) {
  Evaluation evaluation = tools.linearizer.squaredErrors(state, squares_);
  if (!evaluation.ok()) return evaluation;
  for (int i = 0; i < kNoiseRounds; ++i) {
    evaluation = search(tools, state);
    if (!evaluation.ok()) return evaluation;
    if (tools.must_stop() || !fitNoise(evaluation.chi2)) break;
  }
  fillReport();
  return evaluation;
}

void Graduated::fillReport() {
  const Graph& graph = problem_->graph();
  for (std::size_t g = 0; g < candidates_.size(); ++g) {
    const EdgeGroup& group = problem_->groups()[g];
    for (std::size_t e = 0; e < candidates_[g].size(); ++e) {
      if (group.weight(std::int64_t(e)) != 0) continue;
      SwitchedOff off;
      off.tag = group.type->tag;
      for (int k = 0; k < group.arity; ++k) {
        off.ids.push_back(graph.id(group.vertices[e * std::size_t(group.arity) + std::size_t(k)]));
      }
      off.line = group.lines[e];
      off.block = group.block;
      off.edge = std::size_t(group.edges[e]);
      off.square = squares_[g][e];
      off.threshold = thresholds_[g][e];
      report_->off.push_back(std::move(off));
    }
  }
}

}  // namespace graft
