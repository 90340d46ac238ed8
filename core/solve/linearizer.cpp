// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/linearizer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/per_thread.hpp"
#include "core/base/text.hpp"
#include "core/solve/whiten.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

/// Fills what a plugin has to write, so that what it forgets is found.
constexpr double kPoison = std::numeric_limits<double>::quiet_NaN();

/// True if all numbers are finite; 0 * x is 0 for those and NaN for others.
bool allFinite(const double* numbers, std::int64_t count) {
  double sum = 0;
  for (std::int64_t i = 0; i < count; ++i) sum += 0.0 * numbers[i];
  return sum == 0;
}

/// Stands behind what a plugin writes, to find one that writes too much.
constexpr double kGuard = -5.4321e-301;
constexpr std::int64_t kGuards = 16;

bool isIntact(const double* guards) {
  return std::all_of(guards, guards + kGuards, [](double x) { return x == kGuard; });
}

// Callbacks must not throw; one that does all the same fails its edges, and the
// program goes on.
int evaluateEdges(const graft_edge_type& type, const graft_edge_batch& batch, double* errors,
                  double* jacobians, graft_message& message) {
  return callPlugin(Callback::kEvaluate, type.tag, message,
                    [&] { return type.evaluate(&batch, errors, jacobians, &message); });
}
int associateEdges(const graft_edge_type& type, const graft_edge_batch& batch, bool first,
                   double* associations, std::uint8_t* changed, graft_message& message) {
  return callPlugin(Callback::kAssociate, type.tag, message, [&] {
    return type.associate(&batch, first ? 1 : 0, associations, changed, &message);
  });
}

/// Squared error -> rho, rho', rho'' of the edge's kernel.
struct Robust {
  double value;
  double weight;
};
Robust robustify(const Graph& graph, std::int32_t kernel, double s) {
  if (kernel < 0) return {s, 1.0};
  const Kernel& k = graph.kernels()[std::size_t(kernel)];
  double rho[3] = {kPoison, kPoison, kPoison};
  callPlugin(Callback::kKernel, k.type->name, [&] { k.type->evaluate(1, &s, k.width, rho); });
  return {rho[0], rho[1]};
}

std::string byKernel(const Graph& graph, std::int32_t kernel) {
  if (kernel < 0) return "";
  const char* name = graph.kernels()[std::size_t(kernel)].type->name;
  return std::string(", its kernel is ") + name + ofPlugin(name);
}

/// Finds the edge that makes a batch fail and says what is wrong with it.
std::string diagnose(const Graph& graph, const EdgeGroup& group, const EdgeBatch& batch,
                     std::int64_t begin, bool jacobians) {
  std::vector<double> error(std::size_t(group.error_dim));
  std::vector<double> jacobian(
      jacobians ? std::size_t(group.error_dim) * std::size_t(group.tangent_dim) : 0);
  for (std::int64_t e = 0; e < batch.view().count; ++e) {
    std::fill(error.begin(), error.end(), kPoison);
    std::fill(jacobian.begin(), jacobian.end(), kPoison);
    graft_message message = {};
    const graft_edge_batch one = batch.single(e);
    const std::string edge = "edge " + group.describe(graph, begin + e);
    if (evaluateEdges(*group.type, one, error.data(), jacobians ? jacobian.data() : nullptr,
                      message) != GRAFT_OK) {
      return edge + ": " + message.text;
    }
    if (!allFinite(error.data(), std::int64_t(error.size()))) {
      return "the error of " + edge + " is not finite";
    }
    if (!allFinite(jacobian.data(), std::int64_t(jacobian.size()))) {
      return "the Jacobian of " + edge + " is not finite";
    }
  }
  return std::string("edges ") + group.type->tag + " fail as a batch only";
}

}  // namespace

struct Linearizer::Scratch {
  std::vector<double> errors;
  std::vector<double> jacobians;
};

Linearizer::Linearizer(const Problem& problem, ThreadPool& pool)
    : problem_(&problem), pool_(&pool) {
  const auto& groups = problem.groups();
  residuals_.resize(groups.size());
  jacobians_.resize(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (std::int64_t begin = 0; begin < groups[g].count; begin += kBatch) {
      chunks_.push_back({g, begin, std::min(begin + kBatch, groups[g].count)});
    }
    has_associations_ = has_associations_ || groups[g].type->associate != nullptr;
  }
}

