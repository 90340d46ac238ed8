// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/alternatives.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/solve/edge_batch.hpp"
#include "core/solve/whiten.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

bool listsChoices(const graft_edge_type& type) {
  return type.associate != nullptr && (type.flags & GRAFT_EDGE_HAS_ALTERNATIVES) != 0;
}

/// An edge by itself: whitened errors and Jacobians by its free vertices' tangents, for
/// any association and anywhere near the state.
class LoneEdge {
 public:
  LoneEdge(const SolveContext& context, std::size_t group, std::int64_t edge)
      : problem_(context.problem()),
        group_(problem_.groups()[group]),
        edge_(edge),
        batch_(group_, group, context.state(), edge, edge + 1),
        at_(std::size_t(group_.arity)),
        moved_(at_.size()) {
    for (int k = 0; k < group_.arity; ++k) {
      const auto slot = std::size_t(edge * group_.arity + k);
      const VertexRef v = group_.vertices[slot];
      const double* x = context.state().values.at(v);
      at_[std::size_t(k)] = x;
      moved_[std::size_t(k)].assign(x, x + context.state().values.dim(v.type));
      const std::int32_t block = group_.blocks[slot];
      if (block < 0) continue;
      for (int j = 0; j < group_.slot_dims[std::size_t(k)]; ++j) {
        columns_.push_back(problem_.offsets()[std::size_t(block)] + j);
        local_.push_back(group_.slot_offsets[std::size_t(k)] + j);
      }
    }
  }

  /// Columns of the problem that the edge depends on.
  const std::vector<std::int64_t>& columns() const { return columns_; }

  /// The association number k; false if there are no more.
  bool alternative(int k, std::vector<double>& association) const {
    association.assign(std::size_t(group_.type->association_dim), 0.0);
    std::uint8_t there = 0;
    graft_message message = {};
    return callPlugin(Callback::kAssociate, group_.type->tag, message,
                      [&] {
                        return group_.type->associate(&batch_.view(), GRAFT_ALTERNATIVE + k,
                                                      association.data(), &there, &message);
                      }) == GRAFT_OK &&
           there != 0;
  }

  /// Error and Jacobian with an association, the free vertices moved by `tangent`.
  /// False if they are not finite.
  bool evaluate(const double* association, const Eigen::VectorXd& tangent, Eigen::VectorXd& error,
                Matrix& jacobian) {
    move(tangent);
    std::vector<const double*> vertices;
    for (const std::vector<double>& x : moved_) vertices.push_back(x.data());
    graft_edge_batch batch = batch_.view();
    batch.vertices = vertices.data();
    batch.associations = &association;
    const int dim = group_.error_dim;
    std::vector<double> e(static_cast<std::size_t>(dim));
    std::vector<double> j(e.size() * std::size_t(group_.tangent_dim));
    graft_message message = {};
    const int status = callPlugin(Callback::kEvaluate, group_.type->tag, message, [&] {
      return group_.type->evaluate(&batch, e.data(), j.data(), &message);
    });
    if (status != GRAFT_OK) return false;
    const auto index = std::size_t(edge_);
    const double* root = group_.roots.data() + index * e.size() * e.size();
    const double scale = std::sqrt(group_.weight(edge_));
    error.resize(dim);
    whitenError(root, group_.root_shapes[index], dim, e.data(), error.data());
    error *= scale;
    Matrix whole(dim, group_.tangent_dim);
    whitenJacobian(root, group_.root_shapes[index], dim, group_.tangent_dim, scale, j.data(),
                   whole.data());
    jacobian.resize(dim, Eigen::Index(local_.size()));
    for (std::size_t c = 0; c < local_.size(); ++c)
      jacobian.col(Eigen::Index(c)) = whole.col(local_[c]);
    return error.allFinite() && jacobian.allFinite();
  }

  const double* association(const State& state, std::size_t group) const {
    return state.associations[group].data() + edge_ * group_.type->association_dim;
  }

 private:
  void move(const Eigen::VectorXd& tangent) {
    Eigen::Index next = 0;
    for (int k = 0; k < group_.arity; ++k) {
      const auto slot = std::size_t(edge_ * group_.arity + k);
      if (group_.blocks[slot] < 0) continue;
      const graft_vertex_type& type = problem_.graph().type(group_.vertices[slot]);
      callPlugin(Callback::kPlus, type.tag, [&] {
        type.plus(1, at_[std::size_t(k)], tangent.data() + next, moved_[std::size_t(k)].data());
      });
      next += group_.slot_dims[std::size_t(k)];
    }
  }

  const Problem& problem_;
  const EdgeGroup& group_;
  std::int64_t edge_;
  EdgeBatch batch_;
  std::vector<const double*> at_;
  std::vector<std::vector<double>> moved_;
  std::vector<std::int64_t> columns_;
  std::vector<int> local_;
};

