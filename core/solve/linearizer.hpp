// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/parallel.hpp"
#include "core/solve/edge_batch.hpp"
#include "core/solve/problem.hpp"

namespace graft {

/// Outcome of an evaluation: F, or why there is none.
struct Evaluation {
  double chi2 = 0;
  std::string failure;  ///< empty, or which edge (tag, ids, line) and what of it
  bool ok() const { return failure.empty(); }
};

/// An edge of a problem: its group and its number there.
using EdgePlace = std::pair<std::size_t, std::size_t>;

/// Evaluates the edges of a problem by batches of at most kBatch, on all threads
/// of the pool. Sums are formed in canonical order.
///
/// Residuals and Jacobians are whitened (r = S e) and weighted for robust
/// kernels by iteratively reweighted least squares: with s = |r|^2 both are
/// scaled by sqrt(rho'(s)), so that J'r is the exact gradient of F/2 and J'J the
/// positive semidefinite part of its Hessian; the rho'' term is left out.
class Linearizer {
 public:
  static constexpr std::int64_t kBatch = 256;

  Linearizer(const Problem& problem, ThreadPool& pool);

  /// A state with the given estimates, associations made for the first time.
  Evaluation begin(const Values& values, State& state) const;
  /// F at the state. Looks at errors only.
  Evaluation evaluate(const State& state, std::map<std::string, double>* by_tag = nullptr) const;
  /// F at the state; keeps residuals and Jacobians for residuals() and jacobians().
  Evaluation linearize(const State& state);
  /// Linearises these edges anew, for a state that differs from the one linearised last
  /// in their associations only. No edge twice. The chi2 is theirs.
  Evaluation linearizeEdges(const State& state, const std::vector<EdgePlace>& edges);
  /// The squared whitened error of every edge of every group, neither weighted nor robust.
  Evaluation squaredErrors(const State& state, std::vector<std::vector<double>>& squares) const;
  /// Chooses associations anew at the state's estimates; adds to `changed`.
  Evaluation associate(State& state, std::int64_t& changed) const;
  /// From now on associate() leaves the association of this edge, if any, as it is.
  void hold(std::optional<EdgePlace> edge) { held_ = edge; }
  /// Gives every edge of `state` the association of `other` where its squared error at
  /// the state's estimates is greater by that; appends those to `taken`.
  Evaluation takeGreater(State& state, const State& other, std::vector<EdgePlace>& taken) const;
  bool hasAssociations() const { return has_associations_; }
  /// Polled between batches; once it is not 0 evaluations fail at once. Null = never.
  void setInterrupt(const std::atomic<int>* interrupt) { interrupt_ = interrupt; }

  /// Whitened, weighted; of a group: count x error_dim.
  const std::vector<double>& residuals(std::size_t group) const { return residuals_[group]; }
  /// Whitened, weighted; of a group: count matrices error_dim x tangent_dim, row-major.
  const std::vector<double>& jacobians(std::size_t group) const { return jacobians_[group]; }
  const Problem& problem() const { return *problem_; }

 private:
  struct Chunk {
    std::size_t group;
    std::int64_t begin;
    std::int64_t end;
  };
  struct Scratch;
  Evaluation evaluateBatch(const Chunk& chunk, const EdgeBatch& batch, double* residuals,
                           double* jacobians) const;
  Evaluation evaluateChunk(const Chunk& chunk, const State& state, double* residuals,
                           double* jacobians) const;
  /// `residuals` and `jacobians` of the whole group, or null.
  Evaluation run(const Chunk& chunk, const State& state, double* residuals,
                 double* jacobians) const;
  /// In canonical order, of the chunks' evaluations.
  Evaluation sum(const std::vector<Evaluation>& results,
                 std::map<std::string, double>* by_tag) const;
  Evaluation associateAll(State& state, bool first, std::int64_t& changed) const;

  const Problem* problem_;
  ThreadPool* pool_;
  const std::atomic<int>* interrupt_ = nullptr;
  std::vector<Chunk> chunks_;
  std::vector<std::vector<double>> residuals_;
  std::vector<std::vector<double>> jacobians_;
  bool has_associations_ = false;
  std::optional<EdgePlace> held_;
};

}  // namespace graft
