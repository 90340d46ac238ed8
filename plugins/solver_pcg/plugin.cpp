// SPDX-License-Identifier: BSD-3-Clause
#include <new>

#include "core/types/plugin.hpp"
#include "plugins/solver_pcg/pcg_solver.hpp"

namespace {

/// Runs one call of the solver; its reason becomes the message.
template <class Body>
int call(void* self, graft_message* message, Body&& body) {
  return graft::detail::guarded(message, [&] {
    std::string why;
    const int code = body(*static_cast<graft::PcgSolver*>(self), why);
    if (code != GRAFT_OK) graft::detail::setMessage(message, why.c_str());
    return code;
  });
}

const graft_solver_type kType = {
    sizeof(graft_solver_type),
    "pcg",
    "conjugate gradients with an incomplete Cholesky factor; for graphs whose factor is too large",
    "BSD-3-Clause",
    [](std::int32_t) -> void* { return new (std::nothrow) graft::PcgSolver; },
    [](void* self) { delete static_cast<graft::PcgSolver*>(self); },
    [](void* self, const graft_block_pattern* pattern, graft_message* message) {
      return call(self, message, [&](graft::PcgSolver& solver, std::string& why) {
        return solver.analyze(*pattern, why);
      });
    },
    [](void* self, const double* values, const double* damping, std::int32_t* failed_block,
       graft_message* message) {
      return call(self, message, [&](graft::PcgSolver& solver, std::string& why) {
        return solver.factorize(values, damping, failed_block, why);
      });
    },
    [](void* self, const double* b, double* x, graft_message* message) {
      return call(self, message, [&](graft::PcgSolver& solver, std::string& why) {
        return solver.solve(b, x, why);
      });
    },
    nullptr};

}  // namespace

GRAFT_PLUGIN(solver_pcg, registry) { registry.addSolver(kType); }
