// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/inspection.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "core/base/disjoint_sets.hpp"
#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/linear/block_cholesky.hpp"
#include "core/solve/edge_batch.hpp"
#include "core/solve/normal_equations.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

State stateAt(const Problem& problem, const Values& values) {
  ThreadPool pool(1);
  const Linearizer linearizer(problem, pool);
  State state;
  const Evaluation evaluation = linearizer.begin(values, state);
  if (!evaluation.ok()) throw Error(ExitCode::kNoResult, evaluation.failure);
  return state;
}

/// Differences of the errors of single edges of one group.
class Differences {
 public:
  Differences(const Problem& problem, const EdgeGroup& group) : problem_(problem), group_(group) {
    moved_.resize(std::size_t(group.arity));
    pointers_.resize(std::size_t(group.arity));
    errors_.resize(group.error_dim);
  }

  /// The largest difference between the edge's Jacobian and differences.
  double worst(graft_edge_batch one, std::int64_t edge) {
    Eigen::MatrixXd exact(group_.error_dim, group_.tangent_dim);
    evaluate(one, edge, exact.data());
    const double scale = 1 + exact.lpNorm<Eigen::Infinity>();
    double smallest = std::numeric_limits<double>::infinity();
    for (const double step : {1e-3, 1e-5}) {
      const double difference =
          (exact - richardson(one, edge, step)).lpNorm<Eigen::Infinity>() / scale;
      // The smaller step has more rounding in it; it is only for jumps.
      if (!(difference >= smallest)) smallest = difference;
      if (smallest <= kJacobianTolerance) break;
    }
    return smallest;
  }

 private:
  [[noreturn]] void fail(std::int64_t edge, const std::string& why) const {
    throw Error(ExitCode::kNoResult,
                "edge " + group_.describe(problem_.graph(), edge) + ": " + why);
  }

  void evaluate(const graft_edge_batch& one, std::int64_t edge, double* jacobian) {
    graft_message message = {};
    const auto call = [&] {
      return group_.type->evaluate(&one, errors_.data(), jacobian, &message);
    };
    if (callPlugin(Callback::kEvaluate, group_.type->tag, message, call) != GRAFT_OK) {
      fail(edge, withPlugin(message.text, group_.type->tag));
    }
  }

  Eigen::VectorXd errorAt(graft_edge_batch one, std::int64_t edge, int slot, int axis,
                          double step) {
    const VertexRef v = group_.vertices[std::size_t(edge * group_.arity + slot)];
    const graft_vertex_type& type = problem_.graph().type(v);
    std::copy(one.vertices, one.vertices + group_.arity, pointers_.begin());
    std::vector<double>& x = moved_[std::size_t(slot)];
    x.resize(std::size_t(type.ambient_dim));
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(type.tangent_dim);
    delta[axis] = step;
    callPlugin(Callback::kPlus, type.tag,
               [&] { type.plus(1, one.vertices[slot], delta.data(), x.data()); });
    pointers_[std::size_t(slot)] = x.data();
    one.vertices = pointers_.data();
    evaluate(one, edge, nullptr);
    return errors_;
  }

  Eigen::MatrixXd richardson(const graft_edge_batch& one, std::int64_t edge, double step) {
    Eigen::MatrixXd j(group_.error_dim, group_.tangent_dim);
    for (int slot = 0; slot < group_.arity; ++slot) {
      for (int axis = 0; axis < group_.slot_dims[std::size_t(slot)]; ++axis) {
        const auto central = [&](double h) -> Eigen::VectorXd {
          return (errorAt(one, edge, slot, axis, h) - errorAt(one, edge, slot, axis, -h)) / (2 * h);
        };
        j.col(group_.slot_offsets[std::size_t(slot)] + axis) =
            (4.0 * central(step / 2) - central(step)) / 3.0;
      }
    }
    return j;
  }

  const Problem& problem_;
  const EdgeGroup& group_;
  std::vector<std::vector<double>> moved_;
  std::vector<const double*> pointers_;
  Eigen::VectorXd errors_;
};

/// out = A y for a symmetric matrix by its lower blocks.
Eigen::MatrixXd product(const graft_block_pattern& p, const std::vector<double>& values,
                        const std::vector<std::int64_t>& offsets, const Eigen::MatrixXd& y) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(y.rows(), y.cols());
  for (std::int32_t c = 0; c < p.block_count; ++c) {
    for (std::int64_t b = p.columns[c]; b < p.columns[c + 1]; ++b) {
      const std::int32_t r = p.rows[b];
      const Eigen::Map<const Eigen::MatrixXd> block(values.data() + p.offsets[b], p.dims[r],
                                                    p.dims[c]);
      const auto at_r = offsets[std::size_t(r)];
      const auto at_c = offsets[std::size_t(c)];
      out.middleRows(at_r, p.dims[r]) += block * y.middleRows(at_c, p.dims[c]);
      if (r != c) {
        out.middleRows(at_c, p.dims[c]) += block.transpose() * y.middleRows(at_r, p.dims[r]);
      }
    }
  }
  return out;
}

