// SPDX-License-Identifier: BSD-3-Clause
#include "tests/core/solve/solve_types.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "core/geometry/point.hpp"
#include "core/types/plugin.hpp"

namespace graft {
namespace testing {

template <class T>
struct TestPoint2 : Point2<T> {
  TestPoint2() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a tag, not another value.
  TestPoint2(const Point2<T>& p) : Point2<T>(p) {}
  static TestPoint2 fromArray(const double* p) { return Point2<T>::fromArray(p); }
  TestPoint2 plus(const Vec<T, 2>& d) const { return Point2<T>::plus(d); }
};

}  // namespace testing

template <>
struct VertexTag<testing::TestPoint2> {
  static constexpr const char* kTag = "TEST_POINT2";
  static constexpr const char* kDoc = "a point in the plane";
};

namespace testing {

namespace {

/// A relative pose is measured.
template <class Self, int N, template <class> class P>
struct Between : Edge<Self, N, P, P>, Measured<P<double>> {
  template <class T>
  Vec<T, N> error(const P<T>& a, const P<T>& b) const {
    return poseError(this->measurement.inverse().template cast<T>() * (a.inverse() * b));
  }
  bool propagate(int to, P<double>& a, P<double>& b) const {
    (to == 1 ? b : a) = to == 1 ? a * this->measurement : b * this->measurement.inverse();
    return true;
  }
};

struct Between2 : Between<Between2, 3, SE2> {
  static constexpr auto tag = "TEST_BETWEEN2";
  static constexpr auto doc = "relative pose in the plane";
};

struct Between3 : Between<Between3, 6, SE3> {
  static constexpr auto tag = "TEST_BETWEEN3";
  static constexpr auto doc = "relative pose in space";
};

/// Where a point is is measured.
template <class Self>
struct Pull : Edge<Self, 2, TestPoint2>, Measured<Numbers<2>> {
  template <class T>
  Vec<T, 2> error(const TestPoint2<T>& p) const {
    return p.coordinates - this->measurement.values.template cast<T>();
  }
};

struct Prior : Pull<Prior> {
  static constexpr auto tag = "TEST_PRIOR";
  static constexpr auto doc = "a point is at x y";
};

struct Difference : Edge<Difference, 2, TestPoint2, TestPoint2>, Measured<Numbers<2>> {
  static constexpr auto tag = "TEST_DIFFERENCE";
  static constexpr auto doc = "b - a";
  template <class T>
  Vec<T, 2> error(const TestPoint2<T>& a, const TestPoint2<T>& b) const {
    return b.coordinates - a.coordinates - measurement.values.cast<T>();
  }
};

struct Range : Edge<Range, 1, TestPoint2, TestPoint2>, Measured<Numbers<1>> {
  static constexpr auto tag = "TEST_RANGE";
  static constexpr auto doc = "distance of two points";
  template <class T>
  Vec<T, 1> error(const TestPoint2<T>& a, const TestPoint2<T>& b) const {
    using std::sqrt;
    const T x = b.coordinates[0] - a.coordinates[0];
    const T y = b.coordinates[1] - a.coordinates[1];
    return Vec<T, 1>(sqrt(x * x + y * y) - measurement.values[0]);
  }
};

struct Nearest : Edge<Nearest, 2, TestPoint2>, Measured<Numbers<6>>, Associated<1> {
  static constexpr auto tag = "TEST_NEAREST";
  static constexpr auto doc = "a point is at the nearest of three anchors";
  template <class T>
  Vec<T, 2> error(const TestPoint2<T>& p) const {
    const int i = 2 * int(*association);
    return Vec<T, 2>(p.coordinates[0] - measurement.values[i],
                     p.coordinates[1] - measurement.values[i + 1]);
  }
  bool associate(bool first, const TestPoint2<double>& p, const InformationBlock& information,
                 double* chosen) const {
    double best = std::numeric_limits<double>::infinity();
    int choice = 0;
    for (int i = 0; i < 3; ++i) {
      const Vec<double, 2> e = p.coordinates - measurement.values.segment<2>(2 * i);
      const double cost = e.dot(information * e);
      if (cost < best) {
        best = cost;
        choice = i;
      }
    }
    const bool changed = !first && int(*chosen) != choice;
    *chosen = choice;
    return changed;
  }
};

/// TEST_NEAREST that lists its choices.
struct Choice : Edge<Choice, 2, TestPoint2>, Measured<Numbers<6>>, Associated<1> {
  static constexpr auto tag = "TEST_CHOICE";
  static constexpr auto doc = "a point is at the nearest of three anchors, or at another";
  template <class T>
  Vec<T, 2> error(const TestPoint2<T>& p) const {
    const int i = 2 * int(*association);
    return Vec<T, 2>(p.coordinates[0] - measurement.values[i],
                     p.coordinates[1] - measurement.values[i + 1]);
  }
  bool associate(bool first, const TestPoint2<double>& p, const InformationBlock& information,
                 double* chosen) const {
    Nearest nearest;
    nearest.measurement = measurement;
    return nearest.associate(first, p, information, chosen);
  }
  bool alternative(int k, double* chosen) const {
    *chosen = k;
    return k < 3;
  }
};

/// One-sided: a half-plane that an edge sees only once it has been crossed.
struct Beyond : Edge<Beyond, 1, TestPoint2>, Measured<Numbers<3>>, Associated<1> {
  static constexpr auto tag = "TEST_BEYOND";
  static constexpr auto doc = "a x + b y >= c";
  template <class T>
  Vec<T, 1> error(const TestPoint2<T>& p) const {
    const auto& m = measurement.values;
    return Vec<T, 1>(*association * (m[0] * p.coordinates[0] + m[1] * p.coordinates[1] - m[2]));
  }
  bool associate(bool first, const TestPoint2<double>& p, const InformationBlock&,
                 double* chosen) const {
    const auto& m = measurement.values;
    const double before = *chosen;
    *chosen = m[0] * p.coordinates[0] + m[1] * p.coordinates[1] < m[2] ? 1 : 0;
    return first || *chosen != before;
  }
};

struct BeyondSeen : Edge<BeyondSeen, 1, SE2, TestPoint2>, Measured<Numbers<3>>, Associated<1> {
  static constexpr auto tag = "TEST_BEYOND_SEEN";
  static constexpr auto doc = "a x + b y >= c for the point less the pose's position";
  template <class T>
  Vec<T, 1> error(const SE2<T>& pose, const TestPoint2<T>& p) const {
    const auto& m = measurement.values;
    return Vec<T, 1>(*association * (m[0] * (p.coordinates[0] - pose.x) +
                                     m[1] * (p.coordinates[1] - pose.y) - m[2]));
  }
  bool associate(bool first, const SE2<double>& pose, const TestPoint2<double>& p,
                 const InformationBlock&, double* chosen) const {
    const auto& m = measurement.values;
    const double before = *chosen;
    *chosen =
        m[0] * (p.coordinates[0] - pose.x) + m[1] * (p.coordinates[1] - pose.y) < m[2] ? 1 : 0;
    return first || *chosen != before;
  }
};

struct Leash : Edge<Leash, 2, SE2, TestPoint2> {
  static constexpr auto tag = "TEST_LEASH";
  static constexpr auto doc = "the point is where the pose is";
  template <class T>
  Vec<T, 2> error(const SE2<T>& pose, const TestPoint2<T>& p) const {
    return Vec<T, 2>(p.coordinates[0] - pose.x, p.coordinates[1] - pose.y);
  }
};

struct NotFinite : Pull<NotFinite> {
  static constexpr auto tag = "TEST_NAN";
  static constexpr auto doc = "pulls to x y, but is not finite where x > 5";
  template <class T>
  Vec<T, 2> error(const TestPoint2<T>& p) const {
    Vec<T, 2> e = Pull<NotFinite>::error(p);
    if (valueOf(p.coordinates[0]) > 5) e[0] = T(std::numeric_limits<double>::quiet_NaN());
    return e;
  }
};

struct Forgets : Pull<Forgets> {
  static constexpr auto tag = "TEST_FORGETS";
  static constexpr auto doc = "leaves its Jacobian unwritten";
  void jacobians(const TestPoint2<double>&, JacobianBlock<2, 2>) const {}
};

struct Wrong : Pull<Wrong> {
  static constexpr auto tag = "TEST_WRONG";
  static constexpr auto doc = "has a Jacobian of the wrong sign";
  void jacobians(const TestPoint2<double>&, JacobianBlock<2, 2> block) const {
    block = -Mat<double, 2>::Identity();
  }
};

struct Centroid : DynamicEdge<Centroid, TestPoint2> {
  static constexpr auto tag = "TEST_CENTROID";
  static constexpr auto doc = "the mean of n points is at x y";
  static bool shape(int arity, int& error_dim, int& measurement_dim) {
    error_dim = measurement_dim = 2;
    return arity >= 2;
  }
  template <class T>
  void error(const std::vector<TestPoint2<T>>& points, const std::vector<double>& measurement,
             Vec<T, Eigen::Dynamic>& e) const {
    for (int c = 0; c < 2; ++c) {
      T sum = T(0);
      for (const TestPoint2<T>& p : points) sum += p.coordinates[c];
      e[c] = sum * (1.0 / double(points.size())) - measurement[std::size_t(c)];
    }
  }
};

void evaluateCauchy(std::int64_t count, const double* s, double width, double* rho) {
  const double w2 = width * width;
  for (std::int64_t i = 0; i < count; ++i) {
    const double t = 1 + s[i] / w2;
    rho[3 * i] = w2 * std::log(t);
    rho[3 * i + 1] = 1 / t;
    rho[3 * i + 2] = -1 / (w2 * t * t);
  }
}

const graft_kernel_type kCauchy = {sizeof(graft_kernel_type), "cauchy", "w^2 log(1 + s/w^2)",
                                   &evaluateCauchy};

/// Eigen's dense Cholesky behind the solver ABI.
struct DenseSolver {
  const graft_block_pattern* pattern = nullptr;
  Eigen::LLT<Eigen::MatrixXd> factor;

