// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/evaluation.hpp"

#include "core/base/error.hpp"
#include "core/base/parallel.hpp"
#include "core/solve/edge_batch.hpp"
#include "core/solve/linearizer.hpp"
#include "core/solve/problem.hpp"
#include "core/solve/whiten.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

void require(const Evaluation& evaluation) {
  if (!evaluation.ok()) throw Error(ExitCode::kNoResult, evaluation.failure);
}

/// Errors and Jacobians of a group's edges from `begin` on, as the type gives them.
class RawBatch {
 public:
  RawBatch(const EdgeGroup& group, std::size_t index, const State& state, std::int64_t begin,
           std::int64_t end, bool jacobians)
      : group_(group), errors_(std::size_t((end - begin) * group.error_dim)) {
    if (jacobians) jacobians_.resize(errors_.size() * std::size_t(group.tangent_dim));
    const EdgeBatch batch(group, index, state, begin, end);
    graft_message message = {};
    const int status = callPlugin(Callback::kEvaluate, group.type->tag, message, [&] {
      return group.type->evaluate(&batch.view(), errors_.data(),
                                  jacobians ? jacobians_.data() : nullptr, &message);
    });
    if (status != GRAFT_OK) {
      throw Error(ExitCode::kNoResult, std::string("edges ") + group.type->tag + ": " +
                                           withPlugin(message.text, group.type->tag));
    }
  }

  Eigen::VectorXd error(std::int64_t e) const {
    return Eigen::Map<const Eigen::VectorXd>(errors_.data() + e * group_.error_dim,
                                             group_.error_dim);
  }
  std::vector<Eigen::MatrixXd> jacobians(std::int64_t e) const {
    std::vector<Eigen::MatrixXd> list;
    if (jacobians_.empty()) return list;
    const Eigen::Map<const Eigen::MatrixXd> all(
        jacobians_.data() + e * group_.error_dim * group_.tangent_dim, group_.error_dim,
        group_.tangent_dim);
    for (int k = 0; k < group_.arity; ++k) {
      list.emplace_back(
          all.middleCols(group_.slot_offsets[std::size_t(k)], group_.slot_dims[std::size_t(k)]));
    }
    return list;
  }

 private:
  const EdgeGroup& group_;
  std::vector<double> errors_;
  std::vector<double> jacobians_;
};

void applyKernel(const Graph& graph, std::int32_t kernel, EdgeEvaluation& edge) {
  edge.chi2 = edge.squared;
  if (kernel < 0) return;
  const Kernel& k = graph.kernels()[std::size_t(kernel)];
  double rho[3] = {};
  callPlugin(Callback::kKernel, k.type->name,
             [&] { k.type->evaluate(1, &edge.squared, k.width, rho); });
  edge.chi2 = rho[0];
  edge.weight = rho[1];
}

}  // namespace

std::string EdgeEvaluation::describe(const Graph& graph) const {
  std::string text = type->tag;
  for (const VertexRef v : vertices) text += ' ' + std::to_string(graph.id(v));
  if (line > 0) text += " (line " + std::to_string(line) + ")";
  return text;
}

std::vector<EdgeEvaluation> evaluateEdges(const Graph& graph, const Values& values,
                                          const EvaluationOptions& options) {
  const bool jacobians = options.jacobians;
  ThreadPool pool(1);
  const Problem problem(graph, options.information, options.level);
  Linearizer linearizer(problem, pool);
  State state;
  require(linearizer.begin(values, state));
  // Once as a solve does it, which judges every number and names the edge.
  require(jacobians ? linearizer.linearize(state) : linearizer.evaluate(state));
  std::vector<EdgeEvaluation> list;
  list.reserve(graph.edgeCount());
  for (std::size_t g = 0; g < problem.groups().size(); ++g) {
    const EdgeGroup& group = problem.groups()[g];
    const auto dim = std::size_t(group.error_dim);
    for (std::int64_t begin = 0; begin < group.count; begin += Linearizer::kBatch) {
      const std::int64_t end = std::min(begin + Linearizer::kBatch, group.count);
      const RawBatch raw(group, g, state, begin, end, jacobians);
      for (std::int64_t e = begin; e < end; ++e) {
        EdgeEvaluation edge;
        const auto place = std::size_t(e);
        const auto first = group.vertices.begin() + e * group.arity;
        edge.type = group.type;
        edge.vertices.assign(first, first + group.arity);
        edge.line = group.lines[place];
        edge.error = raw.error(e - begin);
        edge.whitened.resize(group.error_dim);
        whitenError(group.roots.data() + place * dim * dim, group.root_shapes[place],
                    group.error_dim, edge.error.data(), edge.whitened.data());
        edge.squared = edge.whitened.squaredNorm();
        applyKernel(graph, group.kernels[place], edge);
        edge.jacobians = raw.jacobians(e - begin);
        list.push_back(std::move(edge));
      }
    }
  }
  return list;
}

Linearization linearize(const Graph& graph, const Values& values,
                        const EvaluationOptions& options) {
  ThreadPool pool(1);
  const Problem problem(graph, options.information, options.level);
  Linearizer linearizer(problem, pool);
  State state;
  require(linearizer.begin(values, state));
  const Evaluation evaluation = linearizer.linearize(state);
  require(evaluation);
  Linearization result;
  result.chi2 = evaluation.chi2;
  result.vertices = problem.freeVertices();
  result.columns = problem.offsets();
  result.notes = problem.notes();
  std::vector<double> rows;
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t g = 0; g < problem.groups().size(); ++g) {
    const EdgeGroup& group = problem.groups()[g];
    const double* jacobian = linearizer.jacobians(g).data();
    for (std::int64_t e = 0; e < group.count; ++e) {
      for (int i = 0; i < group.error_dim; ++i, jacobian += group.tangent_dim) {
        for (int k = 0; k < group.arity; ++k) {
          const std::int32_t block = group.blocks[std::size_t(e * group.arity + k)];
          if (block < 0) continue;
          const int from = group.slot_offsets[std::size_t(k)];
          for (int c = 0; c < group.slot_dims[std::size_t(k)]; ++c) {
            entries.emplace_back(int(rows.size()), int(problem.offsets()[std::size_t(block)] + c),
                                 jacobian[from + c]);
          }
        }
        rows.push_back(linearizer.residuals(g)[std::size_t(e * group.error_dim + i)]);
      }
    }
  }
  result.residual = Eigen::Map<const Eigen::VectorXd>(rows.data(), Eigen::Index(rows.size()));
  result.jacobian.resize(Eigen::Index(rows.size()), Eigen::Index(problem.dim()));
  // Entries of one place (a vertex in two slots) add up.
  result.jacobian.setFromTriplets(entries.begin(), entries.end());
  result.gradient = 2.0 * (result.jacobian.transpose() * result.residual);
  return result;
}

}  // namespace graft
