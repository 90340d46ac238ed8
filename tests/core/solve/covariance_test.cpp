// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "core/base/error.hpp"
#include "core/geometry/se2.hpp"
#include "core/graph/factor_graph.hpp"
#include "core/linear/selected_inverse.hpp"
#include "core/plugin/engine.hpp"
#include "core/solve/linearizer.hpp"
#include "core/solve/normal_equations.hpp"
#include "tests/support/graphs.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

using Pairs = std::vector<std::pair<VertexRef, VertexRef>>;

/// J'J summed densely from the Jacobians of every edge.
Eigen::MatrixXd denseHessian(const Problem& problem, const Values& values) {
  ThreadPool pool(1);
  Linearizer linearizer(problem, pool);
  State state;
  EXPECT_TRUE(linearizer.begin(values, state).ok());
  EXPECT_TRUE(linearizer.linearize(state).ok());
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(problem.dim(), problem.dim());
  for (std::size_t g = 0; g < problem.groups().size(); ++g) {
    const EdgeGroup& group = problem.groups()[g];
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    for (std::int64_t e = 0; e < group.count; ++e) {
      const Eigen::Map<const RowMajor> jacobian(
          linearizer.jacobians(g).data() + e * group.error_dim * group.tangent_dim, group.error_dim,
          group.tangent_dim);
      Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(group.error_dim, problem.dim());
      for (int slot = 0; slot < group.arity; ++slot) {
        const std::int32_t block = group.blocks[std::size_t(e * group.arity + slot)];
        if (block < 0) continue;
        const int dim = group.slot_dims[std::size_t(slot)];
        wide.middleCols(problem.offsets()[std::size_t(block)], dim) +=
            jacobian.middleCols(group.slot_offsets[std::size_t(slot)], dim);
      }
      hessian += wide.transpose() * wide;
    }
  }
  return hessian;
}

class CovarianceTest : public ::testing::Test {
 protected:
  double uniform(double extent) {
    return std::uniform_real_distribution<double>(-extent, extent)(random_);
  }
  std::vector<double> numbers(int count, double extent) {
    std::vector<double> list;
    for (int i = 0; i < count; ++i) list.push_back(uniform(extent));
    return list;
  }
  std::vector<double> information(int n) {
    Eigen::MatrixXd root(n, n);
    for (Eigen::Index i = 0; i < root.size(); ++i) root.data()[i] = uniform(1);
    const Eigen::MatrixXd omega = root.transpose() * root + 0.1 * Eigen::MatrixXd::Identity(n, n);
    std::vector<double> upper;
    for (int r = 0; r < n; ++r) {
      for (int c = r; c < n; ++c) upper.push_back(omega(r, c));
    }
    return upper;
  }
  /// Poses in the plane with landmarks, seen one by one, in pairs (ternary edges) and
  /// several at once; ids from `first` on.
  void addPlane(FactorGraph& g, std::int64_t first, int poses, int landmarks) {
    for (int i = 0; i < poses; ++i) g.addVertex("VERTEX_SE2", first + i, numbers(3, 3));
    const std::int64_t marks = first + poses;
    for (int i = 0; i < landmarks; ++i) g.addVertex("VERTEX_XY", marks + i, numbers(2, 10));
    for (int i = 1; i < poses; ++i) {
      g.addEdge("EDGE_SE2", {first + i - 1, first + i}, numbers(3, 2), information(3));
      if (i % 5 == 0) g.addEdge("EDGE_SE2", {first + i - 5, first + i}, numbers(3, 2));
    }
    const auto pose = [&] { return first + std::int64_t(random_() % std::uint64_t(poses)); };
    for (int i = 0; i < landmarks; ++i) {
      g.addEdge("EDGE_SE2_XY", {pose(), marks + i}, numbers(2, 5), information(2));
      g.addEdge("EDGE_SE2_XY", {pose(), marks + i}, numbers(2, 5), information(2));
      if (i == 0) continue;
      if (i % 3 == 0) {
        g.addEdge("EDGE_SE2_TWOPOINTSXY", {pose(), marks + i, marks + i - 1}, numbers(4, 5),
                  information(4));
      }
      if (i % 7 == 0) {
        std::vector<double> seen = numbers(6, 5);
        seen.insert(seen.begin(), 3);
        g.addEdge("EDGE_SE2_LOTSOFXY", {pose(), marks + i, marks + i - 3, marks + i - 5}, seen,
                  information(6));
      }
    }
  }
  void addSpace(FactorGraph& g, std::int64_t first, int poses, int landmarks) {
    const auto estimate = [&] {
      const Eigen::Quaterniond q =
          Eigen::Quaterniond(1, uniform(0.5), uniform(0.5), uniform(0.5)).normalized();
      return std::vector<double>{uniform(5), uniform(5), uniform(5), q.x(), q.y(), q.z(), q.w()};
    };
    for (int i = 0; i < poses; ++i) g.addVertex("VERTEX_SE3:QUAT", first + i, estimate());
    const std::int64_t marks = first + poses;
    for (int i = 0; i < landmarks; ++i) g.addVertex("VERTEX_TRACKXYZ", marks + i, numbers(3, 9));
    for (int i = 1; i < poses; ++i) {
      g.addEdge("EDGE_SE3:QUAT", {first + i - 1, first + i}, estimate(), information(6));
      if (i % 6 == 0) g.addEdge("EDGE_SE3:QUAT", {first + i - 6, first + i}, estimate());
    }
    for (int i = 0; i < 3 * landmarks; ++i) {
      g.addEdge("EDGE_SE3_TRACKXYZ",
                {first + std::int64_t(random_() % std::uint64_t(poses)), marks + i / 3},
                numbers(3, 5), information(3), {1});
    }
  }
  FactorGraph graph() {
    FactorGraph g(engine_.registry());
    g.addResource("PARAMS_SE3OFFSET", 1, {"1", "2", "3", "0.5", "0.5", "-0.5", "0.5"}, ".");
    return g;
  }