/// What the rest of the graph costs by an edge's tangents d, as far as the linear model
/// goes: least + (d - there)' M (d - there) - |r + J d|^2.
struct Rest {
  double least = 0;
  Eigen::VectorXd there;
  Eigen::MatrixXd inverse_covariance;
  Eigen::VectorXd error;
  Matrix jacobian;

  double cost(const Eigen::VectorXd& d) const {
    const Eigen::VectorXd off = d - there;
    return least + off.dot(inverse_covariance * off) - (error + jacobian * d).squaredNorm();
  }
  Eigen::VectorXd gradient(const Eigen::VectorXd& d) const {
    return inverse_covariance * (d - there) - jacobian.transpose() * (error + jacobian * d);
  }
  Eigen::MatrixXd hessian() const { return inverse_covariance - jacobian.transpose() * jacobian; }
};

bool findRest(SolveContext& context, LoneEdge& edge, const double* association, Rest& rest) {
  const auto n = Eigen::Index(edge.columns().size());
  if (!edge.evaluate(association, Eigen::VectorXd::Zero(n), rest.error, rest.jacobian))
    return false;
  rest.there.resize(n);
  double slope = 0;
  for (std::size_t i = 0; i < context.step().size(); ++i) {
    slope += context.gradient()[i] * context.step()[i];
  }
  rest.least = context.chi2() + slope;
  Eigen::MatrixXd covariance(n, n);
  std::vector<double> unit(context.step().size(), 0.0);
  std::vector<double> column(unit.size());
  for (Eigen::Index c = 0; c < n; ++c) {
    const auto at = std::size_t(edge.columns()[std::size_t(c)]);
    rest.there[c] = context.step()[at];
    unit[at] = 1;
    if (!context.solve(unit, column)) return false;
    unit[at] = 0;
    for (Eigen::Index r = 0; r < n; ++r) {
      covariance(r, c) = column[std::size_t(edge.columns()[std::size_t(r)])];
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(0.5 * (covariance + covariance.transpose()));
  if (factor.info() != Eigen::Success) return false;
  rest.inverse_covariance = factor.solve(Eigen::MatrixXd::Identity(n, n));
  return true;
}

/// Gauss-Newton on the rest and the edge with another association.
bool predict(const Rest& rest, LoneEdge& edge, Alternative& alternative) {
  constexpr int kSteps = 5;
  Eigen::VectorXd d = Eigen::VectorXd::Zero(rest.there.size());
  Eigen::VectorXd error;
  Matrix jacobian;
  for (int i = 0; i <= kSteps; ++i) {
    if (!edge.evaluate(alternative.association.data(), d, error, jacobian)) return false;
    if (i == kSteps) break;
    const Eigen::LDLT<Eigen::MatrixXd> factor(rest.hessian() + jacobian.transpose() * jacobian);
    const Eigen::VectorXd step = -factor.solve(rest.gradient(d) + jacobian.transpose() * error);
    if (!step.allFinite()) return false;
    d += step;
  }
  alternative.predicted_chi2 = rest.cost(d) + error.squaredNorm();
  return std::isfinite(alternative.predicted_chi2);
}

}  // namespace

bool hasAlternatives(const Problem& problem) {
  const auto& all = problem.groups();
  return std::any_of(all.begin(), all.end(),
                     [](const EdgeGroup& g) { return listsChoices(*g.type); });
}

std::vector<Alternative> findAlternatives(SolveContext& context) {
  std::vector<Alternative> found;
  const auto& all = context.problem().groups();
  if (!context.linearize().ok() || !context.factorizeForStep()) return found;
  for (std::size_t g = 0; g < all.size(); ++g) {
    if (!listsChoices(*all[g].type)) continue;
    for (std::int64_t e = 0; e < all[g].count; ++e) {
      if (all[g].kernels[std::size_t(e)] >= 0 || !(all[g].weight(e) > 0)) continue;
      LoneEdge edge(context, g, e);
      Rest rest;
      const double* own = edge.association(context.state(), g);
      if (edge.columns().empty() || !findRest(context, edge, own, rest)) continue;
      Alternative a{g, e, {}, 0};
      for (int k = 0; edge.alternative(k, a.association); ++k) {
        if (!std::equal(a.association.begin(), a.association.end(), own) &&
            predict(rest, edge, a)) {
          found.push_back(a);
        }
      }
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Alternative& a, const Alternative& b) {
    return a.predicted_chi2 < b.predicted_chi2;
  });
  return found;
}

Alternative currentChoice(const SolveContext& context, Alternative of) {
  const double* own =
      context.state().associations[of.group].data() + of.edge * std::int64_t(of.association.size());
  of.association.assign(own, own + of.association.size());
  return of;
}

}  // namespace graft
