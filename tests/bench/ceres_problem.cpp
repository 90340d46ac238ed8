// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/ceres_problem.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

namespace graft::bench {

namespace {

template <class T, int N>
using Vector = Eigen::Matrix<T, N, 1>;

template <int N>
using Root = Eigen::Matrix<double, N, N>;

/// U with information = U' U.
template <int N>
Root<N> rootOf(const double* upper) {
  Root<N> information;
  for (int r = 0; r < N; ++r) {
    for (int c = r; c < N; ++c) information(r, c) = information(c, r) = *upper++;
  }
  return information.llt().matrixU();
}

template <class T>
T wrapped(const T& angle) {
  using std::floor;
  const double pi = 3.14159265358979323846;
  return angle - T(2 * pi) * floor((angle + T(pi)) / T(2 * pi));
}

struct Between2 {
  Vector<double, 3> z;
  Root<3> root;
  template <class T>
  bool operator()(const T* a, const T* b, T* residual) const {
    using std::cos;
    using std::sin;
    const T c = cos(a[2]), s = sin(a[2]);
    const T dx = b[0] - a[0], dy = b[1] - a[1];
    const T x = c * dx + s * dy - T(z[0]), y = -s * dx + c * dy - T(z[1]);
    const double cz = std::cos(z[2]), sz = std::sin(z[2]);
    Vector<T, 3> e(cz * x + sz * y, -sz * x + cz * y, wrapped(T(b[2] - a[2] - z[2])));
    Eigen::Map<Vector<T, 3>>(residual, 3) = root.cast<T>() * e;
    return true;
  }
};

struct Seen2 {
  Vector<double, 2> z;
  Root<2> root;
  template <class T>
  bool operator()(const T* a, const T* p, T* residual) const {
    using std::cos;
    using std::sin;
    const T c = cos(a[2]), s = sin(a[2]);
    const T dx = p[0] - a[0], dy = p[1] - a[1];
    Vector<T, 2> e(c * dx + s * dy - T(z[0]), -s * dx + c * dy - T(z[1]));
    Eigen::Map<Vector<T, 2>>(residual, 2) = root.cast<T>() * e;
    return true;
  }
};

/// t x y z, then the quaternion x y z w.
struct Between3 {
  Vector<double, 3> t;
  Eigen::Quaterniond q;
  Root<6> root;
  template <class T>
  bool operator()(const T* a_t, const T* a_q, const T* b_t, const T* b_q, T* residual) const {
    using Q = Eigen::Quaternion<T>;
    const Eigen::Map<const Vector<T, 3>> ta(a_t), tb(b_t);
    const Eigen::Map<const Q> qa(a_q), qb(b_q);
    const Q back = q.conjugate().cast<T>();
    Q rest = back * (qa.conjugate() * qb);
    if (rest.w() < T(0)) rest.coeffs() = -rest.coeffs();
    Vector<T, 6> e;
    e.template head<3>() = back * (qa.conjugate() * (tb - ta) - t.cast<T>());
    e.template tail<3>() = rest.vec();
    Eigen::Map<Vector<T, 6>>(residual, 6) = root.cast<T>() * e;
    return true;
  }
};

struct Seen3 {
  Vector<double, 3> z;
  Root<3> root;
  template <class T>
  bool operator()(const T* a_t, const T* a_q, const T* p, T* residual) const {
    const Eigen::Map<const Vector<T, 3>> ta(a_t), point(p);
    const Eigen::Map<const Eigen::Quaternion<T>> qa(a_q);
    const Vector<T, 3> e = qa.conjugate() * (point - ta) - z.cast<T>();
    Eigen::Map<Vector<T, 3>>(residual, 3) = root.cast<T>() * e;
    return true;
  }
};

class Builder {
 public:
  Builder(const Graph& graph, const Values& values) : graph_(graph) {
    for (const VertexRef v : graph.verticesById()) {
      const double* numbers = values.at(v);
      estimates_[graph.id(v)].assign(numbers, numbers + graph.type(v).ambient_dim);
    }
  }

