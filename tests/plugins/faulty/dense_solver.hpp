// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types/abi.h"

namespace graft::testing {

/// A dense Cholesky as a solver type, with the named fault or none (null); `spoil` is
/// called with "solver" at each factorisation.
const graft_solver_type& denseSolver(const char* fault, void (*spoil)(const char* where));

}  // namespace graft::testing
