// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/covariance.hpp"

#include "core/solve/linear_solver.hpp"
#include "core/solve/normal_equations.hpp"

namespace graft {

std::vector<Eigen::MatrixXd> marginalCovariances(const Graph& graph, const Values& values,
                                                 Registry& registry,
                                                 const std::vector<VertexRef>& vertices) {
  const auto fail = [](const std::string& why) {
    throw Error(ExitCode::kNoResult, "no covariance: " + why);
  };
  const Problem problem(graph, InformationPolicy::kError);
  ThreadPool pool(1);
  Linearizer linearizer(problem, pool);
  State state;
  Evaluation evaluation = linearizer.begin(values, state);
  if (evaluation.ok()) evaluation = linearizer.linearize(state);
  if (!evaluation.ok()) fail(evaluation.failure);
  NormalEquations equations(problem);
  equations.gather(linearizer, pool);
  const auto solver = LinearSolver::create("block", registry, pool);
  solver->analyze(equations.pattern());
  const LinearOutcome factored = solver->factorize(equations.hessian().data(), nullptr);
  if (!factored.ok) {
    fail("the system is singular" +
         (factored.failed_block < 0
              ? std::string()
              : " at " + problem.describeVertex(
                             problem.freeVertices()[std::size_t(factored.failed_block)])));
  }
  const Eigen::Index size = problem.dim();
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(size);
  Eigen::VectorXd column(size);
  std::vector<Eigen::MatrixXd> covariances;
  for (const VertexRef v : vertices) {
    const int dim = graph.type(v).tangent_dim;
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(dim, dim);
    const std::int32_t block = problem.blockOf(v);
    for (int k = 0; block >= 0 && k < dim; ++k) {
      const Eigen::Index first = problem.offsets()[std::size_t(block)];
      unit[first + k] = 1;
      const LinearOutcome solved = solver->solve(unit.data(), column.data());
      unit[first + k] = 0;
      if (!solved.ok) fail(solved.message);
      covariance.col(k) = column.segment(first, dim);
    }
    covariances.push_back(0.5 * (covariance + covariance.transpose()));
  }
  return covariances;
}

}  // namespace graft