  static int dimOf(const graft_block_pattern& p) {
    int sum = 0;
    for (int i = 0; i < p.block_count; ++i) sum += p.dims[i];
    return sum;
  }
  static int factorize(void* self, const double* values, const double* damping, std::int32_t* bad,
                       graft_message*) {
    auto& solver = *static_cast<DenseSolver*>(self);
    const graft_block_pattern& p = *solver.pattern;
    std::vector<int> begin(1, 0);
    for (int i = 0; i < p.block_count; ++i) begin.push_back(begin.back() + p.dims[i]);
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(begin.back(), begin.back());
    for (int j = 0; j < p.block_count; ++j) {
      for (std::int64_t b = p.columns[j]; b < p.columns[j + 1]; ++b) {
        const int i = p.rows[b];
        a.block(begin[std::size_t(i)], begin[std::size_t(j)], p.dims[i], p.dims[j]) =
            Eigen::Map<const Eigen::MatrixXd>(values + p.offsets[b], p.dims[i], p.dims[j]);
      }
    }
    if (damping != nullptr) a.diagonal() += Eigen::Map<const Eigen::VectorXd>(damping, a.rows());
    solver.factor.compute(a);
    if (solver.factor.info() == Eigen::Success) return GRAFT_OK;
    *bad = 0;
    return GRAFT_NOT_POSITIVE_DEFINITE;
  }
};

const graft_solver_type kDense = {
    sizeof(graft_solver_type),
    "test_dense",
    "dense Cholesky",
    "BSD-3-Clause",
    [](std::int32_t) -> void* { return new DenseSolver; },
    [](void* self) { delete static_cast<DenseSolver*>(self); },
    [](void* self, const graft_block_pattern* pattern, graft_message*) -> int {
      static_cast<DenseSolver*>(self)->pattern = pattern;
      return GRAFT_OK;
    },
    &DenseSolver::factorize,
    [](void* self, const double* b, double* x, graft_message*) -> int {
      const auto& solver = *static_cast<DenseSolver*>(self);
      const int n = DenseSolver::dimOf(*solver.pattern);
      Eigen::Map<Eigen::VectorXd>(x, n) =
          solver.factor.solve(Eigen::Map<const Eigen::VectorXd>(b, n));
      return GRAFT_OK;
    },
    nullptr};

int registerTypes(const graft_registrar* registrar, graft_message*) {
  PluginRegistry types(registrar);
  types.addVertex<SE2>();
  types.addVertex<SE3>();
  types.addVertex<TestPoint2>();
  types.add<Between2>();
  types.add<Between3>();
  types.add<Prior>();
  types.add<Difference>();
  types.add<Range>();
  types.add<Nearest>();
  types.add<Choice>();
  types.add<Beyond>();
  types.add<BeyondSeen>();
  types.add<Leash>();
  types.add<NotFinite>();
  types.add<Forgets>();
  types.add<Wrong>();
  types.add<Centroid>();
  types.addKernel(kCauchy);
  types.addSolver(kDense);
  return GRAFT_OK;
}

std::vector<double> numbersOf(const Pose& pose) {
  std::vector<double> numbers(7);
  pose.toArray(numbers.data());
  return numbers;
}

}  // namespace

Registry& testRegistry() {
  static Registry* registry = [] {
    auto* made = new Registry;
    made->registerPlugin("solve_types", "solve_types.cpp", "1", "BSD-3-Clause", &registerTypes);
    return made;
  }();
  return *registry;
}

VertexRef TestGraph::vertex(const char* tag, std::int64_t id, const std::vector<double>& estimate,
                            bool fixed) {
  const VertexRef v = graph.addVertex(*testRegistry().vertex(tag), id, estimate.data(), values);
  graph.setFixed(v, fixed);
  return v;
}

void TestGraph::edge(const char* tag, const std::vector<std::int64_t>& ids,
                     const std::vector<double>& measurement, const std::vector<double>& information,
                     std::int64_t line, std::int32_t kernel) {
  Graph::EdgeSpec spec;
  spec.type = testRegistry().edge(tag);
  for (const std::int64_t id : ids) spec.vertices.push_back(graph.find(id));
  spec.measurement = measurement;
  spec.information = information;
  spec.line = line;
  spec.kernel = kernel;
  graph.addEdge(std::move(spec));
}

std::vector<double> TestGraph::at(std::int64_t id) const {
  const VertexRef v = graph.find(id);
  return std::vector<double>(values.at(v), values.at(v) + values.dim(v.type));
}

std::vector<PoseGraphPart> makePoseGraph(int count, double noise, double disturbance,
                                         std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto perturb = [&](const Pose& pose, double sigma) {
    Vec<double, 6> delta;
    for (int i = 0; i < 6; ++i) delta[i] = sigma * normal(random);
    return pose.plus(delta);
  };
  std::vector<Pose> truth(1);
  for (int i = 1; i < count; ++i) {
    Vec<double, 6> step;
    step << 1, 0, 0.05, 0.02, 0.01, 0.3;
    truth.push_back(perturb(truth.back().plus(step), 0.02));
  }
  std::vector<PoseGraphPart> parts;
  for (int i = 0; i < count; ++i) {
    const Pose start = i == 0 ? truth[0] : perturb(truth[std::size_t(i)], disturbance);
    parts.push_back({true, {i}, numbersOf(start)});
  }
  const auto connect = [&](int a, int b) {
    const Pose relative = truth[std::size_t(a)].inverse() * truth[std::size_t(b)];
    parts.push_back({false, {a, b}, numbersOf(perturb(relative, noise))});
  };
  for (int i = 1; i < count; ++i) connect(i - 1, i);
  for (int i = 21; i < count; i += 3) connect(i - 21, i);
  return parts;
}

TestGraph assemble(const std::vector<PoseGraphPart>& parts) {
  TestGraph g;
  for (const PoseGraphPart& part : parts) {
    if (part.is_vertex) g.vertex("VERTEX_SE3:QUAT", part.ids[0], part.numbers);
  }
  for (const PoseGraphPart& part : parts) {
    if (!part.is_vertex) g.edge("TEST_BETWEEN3", part.ids, part.numbers);
  }
  return g;
}

}  // namespace testing
}  // namespace graft
