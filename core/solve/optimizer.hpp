// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "core/graph/graph.hpp"
#include "core/solve/options.hpp"
#include "core/solve/summary.hpp"
#include "core/types/registry.hpp"

namespace graft {

/// Minimises F(x) = sum rho(e' Omega e) over the free vertices of the graph.
/// `values` are the start and receive the result. Throws Error(kUsage) for bad
/// options or an unknown solver, Error(kInput) for an information matrix that is
/// not positive semidefinite (naming the edge's tag, line and smallest
/// eigenvalue); numerical failure is a Summary with Status::kFailed, whose
/// reason names the edge or vertex.
Summary optimize(const Graph& graph, Values& values, Registry& registry,
                 const SolveOptions& options = {});

/// Solves again and again graphs that grow, shrink, or get other measurements, and keeps
/// what depends on the pattern alone from one solve to the next. Where the pattern stayed
/// as it was, results have the same bits as those of optimize(); where an elimination
/// order was kept, they may differ by rounding.
///
///   Optimizer optimizer(registry);
///   optimizer.solve(graph.graph(), graph.values());
///   graph.addVertex(...); graph.addEdge(...);
///   optimizer.solve(graph.graph(), graph.values());
class Optimizer {
 public:
  /// Throws as optimize() does for the options.
  explicit Optimizer(Registry& registry, SolveOptions options = {});
  ~Optimizer();
  Optimizer(Optimizer&&) noexcept;
  Optimizer& operator=(Optimizer&&) noexcept;

  /// As optimize(); the graph may be another one each time.
  Summary solve(const Graph& graph, Values& values);

 private:
  struct Session;
  std::unique_ptr<Session> session_;
};

/// F at the values, without solving. `by_tag`, if given, receives the share of
/// every edge type. `level` as in SolveOptions.
double evaluateChi2(const Graph& graph, const Values& values,
                    std::map<std::string, double>* by_tag = nullptr, std::int32_t level = 0);

}  // namespace graft
