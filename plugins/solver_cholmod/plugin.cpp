// SPDX-License-Identifier: BSD-3-Clause
#include <new>

#include "core/types/plugin.hpp"
#include "plugins/solver_cholmod/cholmod_solver.hpp"

namespace {

/// Runs one call of the solver; its reason becomes the message.
template <class Body>
int call(void* self, graft_message* message, Body&& body) {
  return graft::detail::guarded(message, [&] {
    std::string why;
    const int code = body(*static_cast<graft::CholmodSolver*>(self), why);
    if (code != GRAFT_OK) graft::detail::setMessage(message, why.c_str());
    return code;
  });
}

const graft_solver_type kType = {
    sizeof(graft_solver_type),
    "cholmod",
    "supernodal sparse Cholesky of SuiteSparse, AMD or METIS ordering",
    "GPL-2.0-or-later",
    [](std::int32_t) -> void* { return new (std::nothrow) graft::CholmodSolver; },
    [](void* self) { delete static_cast<graft::CholmodSolver*>(self); },
    [](void* self, const graft_block_pattern* pattern, graft_message* message) {
      return call(self, message, [&](graft::CholmodSolver& solver, std::string& why) {
        return solver.analyze(*pattern, why);
      });
    },
    [](void* self, const double* values, const double* damping, std::int32_t* failed_block,
       graft_message* message) {
      return call(self, message, [&](graft::CholmodSolver& solver, std::string& why) {
        return solver.factorize(values, damping, failed_block, why);
      });
    },
    [](void* self, const double* b, double* x, graft_message* message) {
      return call(self, message, [&](graft::CholmodSolver& solver, std::string& why) {
        return solver.solve(b, x, why);
      });
    },
    [](void* self) { return static_cast<const graft::CholmodSolver*>(self)->factorBytes(); }};

}  // namespace

GRAFT_PLUGIN(solver_cholmod, registry) { registry.addSolver(kType); }