  void build(std::int64_t held) {
    for (const EdgeBlock& block : graph_.edgeBlocks()) {
      for (std::size_t e = 0; e < block.size(); ++e) add(block, e);
    }
    for (auto& [id, numbers] : estimates_) {
      const bool fixed = id == held || graph_.isFixed(graph_.find(id));
      double* first = numbers.data();
      if (fixed && problem_.HasParameterBlock(first)) problem_.SetParameterBlockConstant(first);
      if (numbers.size() != 7 || !problem_.HasParameterBlock(first + 3)) continue;
      problem_.SetManifold(first + 3, new ceres::EigenQuaternionManifold);
      if (fixed) problem_.SetParameterBlockConstant(first + 3);
    }
  }
  ceres::Problem& problem() { return problem_; }
  /// Where points outnumber poses, eliminating them first is Ceres' faster way.
  bool isMostlyPoints() const {
    std::size_t points = 0;
    for (const VertexRef v : graph_.verticesById()) {
      const std::string tag = graph_.type(v).tag;
      points += tag == "VERTEX_XY" || tag == "VERTEX_TRACKXYZ" ? 1 : 0;
    }
    return 2 * points > graph_.verticesById().size();
  }

 private:
  void add(const EdgeBlock& block, std::size_t e) {
    const std::string tag = block.type->tag;
    const double* z = &block.measurements[std::size_t(block.measurement_begin[e])];
    const double* omega = &block.information[std::size_t(block.information_begin[e])];
    const VertexRef* slots = &block.vertices[std::size_t(block.vertex_begin[e])];
    double* a = estimates_.at(graph_.id(slots[0])).data();
    double* b = estimates_.at(graph_.id(slots[1])).data();
    if (tag == "EDGE_SE2") {
      auto* cost = new Between2{{z[0], z[1], z[2]}, rootOf<3>(omega)};
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<Between2, 3, 3, 3>(cost), nullptr,
                                a, b);
    } else if (tag == "EDGE_SE2_XY") {
      auto* cost = new Seen2{{z[0], z[1]}, rootOf<2>(omega)};
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<Seen2, 2, 3, 2>(cost), nullptr, a,
                                b);
    } else if (tag == "EDGE_SE3:QUAT") {
      auto* cost = new Between3{{z[0], z[1], z[2]}, {z[6], z[3], z[4], z[5]}, rootOf<6>(omega)};
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<Between3, 6, 3, 4, 3, 4>(cost),
                                nullptr, a, a + 3, b, b + 3);
    } else if (tag == "EDGE_SE3_TRACKXYZ") {
      auto* cost = new Seen3{{z[0], z[1], z[2]}, rootOf<3>(omega)};
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<Seen3, 3, 3, 4, 3>(cost), nullptr,
                                a, a + 3, b);
    } else {
      throw std::runtime_error("edges of type " + tag + " are not known to this bench");
    }
  }

  const Graph& graph_;
  std::map<std::int64_t, std::vector<double>> estimates_;
  ceres::Problem problem_;
};

}  // namespace

PeerResult solveWithCeres(const Graph& graph, const Values& values, std::int64_t held,
                          int threads) {
  Builder builder(graph, values);
  builder.build(held);
  ceres::Solver::Options options;
  options.linear_solver_type =
      builder.isMostlyPoints() ? ceres::SPARSE_SCHUR : ceres::SPARSE_NORMAL_CHOLESKY;
  options.num_threads = threads;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-6;
  options.initial_trust_region_radius = 1e10;  // as little damping as graft begins with
  options.max_trust_region_radius = 1e20;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &builder.problem(), &summary);
  PeerResult result;
  result.chi2 = 2 * summary.final_cost;
  result.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps - 1;
  result.seconds = summary.total_time_in_seconds;
  result.usable = summary.IsSolutionUsable();
  return result;
}

}  // namespace graft::bench