Evaluation Linearizer::begin(const Values& values, State& state) const {
  const auto& groups = problem_->groups();
  state.values = values;
  state.associations.resize(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    state.associations[g].assign(
        std::size_t(groups[g].count) * std::size_t(groups[g].type->association_dim), 0.0);
  }
  std::int64_t changed = 0;
  return associateAll(state, true, changed);
}

Evaluation Linearizer::associate(State& state, std::int64_t& changed) const {
  if (!held_) return associateAll(state, false, changed);
  const auto [group, edge] = *held_;
  const auto dim = std::size_t(problem_->groups()[group].type->association_dim);
  const auto at = state.associations[group].begin() + std::ptrdiff_t(edge * dim);
  const std::vector<double> own(at, at + std::ptrdiff_t(dim));
  Evaluation evaluation = associateAll(state, false, changed);
  if (std::equal(own.begin(), own.end(), at)) return evaluation;
  std::copy(own.begin(), own.end(), at);
  --changed;
  return evaluation;
}

Evaluation Linearizer::associateAll(State& state, bool first, std::int64_t& changed) const {
  if (!has_associations_) return {};
  std::vector<std::int64_t> counts(chunks_.size(), 0);
  std::vector<std::string> failures(chunks_.size());
  pool_->run(std::int64_t(chunks_.size()), [&](std::int64_t piece) {
    const Chunk& chunk = chunks_[std::size_t(piece)];
    const EdgeGroup& group = problem_->groups()[chunk.group];
    if (group.type->associate == nullptr) return;
    const EdgeBatch batch(group, chunk.group, state, chunk.begin, chunk.end);
    double* associations = state.associations[chunk.group].data() +
                           chunk.begin * std::int64_t{group.type->association_dim};
    std::vector<std::uint8_t> flags(std::size_t(chunk.end - chunk.begin), 0);
    graft_message message = {};
    if (associateEdges(*group.type, batch.view(), first, associations, flags.data(), message) !=
        GRAFT_OK) {
      failures[std::size_t(piece)] =
          withPlugin("association of edges " + std::string(group.type->tag) + " near " +
                         group.describe(problem_->graph(), chunk.begin) + ": " + message.text,
                     group.type->tag);
    }
    counts[std::size_t(piece)] = std::count(flags.begin(), flags.end(), 1);
  });
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    if (!failures[i].empty()) return {0, failures[i]};
    changed += counts[i];
  }
  return {};
}

Evaluation Linearizer::takeGreater(State& state, const State& other,
                                   std::vector<EdgePlace>& taken) const {
  std::vector<Evaluation> results(chunks_.size());
  std::vector<std::vector<EdgePlace>> greater(chunks_.size());
  pool_->run(std::int64_t(chunks_.size()), [&](std::int64_t piece) {
    const Chunk& chunk = chunks_[std::size_t(piece)];
    const EdgeGroup& group = problem_->groups()[chunk.group];
    if (group.type->associate == nullptr) return;
    std::vector<double>& own = state.associations[chunk.group];
    const std::vector<double>& theirs = other.associations[chunk.group];
    const std::int64_t dim = group.type->association_dim;
    const auto first = own.begin() + chunk.begin * dim;
    if (std::equal(first, own.begin() + chunk.end * dim, theirs.begin() + chunk.begin * dim))
      return;
    std::vector<double> by_own(std::size_t((chunk.end - chunk.begin) * group.error_dim));
    std::vector<double> by_theirs(by_own.size());
    Evaluation& result = results[std::size_t(piece)];
    result = evaluateChunk(chunk, state, by_own.data(), nullptr);
    if (!result.ok()) return;
    const EdgeBatch batch(group, state.values, theirs, chunk.begin, chunk.end);
    result = evaluateBatch(chunk, batch, by_theirs.data(), nullptr);
    if (!result.ok()) return;
    for (std::int64_t e = chunk.begin; e < chunk.end; ++e) {
      double difference = 0;
      for (int i = 0; i < group.error_dim; ++i) {
        const auto row = std::size_t((e - chunk.begin) * group.error_dim + i);
        difference += by_theirs[row] * by_theirs[row] - by_own[row] * by_own[row];
      }
      if (!(difference > 0)) continue;
      std::copy_n(theirs.begin() + e * dim, dim, own.begin() + e * dim);
      greater[std::size_t(piece)].emplace_back(chunk.group, e);
    }
  });
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    if (!results[i].ok()) return results[i];
    taken.insert(taken.end(), greater[i].begin(), greater[i].end());
  }
  return {};
}

