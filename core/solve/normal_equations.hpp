// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/solve/linearizer.hpp"

namespace graft {

/// J'J and J'r of a linearised problem. Every block knows which products of
/// Jacobians it is the sum of, in canonical order, so that the sums are the same
/// for any number of threads, and no thread waits for another.
class NormalEquations {
 public:
  /// Throws Error(kNoResult) where these and the Jacobians they are formed from do not
  /// fit into memory.
  explicit NormalEquations(const Problem& problem);

  /// Lower triangle by block columns; valid as long as this object.
  const graft_block_pattern& pattern() const { return pattern_; }
  /// Forms hessian() and gradient() from the last linearisation.
  void gather(const Linearizer& linearizer, ThreadPool& pool);
  /// The same where only these edges were linearised anew since.
  void gather(const Linearizer& linearizer, const std::vector<EdgePlace>& edges);

  const std::vector<double>& hessian() const { return hessian_; }    ///< J'J by blocks
  const std::vector<double>& gradient() const { return gradient_; }  ///< J'r
  const std::vector<double>& diagonal() const { return diagonal_; }  ///< of J'J
  /// y' J'J y.
  double quadraticForm(const std::vector<double>& y) const;

 private:
  /// One product: J_a' J_b of an edge. `a` and `b` are columns of its Jacobian.
  struct Term {
    std::int32_t group;
    std::int32_t edge;
    std::int32_t a;
    std::int32_t b;
  };
  void findTerms(const Problem& problem);
  void gatherColumn(std::int32_t column, const Linearizer& linearizer);

  const Problem* problem_;
  graft_block_pattern pattern_ = {};
  std::vector<std::int64_t> columns_;
  std::vector<std::int32_t> rows_;
  std::vector<std::int64_t> value_offsets_;
  std::vector<std::int64_t> term_begin_;  ///< per block, one more than blocks
  std::vector<Term> terms_;
  std::vector<double> hessian_;
  std::vector<double> gradient_;
  std::vector<double> diagonal_;
};

}  // namespace graft
