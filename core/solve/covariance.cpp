// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/covariance.hpp"

#include "core/base/error.hpp"
#include "core/linear/selected_inverse.hpp"
#include "core/solve/normal_equations.hpp"

namespace graft {

namespace {

[[noreturn]] void fail(const std::string& why) {
  throw Error(ExitCode::kNoResult, "no covariance: " + why);
}

}  // namespace

std::vector<Eigen::MatrixXd> jointCovariances(
    const Graph& graph, const Values& values,
    const std::vector<std::pair<VertexRef, VertexRef>>& pairs, const CovarianceOptions& options) {
  const Problem problem(graph, options.information);
  ThreadPool pool(options.threads);
  Linearizer linearizer(problem, pool);
  State state;
  Evaluation evaluation = linearizer.begin(values, state);
  if (evaluation.ok()) evaluation = linearizer.linearize(state);
  if (!evaluation.ok()) fail(evaluation.failure);
  NormalEquations equations(problem);
  equations.gather(linearizer, pool);
  BlockCholesky cholesky(&pool);
  cholesky.analyze(equations.pattern());
  const std::int32_t failed = cholesky.factorize(equations.hessian().data(), nullptr);
  if (failed >= 0) {
    fail("the system is singular at " +
         problem.describeVertex(problem.freeVertices()[std::size_t(failed)]));
  }
  std::vector<Eigen::MatrixXd> covariances;
  std::vector<BlockPair> wanted;
  std::vector<std::size_t> places;
  for (const auto& [a, b] : pairs) {
    const BlockPair blocks = {problem.blockOf(a), problem.blockOf(b)};
    if (blocks.row >= 0 && blocks.column >= 0) {
      wanted.push_back(blocks);
      places.push_back(covariances.size());
    }
    covariances.push_back(
        Eigen::MatrixXd::Zero(graph.type(a).tangent_dim, graph.type(b).tangent_dim));
  }
  std::vector<Eigen::MatrixXd> found = inverseBlocks(cholesky, wanted, &pool);
  for (std::size_t i = 0; i < found.size(); ++i) covariances[places[i]] = std::move(found[i]);
  return covariances;
}

std::vector<Eigen::MatrixXd> marginalCovariances(const Graph& graph, const Values& values,
                                                 const std::vector<VertexRef>& vertices,
                                                 const CovarianceOptions& options) {
  std::vector<std::pair<VertexRef, VertexRef>> pairs;
  pairs.reserve(vertices.size());
  for (const VertexRef v : vertices) pairs.emplace_back(v, v);
  std::vector<Eigen::MatrixXd> covariances = jointCovariances(graph, values, pairs, options);
  for (Eigen::MatrixXd& c : covariances) c = (0.5 * (c + c.transpose())).eval();
  return covariances;
}

}  // namespace graft