/// Below this, of the largest entry, a vertex's own block resists nothing.
constexpr double kOwn = 1e-13;

/// What a vertex's own block of A = J'J leaves free: no edge of the vertex resists
/// it, whatever else moves. Closes those directions in `values`.
void closeOwnDirections(const Problem& problem, const NormalEquations& equations,
                        std::vector<double>& values, std::vector<FreeDirection>& found) {
  const graft_block_pattern& pattern = equations.pattern();
  double largest = 0;
  for (const double entry : equations.diagonal()) largest = std::max(largest, entry);
  if (!(largest > 0)) largest = 1;
  for (std::int32_t c = 0; c < pattern.block_count; ++c) {
    const int dim = pattern.dims[c];
    Eigen::Map<Eigen::MatrixXd> block(values.data() + pattern.offsets[pattern.columns[c]], dim,
                                      dim);
    const Eigen::MatrixXd own = block.selfadjointView<Eigen::Lower>();
    const double scale = own.diagonal().maxCoeff();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(own);
    for (Eigen::Index k = 0; k < dim; ++k) {
      if (scale > 0 && eigen.eigenvalues()[k] > kOwn * scale) break;
      const Eigen::VectorXd direction = eigen.eigenvectors().col(k);
      found.push_back({problem.freeVertices()[std::size_t(c)], direction, 1.0});
      block += (scale > 0 ? scale : largest) * direction * direction.transpose();
    }
  }
}

/// An orthonormal basis of what A leaves free, by subspace iteration with the
/// inverse of A + a little of its diagonal.
Eigen::MatrixXd nullSpace(const Problem& problem, const NormalEquations& equations,
                          const std::vector<double>& matrix, BlockCholesky& cholesky) {
  constexpr int kVectors = 12;
  constexpr int kIterations = 6;
  constexpr double kDamping = 1e-9;
  // Of the generalized eigenvalues by the diagonal; damping and rounding stay below.
  constexpr double kFree = 1e-12;
  const std::int64_t n = problem.dim();
  const int m = int(std::min<std::int64_t>(kVectors, n));
  double largest = 0;
  for (const double entry : equations.diagonal()) largest = std::max(largest, entry);
  if (!(largest > 0)) largest = 1;
  Eigen::VectorXd scale(n);
  std::vector<double> damping(std::size_t(n), 0.0);
  for (std::int64_t i = 0; i < n; ++i) {
    scale[i] = std::max(equations.diagonal()[std::size_t(i)], 1e-9 * largest);
    damping[std::size_t(i)] = kDamping * scale[i];
  }
  if (cholesky.factorize(matrix.data(), damping.data()) >= 0) return {};
  Eigen::MatrixXd y(n, m);
  // Any start does that is not special; this one needs no generator.
  for (Eigen::Index i = 0; i < y.size(); ++i)
    y.data()[i] = std::sin(1.0 + 0.7 * double(i * i % 997));
  for (int k = 0; k < kIterations; ++k) {
    y = scale.asDiagonal() * y;
    for (int c = 0; c < m; ++c) cholesky.solve(y.col(c).data(), y.col(c).data());
    y = Eigen::MatrixXd(Eigen::HouseholderQR<Eigen::MatrixXd>(y).householderQ() *
                        Eigen::MatrixXd::Identity(n, m));
  }
  const Eigen::MatrixXd ay = product(equations.pattern(), matrix, problem.offsets(), y);
  const Eigen::MatrixXd a = y.transpose() * ay;
  const Eigen::MatrixXd b = y.transpose() * scale.asDiagonal() * y;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (a + a.transpose()),
                                                                        b);
  int free = 0;
  while (free < m && eigen.eigenvalues()[free] < kFree) ++free;
  if (free == 0) return {};
  const Eigen::MatrixXd basis = y * eigen.eigenvectors().leftCols(free);
  return Eigen::MatrixXd(Eigen::HouseholderQR<Eigen::MatrixXd>(basis).householderQ() *
                         Eigen::MatrixXd::Identity(n, free));
}

}  // namespace

