// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/robust_edges.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/solve/chi_square.hpp"

namespace graft {

namespace {

/// Weights this near 0 or 1 count as decided.
constexpr double kDecided = 1e-4;
/// Weights of Geman and McClure below this are 0, so that false edges, which tie together
/// what is far apart, do not fill the factor.
constexpr double kNegligible = 1e-3;
/// Thresholds are as for noise of this many times the variance that the kept edges show.
constexpr double kMargin = 9;
constexpr double kSameNoise = 0.8;
constexpr double kLeastRedundancy = 30;
/// The quantile that tells the noise where a part of the edges are false.
constexpr double kPresumedTrue = 0.25;
/// Errors of a millionth of what is expected are rounding.
constexpr double kLeastNoise = 1e-12;

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

RobustEdges::RobustEdges(Problem& problem, const Graduation& options, GraduationReport& report)
    : problem_(&problem), options_(&options), report_(&report) {
  rankVertices();
  findCandidates();
  findFreedoms();
  findThresholds();
}

void RobustEdges::rankVertices() {
  const Graph& graph = problem_->graph();
  ranks_.resize(graph.vertexBlocks().size());
  std::vector<std::int64_t> counts(ranks_.size(), 0);
  for (std::size_t t = 0; t < ranks_.size(); ++t) {
    ranks_[t].resize(graph.vertexBlocks()[t].ids.size());
  }
  for (const VertexRef v : graph.verticesById()) {
    ranks_[std::size_t(v.type)][std::size_t(v.index)] = counts[std::size_t(v.type)]++;
  }
}

bool RobustEdges::isTrusted(const EdgeGroup& group, std::int64_t edge) const {
  if (!options_->trust_consecutive || group.arity > 2) return false;
  const VertexRef* v = &group.vertices[std::size_t(edge * group.arity)];
  if (group.arity == 1) return true;
  const auto rank = [this](VertexRef w) {
    return ranks_[std::size_t(w.type)][std::size_t(w.index)];
  };
  return v[0].type == v[1].type && std::abs(rank(v[0]) - rank(v[1])) <= 1;
}

void RobustEdges::findCandidates() {
  const std::vector<std::string>& tags = options_->trusted_tags;
  std::set<std::string> unused(tags.begin(), tags.end());
  for (std::size_t g = 0; g < problem_->groups().size(); ++g) {
    const EdgeGroup& group = problem_->groups()[g];
    unused.erase(group.type->tag);
    if (std::find(tags.begin(), tags.end(), group.type->tag) != tags.end()) continue;
    for (std::int64_t e = 0; e < group.count; ++e) {
      if (isTrusted(group, e)) continue;
      candidates_.emplace_back(g, std::size_t(e));
      if (group.kernels[std::size_t(e)] < 0) continue;
      ++report_->kernels_left_out;
      problem_->dropKernel(g, e);
    }
  }
  report_->candidates = std::int64_t(candidates_.size());
  if (!unused.empty()) {
    throw Error(ExitCode::kUsage, "no edge has the tag " + graft::quoted(*unused.begin()) +
                                      ", which is to be trusted");
  }
}

void RobustEdges::findFreedoms() {
  for (const EdgeGroup& group : problem_->groups()) {
    const auto dim = std::size_t(group.error_dim);
    freedoms_.emplace_back();
    for (std::size_t e = 0; e < std::size_t(group.count); ++e) {
      freedoms_.back().push_back(rankOf(group.roots.data() + e * dim * dim, group.error_dim));
    }
  }
}

void RobustEdges::findThresholds() {
  std::vector<double> quantiles{0};
  thresholds_.clear();
  for (const std::vector<int>& freedoms : freedoms_) {
    thresholds_.emplace_back();
    for (const int freedom : freedoms) {
      while (quantiles.size() <= std::size_t(freedom)) {
        quantiles.push_back(chiSquareQuantile(options_->inlier_probability, int(quantiles.size())));
      }
      thresholds_.back().push_back(report_->noise_factor * quantiles[std::size_t(freedom)]);
    }
  }
}

double RobustEdges::ratio(Place p) const { return threshold(p) > 0 ? square(p) / threshold(p) : 0; }

RobustEdges::Numbers RobustEdges::weights() const {
  Numbers weights;
  for (const EdgeGroup& group : problem_->groups()) {
    weights.push_back(group.weights);
    weights.back().resize(std::size_t(group.count), 1.0);
  }
  return weights;
}

void RobustEdges::setWeight(const std::vector<Place>& places, double weight) {
  Numbers all = weights();
  for (const Place& p : places) all[p.first][p.second] = weight;
  for (std::size_t g = 0; g < all.size(); ++g) problem_->setWeights(g, std::move(all[g]));
}

void RobustEdges::trustOnly() {
  for (std::size_t g = 0; g < problem_->groups().size(); ++g) problem_->setWeights(g, {});
  setWeight(candidates_, 0);
}

double RobustEdges::weightOf(double square, double threshold, double parameter) const {
  if (threshold == 0) return 1;
  if (options_->kind == RobustEstimation::kGemanMcClure) {
    const double scaled = parameter * threshold;
    const double weight = std::pow(scaled / (square + scaled), 2);
    return weight < kNegligible ? 0 : weight;
  }
  if (square * parameter >= (parameter + 1) * threshold) return 0;
  if (square * (parameter + 1) <= parameter * threshold) return 1;
  const double weight = std::sqrt(threshold * parameter * (parameter + 1) / square) - parameter;
  return std::min(1.0, std::max(0.0, weight));
}

bool RobustEdges::setWeights(double parameter) {
  Numbers all = weights();
  bool decided = true;
  for (const Place& p : candidates_) {
    const double weight = weightOf(square(p), threshold(p), parameter);
    all[p.first][p.second] = weight;
    decided = decided && std::min(weight, 1 - weight) <= kDecided;
  }
  for (std::size_t g = 0; g < all.size(); ++g) problem_->setWeights(g, std::move(all[g]));
  return decided;
}

bool RobustEdges::setSides() {
  Numbers all = weights();
  bool changed = false;
  for (const Place& p : candidates_) {
    const double weight = square(p) > threshold(p) ? 0 : 1;
    changed = changed || weight != all[p.first][p.second];
    all[p.first][p.second] = weight;
  }
  for (std::size_t g = 0; g < all.size(); ++g) problem_->setWeights(g, std::move(all[g]));
  return changed;
}

double RobustEdges::smoothestParameter() const {
  double largest = 0;
  for (const Place& p : candidates_) largest = std::max(largest, ratio(p));
  const double doubled = std::max(2.0, 2 * largest);
  return options_->kind == RobustEstimation::kGemanMcClure ? doubled : 1 / (doubled - 1);
}

double RobustEdges::truncatedCost(double kept) const {
  for (const Place& p : candidates_) {
    if (weight(p) == 0) kept += threshold(p);
  }
  return kept;
}

Evaluation RobustEdges::truncatedCost(const Linearizer& linearizer, const State& state) const {
  Numbers squares;
  Evaluation evaluation = linearizer.squaredErrors(state, squares);
  if (!evaluation.ok()) return evaluation;
  for (const Place& p : candidates_) {
    double& s = squares[p.first][p.second];
    s = std::min(s, threshold(p));
  }
  for (const std::vector<double>& group : squares) {
    for (const double s : group) evaluation.chi2 += s;
  }
  return evaluation;
}

bool RobustEdges::fitNoise(double kept, bool always) {
  if (!options_->fit_noise) return false;
  double redundancy = -double(problem_->dim());
  for (std::size_t g = 0; g < freedoms_.size(); ++g) {
    for (std::size_t e = 0; e < freedoms_[g].size(); ++e) {
      if (weight({g, e}) != 0) redundancy += freedoms_[g][e];
    }
  }
  if (redundancy < kLeastRedundancy) return false;
  return setNoise(kept / redundancy, always);
}

void RobustEdges::presumeNoise(const std::vector<std::pair<Place, double>>& rises) {
  double freedoms = 0;
  std::vector<double> variances;
  for (const auto& [p, rise] : rises) {
    const int freedom = freedoms_[p.first][p.second];
    if (freedom == 0) continue;
    freedoms += freedom;
    variances.push_back(rise / chiSquareQuantile(kPresumedTrue, freedom));
  }
  if (!options_->fit_noise || freedoms < kLeastRedundancy) return;
  const auto place = variances.begin() + std::ptrdiff_t(kPresumedTrue * double(variances.size()));
  std::nth_element(variances.begin(), place, variances.end());
  setNoise(*place, true);
}

bool RobustEdges::setNoise(double variance, bool always) {
  const double factor = std::min(1.0, std::max(kLeastNoise, kMargin * variance));
  const double change = factor / report_->noise_factor;
  if (change == 1 || (!always && change > kSameNoise && change * kSameNoise < 1)) return false;
  report_->noise_factor = factor;
  findThresholds();
  return true;
}

void RobustEdges::reportOff() const {
  const Graph& graph = problem_->graph();
  for (const Place& p : candidates_) {
    if (weight(p) != 0) continue;
    const EdgeGroup& group = problem_->groups()[p.first];
    const std::size_t e = p.second;
    SwitchedOff off;
    off.tag = group.type->tag;
    for (int k = 0; k < group.arity; ++k) {
      off.ids.push_back(graph.id(group.vertices[e * std::size_t(group.arity) + std::size_t(k)]));
    }
    off.line = group.lines[e];
    off.block = group.block;
    off.edge = std::size_t(group.edges[e]);
    off.square = square(p);
    off.threshold = threshold(p);
    report_->off.push_back(std::move(off));
  }
}

}  // namespace graft
