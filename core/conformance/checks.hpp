// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/conformance/conformance.hpp"
#include "core/graph/graph.hpp"

namespace graft::conformance {

/// Thrown by a check that finds a defect.
struct Defect : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Thrown by a check that cannot be made, e.g. for want of an example.
struct Skip : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One named check of one type; returns, or throws one of the above.
struct Check {
  std::string name;
  std::function<void()> run;
};
using Checks = std::vector<Check>;

/// What checks draw from; lives in the child.
struct Context {
  Registry& registry;
  const ConformanceOptions& options;
  const Graph* example = nullptr;  ///< null without an example file
  const Values* example_values = nullptr;
};

// The checks of a type, by kind. Making the list runs no code of the plugin, so
// that a list is the same in every child.
void addVertexChecks(const Context& context, const graft_vertex_type& type, Checks& checks);
void addEdgeChecks(const Context& context, const graft_edge_type& type, Checks& checks);
void addKernelChecks(const Context& context, const graft_kernel_type& type, Checks& checks);
void addSolverChecks(const Context& context, const graft_solver_type& type, Checks& checks);
void addResourceChecks(const Context& context, const graft_resource_type& type, Checks& checks);
void addLoaderChecks(const Context& context, const graft_loader_type& type, Checks& checks);
void addGuessChecks(const Context& context, const graft_guess_type& type, Checks& checks);

}  // namespace graft::conformance