Evaluation Linearizer::evaluate(const State& state, std::map<std::string, double>* by_tag) const {
  std::vector<Evaluation> results(chunks_.size());
  pool_->run(std::int64_t(chunks_.size()), [&](std::int64_t piece) {
    results[std::size_t(piece)] = run(chunks_[std::size_t(piece)], state, nullptr, nullptr);
  });
  return sum(results, by_tag);
}

Evaluation Linearizer::linearize(const State& state) {
  const auto& groups = problem_->groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const auto rows = std::size_t(groups[g].count) * std::size_t(groups[g].error_dim);
    residuals_[g].resize(rows);
    jacobians_[g].resize(rows * std::size_t(groups[g].tangent_dim));
  }
  std::vector<Evaluation> results(chunks_.size());
  pool_->run(std::int64_t(chunks_.size()), [&](std::int64_t piece) {
    const Chunk& chunk = chunks_[std::size_t(piece)];
    results[std::size_t(piece)] =
        run(chunk, state, residuals_[chunk.group].data(), jacobians_[chunk.group].data());
  });
  return sum(results, nullptr);
}

Evaluation Linearizer::linearizeEdges(const State& state, const std::vector<EdgePlace>& edges) {
  std::vector<Evaluation> results(edges.size());
  pool_->run(std::int64_t(edges.size()), [&](std::int64_t piece) {
    const auto [group, number] = edges[std::size_t(piece)];
    const auto edge = std::int64_t(number);
    results[std::size_t(piece)] =
        run({group, edge, edge + 1}, state, residuals_[group].data(), jacobians_[group].data());
  });
  Evaluation total;
  for (const Evaluation& result : results) {
    if (!result.ok()) return result;
    total.chi2 += result.chi2;
  }
  return total;
}

Evaluation Linearizer::run(const Chunk& chunk, const State& state, double* residuals,
                           double* jacobians) const {
  if (interrupt_ != nullptr && interrupt_->load(std::memory_order_relaxed) != 0) {
    return {0, "interrupted"};
  }
  const EdgeGroup& group = problem_->groups()[chunk.group];
  const std::int64_t row = chunk.begin * group.error_dim;
  return evaluateChunk(chunk, state, residuals != nullptr ? residuals + row : nullptr,
                       jacobians != nullptr ? jacobians + row * group.tangent_dim : nullptr);
}

Evaluation Linearizer::sum(const std::vector<Evaluation>& results,
                           std::map<std::string, double>* by_tag) const {
  Evaluation total;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    if (!results[i].ok()) return results[i];
    total.chi2 += results[i].chi2;
    if (by_tag != nullptr) {
      (*by_tag)[problem_->groups()[chunks_[i].group].type->tag] += results[i].chi2;
    }
  }
  if (!std::isfinite(total.chi2)) total.failure = "chi2 is not finite";
  return total;
}

Evaluation Linearizer::squaredErrors(const State& state,
                                     std::vector<std::vector<double>>& squares) const {
  const auto& groups = problem_->groups();
  squares.resize(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) squares[g].resize(std::size_t(groups[g].count));
  std::vector<Evaluation> results(chunks_.size());
  pool_->run(std::int64_t(chunks_.size()), [&](std::int64_t piece) {
    const Chunk& chunk = chunks_[std::size_t(piece)];
    const int dim = groups[chunk.group].error_dim;
    std::vector<double> residuals(std::size_t((chunk.end - chunk.begin) * dim));
    results[std::size_t(piece)] = evaluateChunk(chunk, state, residuals.data(), nullptr);
    const double* r = residuals.data();
    for (std::int64_t e = chunk.begin; e < chunk.end; ++e, r += dim) {
      double s = 0;
      for (int i = 0; i < dim; ++i) s += r[i] * r[i];
      squares[chunk.group][std::size_t(e)] = s;
    }
  });
  for (const Evaluation& result : results) {
    if (!result.ok()) return result;
  }
  return {};
}