  /// All marginals, and all joint covariances, against the dense inverse. Both are
  /// measured in units of the two vertices' own deviations.
  static void expectDenseInverse(const FactorGraph& g) {
    const Problem problem(g.graph(), InformationPolicy::kError);
    ASSERT_LE(g.graph().verticesById().size(), 200u);
    const Eigen::MatrixXd inverse =
        denseHessian(problem, g.values())
            .ldlt()
            .solve(Eigen::MatrixXd::Identity(problem.dim(), problem.dim()));
    const std::vector<VertexRef> vertices = g.graph().verticesById();
    Pairs pairs;
    for (const VertexRef a : vertices) {
      for (const VertexRef b : vertices) pairs.emplace_back(a, b);
    }
    const auto check = [&](VertexRef a, VertexRef b, const Eigen::MatrixXd& block) {
      const std::int32_t i = problem.blockOf(a);
      const std::int32_t j = problem.blockOf(b);
      ASSERT_EQ(block.rows(), g.graph().type(a).tangent_dim);
      ASSERT_EQ(block.cols(), g.graph().type(b).tangent_dim);
      if (i < 0 || j < 0) {
        EXPECT_TRUE(block.isZero(0));
        return;
      }
      const Eigen::Index row = problem.offsets()[std::size_t(i)];
      const Eigen::Index column = problem.offsets()[std::size_t(j)];
      const Eigen::VectorXd deviations = inverse.diagonal().cwiseSqrt();
      const Eigen::MatrixXd scaled =
          deviations.segment(row, block.rows()).cwiseInverse().asDiagonal() *
          (block - inverse.block(row, column, block.rows(), block.cols())) *
          deviations.segment(column, block.cols()).cwiseInverse().asDiagonal();
      EXPECT_LT(scaled.cwiseAbs().maxCoeff(), 1e-9)
          << problem.describeVertex(a) << " " << problem.describeVertex(b);
    };
    const std::vector<Eigen::MatrixXd> joint = jointCovariances(g.graph(), g.values(), pairs);
    for (std::size_t i = 0; i < pairs.size(); ++i) check(pairs[i].first, pairs[i].second, joint[i]);
    const std::vector<Eigen::MatrixXd> marginals =
        marginalCovariances(g.graph(), g.values(), vertices);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      check(vertices[i], vertices[i], marginals[i]);
      EXPECT_TRUE(marginals[i] == marginals[i].transpose());
    }
  }

  std::mt19937_64 random_{3};
  Engine engine_;
};