std::vector<JacobianCheck> checkJacobians(const Problem& problem, const Values& values) {
  const State state = stateAt(problem, values);
  std::map<std::string, JacobianCheck> checks;
  for (std::size_t g = 0; g < problem.groups().size(); ++g) {
    const EdgeGroup& group = problem.groups()[g];
    JacobianCheck& check = checks[group.type->tag];
    check.tag = group.type->tag;
    check.edges += group.count;
    const EdgeBatch batch(group, g, state, 0, group.count);
    Differences differences(problem, group);
    for (std::int64_t e = 0; e < group.count; ++e) {
      const double difference = differences.worst(batch.single(e), e);
      if (!(difference <= kJacobianTolerance)) ++check.suspicious;
      if (difference > check.worst || check.worst_edge.empty()) {
        check.worst = difference;
        check.worst_edge = group.describe(problem.graph(), e);
      }
    }
  }
  std::vector<JacobianCheck> list;
  list.reserve(checks.size());
  for (auto& entry : checks) list.push_back(std::move(entry.second));
  return list;
}

std::vector<OddWeight> findOddWeights(const Problem& problem) {
  constexpr std::size_t kEnough = 5;
  std::vector<OddWeight> odd;
  for (const EdgeGroup& group : problem.groups()) {
    const auto dim = std::size_t(group.error_dim);
    const auto count = std::size_t(group.count);
    if (count < kEnough) continue;
    std::vector<double> extreme(count, 1.0);
    for (std::size_t i = 0; i < dim; ++i) {
      std::vector<double> weights(count);
      for (std::size_t e = 0; e < count; ++e) {
        const double* column = group.roots.data() + (e * dim + i) * dim;
        for (std::size_t r = 0; r < dim; ++r) weights[e] += column[r] * column[r];
      }
      std::vector<double> sorted = weights;
      sorted.erase(std::remove(sorted.begin(), sorted.end(), 0.0), sorted.end());
      if (sorted.size() < kEnough) continue;
      const auto middle = sorted.begin() + std::ptrdiff_t(sorted.size() / 2);
      std::nth_element(sorted.begin(), middle, sorted.end());
      for (std::size_t e = 0; e < count; ++e) {
        const double ratio = weights[e] / *middle;
        if (ratio > 0 && std::abs(std::log(ratio)) > std::abs(std::log(extreme[e]))) {
          extreme[e] = ratio;
        }
      }
    }
    for (std::size_t e = 0; e < count; ++e) {
      if (std::abs(std::log(extreme[e])) <= std::log(kOddWeight)) continue;
      odd.push_back({group.describe(problem.graph(), std::int64_t(e)), extreme[e]});
    }
  }
  std::stable_sort(odd.begin(), odd.end(), [](const OddWeight& a, const OddWeight& b) {
    return std::abs(std::log(a.ratio)) > std::abs(std::log(b.ratio));
  });
  return odd;
}

std::vector<FreeDirection> findFreeDirections(const Problem& problem, const Values& values) {
  std::vector<FreeDirection> directions;
  if (problem.freeVertices().empty()) return directions;
  ThreadPool pool(1);
  Linearizer linearizer(problem, pool);
  State state;
  Evaluation evaluation = linearizer.begin(values, state);
  if (evaluation.ok()) evaluation = linearizer.linearize(state);
  if (!evaluation.ok()) throw Error(ExitCode::kNoResult, evaluation.failure);
  NormalEquations equations(problem);
  equations.gather(linearizer, pool);
  BlockCholesky cholesky(&pool);
  cholesky.analyze(equations.pattern());
  if (cholesky.factorize(equations.hessian().data(), nullptr) < 0) return directions;
  std::vector<double> matrix = equations.hessian();
  closeOwnDirections(problem, equations, matrix, directions);
  if (cholesky.factorize(matrix.data(), nullptr) < 0) return directions;
  const std::size_t own = directions.size();
  const Eigen::MatrixXd basis = nullSpace(problem, equations, matrix, cholesky);
  FreeDirection largest;
  largest.share = 0;
  for (std::size_t i = 0; i < problem.freeVertices().size() && basis.cols() > 0; ++i) {
    const Eigen::MatrixXd part = basis.middleRows(problem.offsets()[i], problem.dims()[i]);
    // What the vertex moves by in all null vectors together does not depend on the
    // basis that was found.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(part * part.transpose());
    for (Eigen::Index k = eigen.eigenvalues().size() - 1; k >= 0; --k) {
      const double share = std::min(1.0, eigen.eigenvalues()[k]);
      const FreeDirection direction{problem.freeVertices()[i], eigen.eigenvectors().col(k), share};
      if (share >= 0.1) directions.push_back(direction);
      if (share > largest.share) largest = direction;
    }
  }
  if (directions.size() == own && largest.share > 0) directions.push_back(largest);
  std::stable_sort(
      directions.begin() + std::ptrdiff_t(own), directions.end(),
      [](const FreeDirection& a, const FreeDirection& b) { return a.share > b.share + 1e-9; });
  return directions;
}