Evaluation Linearizer::evaluateChunk(const Chunk& chunk, const State& state, double* residuals,
                                     double* jacobians) const {
  const EdgeGroup& group = problem_->groups()[chunk.group];
  const EdgeBatch batch(group, chunk.group, state, chunk.begin, chunk.end);
  return evaluateBatch(chunk, batch, residuals, jacobians);
}

Evaluation Linearizer::evaluateBatch(const Chunk& chunk, const EdgeBatch& batch, double* residuals,
                                     double* jacobians) const {
  static PerThread<Scratch> scratches;
  Scratch& scratch = scratches.get();
  const Graph& graph = problem_->graph();
  const EdgeGroup& group = problem_->groups()[chunk.group];
  const int dim = group.error_dim;
  const std::int64_t count = chunk.end - chunk.begin;
  const std::int64_t jacobian_size = std::int64_t{dim} * group.tangent_dim;
  scratch.errors.assign(std::size_t(count * dim + kGuards + dim), kPoison);
  const double* errors = scratch.errors.data();
  double* guards = scratch.errors.data() + count * dim;
  std::fill(guards, guards + kGuards, kGuard);
  double* whitened = guards + kGuards;
  const double* jacobian_guards = guards;
  if (jacobians != nullptr) {
    scratch.jacobians.assign(std::size_t(count * jacobian_size + kGuards), kPoison);
    jacobian_guards = scratch.jacobians.data() + count * jacobian_size;
    std::fill(scratch.jacobians.end() - kGuards, scratch.jacobians.end(), kGuard);
  }
  graft_message message = {};
  const int status =
      evaluateEdges(*group.type, batch.view(), scratch.errors.data(),
                    jacobians != nullptr ? scratch.jacobians.data() : nullptr, message);
  if (!isIntact(guards) || !isIntact(jacobian_guards)) {
    return {0, std::string(group.type->tag) + ": evaluate() writes behind the end of its " +
                   (isIntact(guards) ? "Jacobians" : "errors") + ofPlugin(group.type->tag)};
  }
  if (status != GRAFT_OK || !allFinite(errors, count * dim) ||
      (jacobians != nullptr && !allFinite(scratch.jacobians.data(), count * jacobian_size))) {
    return {0, diagnose(graph, group, batch, chunk.begin, jacobians != nullptr) +
                   ofPlugin(group.type->tag)};
  }
  Evaluation result;
  for (std::int64_t e = 0; e < count; ++e) {
    const auto index = std::size_t(chunk.begin + e);
    const double* root = group.roots.data() + index * std::size_t(dim * dim);
    double* r = residuals != nullptr ? residuals + e * dim : whitened;
    whitenError(root, group.root_shapes[index], dim, errors + e * dim, r);
    double s = 0;
    for (int i = 0; i < dim; ++i) s += r[i] * r[i];
    const Robust robust = robustify(graph, group.kernels[index], s);
    if (!std::isfinite(s) || !std::isfinite(robust.value) || !std::isfinite(robust.weight) ||
        robust.weight < 0) {
      const std::string edge = group.describe(graph, chunk.begin + e);
      return {0, "chi2 of edge " + edge + " is not finite" +
                     (std::isfinite(s) ? byKernel(graph, group.kernels[index]) : std::string())};
    }
    const double weight = group.weight(chunk.begin + e);
    result.chi2 += weight * robust.value;
    if (jacobians == nullptr) continue;
    const double scale = std::sqrt(weight * robust.weight);
    if (scale != 1.0) {
      for (int i = 0; i < dim; ++i) r[i] *= scale;
    }
    whitenJacobian(root, group.root_shapes[index], dim, group.tangent_dim, scale,
                   scratch.jacobians.data() + e * jacobian_size, jacobians + e * jacobian_size);
  }
  return result;
}

}  // namespace graft