TEST_F(CovarianceTest, EqualsTheDenseInverseInThePlane) {
  for (const int poses : {2, 30, 120}) {
    FactorGraph g = graph();
    addPlane(g, 0, poses, poses / 2 + 8);
    g.fix(poses / 2);
    expectDenseInverse(g);
  }
}

TEST_F(CovarianceTest, EqualsTheDenseInverseInSpace) {
  FactorGraph g = graph();
  addSpace(g, 0, 60, 140);
  expectDenseInverse(g);  // the first pose is held
}

TEST_F(CovarianceTest, EqualsTheDenseInverseForSeveralComponentsAndFixedVertices) {
  FactorGraph g = graph();
  addPlane(g, 1000, 20, 12);
  addSpace(g, 0, 12, 10);
  addPlane(g, 2000, 9, 9);
  g.addVertex("VERTEX_SE2", 3000, {1, 2, 3});  // no edge
  g.fix(1003);
  g.fix(1025);
  g.fix(13);
  g.fix(4);
  expectDenseInverse(g);
}

TEST_F(CovarianceTest, NamesAVertexThatIsNotDetermined) {
  FactorGraph g = graph();
  addPlane(g, 0, 6, 8);
  g.fix(0);
  g.addVertex("VERTEX_XY", 77, {4, 1});
  g.addEdge("EDGE_BEARING_SE2_XY", {2, 77}, {0.3});
  try {
    marginalCovariances(g.graph(), g.values(), {g.graph().find(1)});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kNoResult);
    EXPECT_STREQ(error.what(), "no covariance: the system is singular at VERTEX_XY 77");
  }
}

/// Marginals of a real graph against solutions with unit vectors.
TEST_F(CovarianceTest, AgreesWithSolvingOnTheSphere) {
  GRAFT_REQUIRE_DATA("pose_graphs/sphere2500.g2o");
  const LoadedGraph loaded = testing::loadData("pose_graphs/sphere2500.g2o", engine_.registry());
  const std::vector<VertexRef> vertices = loaded.graph.verticesById();
  const std::vector<Eigen::MatrixXd> marginals =
      marginalCovariances(loaded.graph, loaded.values, vertices);
  const Problem problem(loaded.graph, InformationPolicy::kError);
  ThreadPool pool(2);
  Linearizer linearizer(problem, pool);
  State state;
  ASSERT_TRUE(linearizer.begin(loaded.values, state).ok());
  ASSERT_TRUE(linearizer.linearize(state).ok());
  NormalEquations equations(problem);
  equations.gather(linearizer, pool);
  BlockCholesky cholesky(&pool);
  cholesky.analyze(equations.pattern());
  ASSERT_EQ(cholesky.factorize(equations.hessian().data(), nullptr), -1);
  for (std::size_t i = 0; i < vertices.size(); i += 83) {
    const std::int32_t block = problem.blockOf(vertices[i]);
    if (block < 0) continue;
    const Eigen::Index first = problem.offsets()[std::size_t(block)];
    Eigen::MatrixXd expected(6, 6);
    for (int c = 0; c < 6; ++c) {
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(problem.dim(), first + c);
      Eigen::VectorXd column(problem.dim());
      cholesky.solve(unit.data(), column.data());
      expected.col(c) = column.segment(first, 6);
    }
    EXPECT_LT((marginals[i] - expected).norm(), 1e-9 * expected.norm()) << i;
  }
}

}  // namespace
}  // namespace graft
