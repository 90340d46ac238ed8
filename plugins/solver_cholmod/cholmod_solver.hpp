// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cholmod.h>

#include <string>
#include <vector>

#include "core/types/abi.h"

namespace graft {

/// Sparse Cholesky by CHOLMOD's supernodal module on a block matrix. The
/// ordering is found on blocks (AMD, and METIS where it promises fewer
/// operations) and reused for every factorisation of the pattern.
class CholmodSolver {
 public:
  CholmodSolver();
  ~CholmodSolver();
  CholmodSolver(const CholmodSolver&) = delete;
  CholmodSolver& operator=(const CholmodSolver&) = delete;

  /// Each returns a code of the ABI; `why` receives the reason of a failure.
  int analyze(const graft_block_pattern& pattern, std::string& why);
  int factorize(const double* values, const double* damping, std::int32_t* failed_block,
                std::string& why);
  int solve(const double* b, double* x, std::string& why);
  /// What factorize() takes, bytes, by CHOLMOD's analysis: the numbers of the factor, its work
  /// space, and the permuted copy of the matrix.
  double factorBytes() const;

 private:
  void release();
  bool expand(const graft_block_pattern& pattern, std::string& why);
  std::vector<int> blockOrdering(const graft_block_pattern& pattern, bool dissection);
  cholmod_factor* analyzeWith(const std::vector<int>& block_order,
                              const graft_block_pattern& pattern);
  int statusCode(std::string& why) const;

  cholmod_common common_;
  cholmod_sparse* matrix_ = nullptr;
  cholmod_factor* factor_ = nullptr;
  std::vector<int> first_;              ///< scalar row where each block begins
  std::vector<std::int32_t> block_of_;  ///< block of each scalar row
  std::vector<std::int64_t> source_;    ///< where each entry of matrix_ stands in `values`
  std::vector<std::size_t> diagonal_;   ///< entry of matrix_ on the diagonal of each column
  bool factored_ = false;
};

}  // namespace graft
