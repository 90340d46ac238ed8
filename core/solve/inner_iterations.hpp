// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "core/base/parallel.hpp"
#include "core/solve/problem.hpp"
#include "core/types/registry.hpp"

namespace graft {

/// After a step, what hangs on the rest by edges that choose what they measure to alone
/// (robot bases, say, that only their reachability ties to the grippers) is solved by itself,
/// the rest held, part by part: every part has a damping of its own, so that a choice that
/// makes one of them refuse a step does not shorten the steps of all. Whether a step lowers
/// chi2 is asked after that. Source: Ruhe and Wedin, "Algorithms for separable nonlinear
/// least squares problems", SIAM Review 1980, algorithm 2; Ceres calls it inner iterations.
///
/// Vertices of a type take part if every edge that joins them to vertices of another type
/// has an association, and one does; the type that has most to estimate never does, for it
/// is the rest. Parts are their connected components.
class InnerIterations {
 public:
  /// `iterations`: at most so many per part and run(), 0 = no parts. The problem's edges
  /// must have weight 1. `interrupt` as in SolveOptions.
  InnerIterations(const Problem& problem, Registry& registry, InformationPolicy policy,
                  int iterations, const std::atomic<int>* interrupt = nullptr);
  ~InnerIterations();
  InnerIterations(const InnerIterations&) = delete;
  InnerIterations& operator=(const InnerIterations&) = delete;

  std::size_t parts() const { return parts_.size(); }
  /// Lowers chi2 by the vertices that take part; a part that fails stays as it is. The
  /// result does not depend on the number of threads.
  void run(Values& values, ThreadPool& pool);

 private:
  struct Part;
  int iterations_;
  std::vector<std::unique_ptr<Part>> parts_;
};

}  // namespace graft