std::string describe(const Problem& problem, const FreeDirection& free) {
  const graft_vertex_type& type = problem.graph().type(free.vertex);
  std::vector<std::string> names;
  LineTokens fields(type.fields == nullptr ? "" : type.fields);
  for (std::string_view name = fields.next(); !name.empty(); name = fields.next()) {
    names.emplace_back(name);
  }
  std::string text;
  for (Eigen::Index i = 0; i < free.direction.size(); ++i) {
    if (std::abs(free.direction[i]) < 1e-3) continue;
    char part[64];
    const bool named = type.ambient_dim == type.tangent_dim && names.size() > std::size_t(i);
    const std::string name = named ? names[std::size_t(i)] : "tangent " + std::to_string(i + 1);
    std::snprintf(part, sizeof part, "%s%.3g %s", text.empty() ? "" : ", ", free.direction[i],
                  name.c_str());
    text += part;
  }
  return problem.describeVertex(free.vertex) + " is free along (" + text + ")" +
         (free.share > 0.9 ? "" : ", together with others");
}

std::vector<std::string> describeFreeDirections(const Problem& problem, const Values& values,
                                                std::size_t limit) {
  std::vector<std::string> texts;
  std::vector<FreeDirection> directions;
  try {
    directions = findFreeDirections(problem, values);
  } catch (const Error& e) {
    if (e.code() != ExitCode::kNoResult) throw;
  }
  for (const FreeDirection& free : directions) {
    if (texts.size() == limit) {
      texts.push_back("... and " + std::to_string(directions.size() - limit) +
                      " more free directions");
      break;
    }
    texts.push_back(describe(problem, free));
  }
  return texts;
}

bool hasOpenBlock(const NormalEquations& equations) {
  const graft_block_pattern& pattern = equations.pattern();
  std::vector<double> lower;
  for (std::int32_t c = 0; c < pattern.block_count; ++c) {
    const int dim = pattern.dims[c];
    const double* block = equations.hessian().data() + pattern.offsets[pattern.columns[c]];
    lower.assign(block, block + dim * dim);
    double scale = 0;
    for (int i = 0; i < dim; ++i)
      scale = std::max(scale, lower[std::size_t(i) * std::size_t(dim + 1)]);
    // Cholesky by columns; a pivot that vanishes leaves a direction open.
    for (int j = 0; j < dim; ++j) {
      double* column = lower.data() + j * dim;
      if (!(column[j] > kOwn * scale)) return true;
      const double root = std::sqrt(column[j]);
      for (int i = j; i < dim; ++i) column[i] /= root;
      for (int k = j + 1; k < dim; ++k) {
        for (int i = k; i < dim; ++i)
          lower[std::size_t(k) * std::size_t(dim) + std::size_t(i)] -= column[i] * column[k];
      }
    }
  }
  return false;
}

bool hasWeakAnchor(const Problem& problem) {
  enum Anchor : std::uint8_t { kNone, kWeak, kFirm };
  const std::size_t count = problem.freeVertices().size();
  std::vector<Anchor> anchors(count, kNone);
  DisjointSets sets(count);
  bool any = false;
  for (const EdgeGroup& group : problem.groups()) {
    const std::int64_t size = std::int64_t{group.error_dim} * group.error_dim;
    for (std::int64_t e = 0; e < group.count; ++e) {
      const std::int32_t* blocks = group.blocks.data() + e * group.arity;
      std::int32_t first = -1;
      bool held = false;
      for (int k = 0; k < group.arity; ++k) {
        if (blocks[k] < 0) {
          held = true;
        } else if (first < 0) {
          first = blocks[k];
        } else {
          sets.merge(std::size_t(first), std::size_t(blocks[k]));
        }
      }
      if (first < 0) continue;
      Anchor& anchor = anchors[std::size_t(first)];
      if (held) anchor = kFirm;
      if (group.arity > 1 || (group.type->flags & GRAFT_EDGE_RELATIVE) != 0) continue;
      any = true;
      if (anchor == kFirm) continue;
      const Eigen::Map<const Eigen::MatrixXd> root(group.roots.data() + e * size, group.error_dim,
                                                   group.error_dim);
      const bool whole = group.error_dim >= group.tangent_dim &&
                         root.colPivHouseholderQr().rank() >= group.tangent_dim;
      anchor = whole ? kFirm : kWeak;
    }
  }
  if (!any) return false;
  std::vector<Anchor> of_set(count, kNone);
  for (std::size_t i = 0; i < count; ++i) {
    Anchor& whole = of_set[sets.find(i)];
    whole = std::max(whole, anchors[i]);
  }
  return std::find(of_set.begin(), of_set.end(), kWeak) != of_set.end();
}

}  // namespace graft
