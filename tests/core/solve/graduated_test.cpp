// SPDX-License-Identifier: BSD-3-Clause
// False loop closures are switched off, and what remains is the optimum without them.
#include "core/solve/graduated.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <random>
#include <set>

#include "apps/graft/simulated_world.hpp"
#include "core/base/error.hpp"
#include "core/graph/factor_graph.hpp"
#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"

namespace graft {
namespace {

constexpr double kSigmaT = 0.05;
constexpr double kSigmaR = 0.02;

/// An edge of a test graph, before it is in one.
struct Measured {
  std::int64_t from;
  std::int64_t to;
  std::vector<double> numbers;
  bool is_false;
};

template <class P>
struct Tags;
template <>
struct Tags<Pose2> {
  static constexpr auto vertex = "VERTEX_SE2";
  static constexpr auto edge = "EDGE_SE2";
  static constexpr double chart = 1;  ///< radians per unit of the error's rotation
};
template <>
struct Tags<Pose> {
  static constexpr auto vertex = "VERTEX_SE3:QUAT";
  static constexpr auto edge = "EDGE_SE3:QUAT";
  static constexpr double chart = 2;
};

template <class P>
std::vector<double> numbersOf(const P& pose) {
  std::vector<double> numbers(P::kAmbientDim);
  pose.toArray(numbers.data());
  return numbers;
}

Pose2 wildPose(const Pose2&, std::mt19937_64& random) {
  std::uniform_real_distribution<double> u(-1, 1);
  return {10 * u(random), 10 * u(random), 3.1 * u(random)};
}
Pose wildPose(const Pose&, std::mt19937_64& random) {
  std::uniform_real_distribution<double> u(-1, 1);
  Eigen::Quaterniond q(u(random), u(random), u(random), u(random));
  return Pose(Vec<double, 3>(10 * u(random), 10 * u(random), 10 * u(random)), q.normalized());
}

/// A simulated robot's graph whose loop closures are false to a given share.
template <class P>
class World {
 public:
  /// `clusters`: runs of kRun false closures each that agree on one wrong place.
  World(const std::vector<P>& truth, const SimulatedWorld& world, double share, std::uint64_t seed,
        int clusters = 0)
      : truth_(truth) {
    NormalDeviates deviates(seed);
    std::mt19937_64 random(seed + 1000);
    std::size_t closures = 0;
    estimates_.push_back(truth[0]);
    for (const auto& [a, b] : world.edges) {
      const P z = noisy(truth[std::size_t(a)].inverse() * truth[std::size_t(b)], deviates);
      if (b == a + 1) {
        estimates_.push_back(estimates_.back() * z);
      } else {
        ++closures;
      }
      edges_.push_back({a, b, numbersOf(z), false});
    }
    true_closures_ = closures;
    false_closures_ = std::size_t(std::lround(double(closures) * share / (1 - share)));
    std::uniform_int_distribution<std::int64_t> any(0, std::int64_t(truth.size()) - 1);
    for (std::size_t i = 0; i < false_closures_;) {
      const std::int64_t a = any(random);
      const std::int64_t b = any(random);
      if (std::abs(a - b) < 5) continue;
      edges_.push_back({a, b, numbersOf(wildPose(P(), random)), true});
      ++i;
    }
    for (int i = 0; i < clusters; ++i) addCluster(random, deviates);
    std::shuffle(edges_.begin(), edges_.end(), random);
  }

  /// The graph with those edges that `wanted` says; line of an edge = its place + 1.
  template <class Wanted>
  FactorGraph build(Engine& engine, const Wanted& wanted) const {
    FactorGraph g(engine.registry());
    std::vector<double> upper;
    for (int r = 0; r < P::kTangentDim; ++r) {
      for (int c = r; c < P::kTangentDim; ++c) {
        const double sigma = r < kTranslations ? kSigmaT : kSigmaR / Tags<P>::chart;
        upper.push_back(r == c ? 1 / (sigma * sigma) : 0);
      }
    }
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      g.addVertex(Tags<P>::vertex, std::int64_t(i), numbersOf(estimates_[i]));
    }
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      if (!wanted(e)) continue;
      Graph::EdgeSpec spec;
      spec.type = engine.registry().edge(Tags<P>::edge);
      spec.vertices = {g.graph().find(edges_[e].from), g.graph().find(edges_[e].to)};
      spec.measurement = edges_[e].numbers;
      spec.information = upper;
      spec.line = std::int64_t(e) + 1;
      g.graph().addEdge(spec);
    }
    return g;
  }
  FactorGraph everything(Engine& engine) const {
    return build(engine, [](std::size_t) { return true; });
  }
  /// The optimum of a graph by plain least squares from the truth.
  template <class Wanted>
  Values optimum(Engine& engine, const Wanted& wanted) const {
    FactorGraph g = build(engine, wanted);
    // The first pose is held, so both optima lie in the same frame.
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      g.setEstimate(std::int64_t(i), numbersOf(truth_[i]));
    }
    SolveOptions options;
    options.initial_guess = InitialGuess::kFile;
    options.function_tolerance = 1e-14;
    EXPECT_EQ(optimize(g.graph(), g.values(), engine.registry(), options).status,
              Status::kConverged);
    return g.values();
  }
  double largestDifference(const Values& a, const Values& b) const {
    double largest = 0;
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      const VertexRef v{0, std::int32_t(i)};
      const auto difference = P::fromArray(b.at(v)).inverse() * P::fromArray(a.at(v));
      const std::vector<double> numbers = numbersOf(difference);
      // The rotation's scalar part, the last of seven numbers, is 1 or -1 where both agree.
      const std::size_t count = numbers.size() == 7 ? 6 : 3;
      for (std::size_t k = 0; k < count; ++k) largest = std::max(largest, std::abs(numbers[k]));
    }
    return largest;
  }
  bool isFalse(std::size_t e) const { return edges_[e].is_false; }
  std::size_t trueClosures() const { return true_closures_; }
  std::size_t falseClosures() const { return false_closures_; }

 private:
  static constexpr int kTranslations = P::kTangentDim == 6 ? 3 : 2;
  static constexpr std::int64_t kRun = 10;

  static P noisy(const P& exact, NormalDeviates& deviates) {
    Vec<double, P::kTangentDim> noise;
    for (int k = 0; k < P::kTangentDim; ++k) {
      noise[k] = deviates.next() * (k < kTranslations ? kSigmaT : kSigmaR);
    }
    P z = exact.plus(noise);
    z.renormalize();
    return z;
  }
  /// What would be measured if the run that begins at one pose lay beside that at another.
  void addCluster(std::mt19937_64& random, NormalDeviates& deviates) {
    std::uniform_int_distribution<std::int64_t> any(0, std::int64_t(truth_.size()) - kRun);
    std::int64_t a = 0;
    std::int64_t b = 0;
    while (std::abs(a - b) < 3 * kRun) {
      a = any(random);
      b = any(random);
    }
    const P wrong = wildPose(P(), random);
    for (std::int64_t i = 0; i < kRun; ++i) {
      const auto seen = [&](std::int64_t from) {
        return truth_[std::size_t(from)].inverse() * truth_[std::size_t(from + i)];
      };
      const P z = noisy(seen(a).inverse() * wrong * seen(b), deviates);
      edges_.push_back({a + i, b + i, numbersOf(z), true});
    }
    false_closures_ += std::size_t(kRun);
  }

  std::vector<P> truth_;
  std::vector<P> estimates_;
  std::vector<Measured> edges_;
  std::size_t true_closures_ = 0;
  std::size_t false_closures_ = 0;
};

World<Pose2> planeWorld(double share, std::uint64_t seed, int clusters = 0) {
  NormalDeviates random(seed);
  const SimulatedWorld world = manhattanWorld(300, random);
  return World<Pose2>(world.plane, world, share, seed, clusters);
}
World<Pose> spaceWorld(double share, std::uint64_t seed, int clusters = 0) {
  const SimulatedWorld world = sphereWorld(11);
  return World<Pose>(world.space, world, share, seed, clusters);
}

SolveOptions graduatedOptions(RobustEstimation kind, double probability = 0.99) {
  SolveOptions options;
  options.graduation.kind = kind;
  options.graduation.inlier_probability = probability;
  options.function_tolerance = 1e-14;
  options.threads = 1;
  return options;
}

std::set<std::size_t> switchedOff(const Summary& summary) {
  std::set<std::size_t> off;
  for (const SwitchedOff& one : summary.graduation.off) off.insert(std::size_t(one.line) - 1);
  return off;
}

class GraduatedTest : public ::testing::TestWithParam<RobustEstimation> {
 protected:
  template <class P>
  void check(const World<P>& world, double probability) {
    FactorGraph g = world.everything(engine_);
    const SolveOptions options = graduatedOptions(GetParam(), probability);
    const Summary summary = optimize(g.graph(), g.values(), engine_.registry(), options);
    ASSERT_EQ(summary.status, Status::kConverged) << summary.reason;
    const std::set<std::size_t> off = switchedOff(summary);
    std::size_t false_off = 0;
    for (const std::size_t e : off) false_off += world.isFalse(e) ? 1 : 0;
    EXPECT_EQ(false_off, world.falseClosures());
    const std::size_t true_off = off.size() - false_off;
    EXPECT_EQ(std::size_t(summary.graduation.candidates),
              world.trueClosures() + world.falseClosures());
    // Plain least squares over what was kept has the same optimum.
    const auto kept = [&off](std::size_t e) { return off.count(e) == 0; };
    EXPECT_LT(world.largestDifference(g.values(), world.optimum(engine_, kept)), 1e-6);
    for (const SwitchedOff& one : summary.graduation.off) {
      EXPECT_GT(one.square, one.threshold);
      EXPECT_EQ(one.weight, 0);
    }
    if (probability < 0.999) {
      // Of the true ones about one per cent; three standard deviations more are allowed.
      const double expected = (1 - probability) * double(world.trueClosures());
      EXPECT_LE(double(true_off), expected + 3 * std::sqrt(expected));
    } else {
      EXPECT_EQ(true_off, 0u);
      const auto clean = [&world](std::size_t e) { return !world.isFalse(e); };
      EXPECT_LT(world.largestDifference(g.values(), world.optimum(engine_, clean)), 1e-6);
    }
  }

  Engine engine_;
};

TEST_P(GraduatedTest, FindsTheOptimumWithoutFalseClosuresInThePlane) {
  for (const std::uint64_t seed : {1, 2, 3}) check(planeWorld(0.3, seed), 0.999999);
}

TEST_P(GraduatedTest, FindsTheOptimumWithoutFalseClosuresInSpace) {
  for (const std::uint64_t seed : {1, 2, 3}) check(spaceWorld(0.3, seed), 0.999999);
}

TEST_P(GraduatedTest, LosesFewTrueClosures) {
  for (const std::uint64_t seed : {4, 5, 6}) {
    check(planeWorld(0.3, seed), 0.99);
    check(spaceWorld(0.3, seed), 0.99);
  }
}

TEST_P(GraduatedTest, LeavesACleanGraphAlone) {
  check(spaceWorld(0, 7), 0.999999);
  check(planeWorld(0, 7), 0.999999);
}

TEST_P(GraduatedTest, SwitchesNoMoreOffInACleanGraphThanItsLevelSays) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    check(planeWorld(0, seed), 0.99);
    check(spaceWorld(0, seed), 0.99);
  }
}

TEST_P(GraduatedTest, IsNotMisledByFalseClosuresThatAgreeOnAWrongPlace) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    check(planeWorld(0, seed, 2), 0.999999);
    check(spaceWorld(0.1, seed, 3), 0.999999);
  }
}

TEST_P(GraduatedTest, GivesTheSameBitsForAnyThreadsAndOrder) {
  const World<Pose> world = spaceWorld(0.3, 8);
  const auto run = [&](int threads, std::uint64_t seed) {
    FactorGraph g = world.everything(engine_);
    FactorGraph shuffled(engine_.registry());
    const EdgeBlock& block = g.graph().edgeBlocks().front();
    std::vector<std::size_t> order(block.size());
    for (std::size_t e = 0; e < order.size(); ++e) order[e] = e;
    std::mt19937_64 random(seed);
    if (seed > 0) std::shuffle(order.begin(), order.end(), random);
    for (const VertexRef v : g.graph().verticesById()) {
      const std::int64_t id = g.graph().id(v);
      shuffled.addVertex("VERTEX_SE3:QUAT", id, g.estimate(id));
    }
    for (const std::size_t e : order) {
      const std::vector<double> z(block.measurements.begin() + block.measurement_begin[e],
                                  block.measurements.begin() + block.measurement_begin[e + 1]);
      const std::vector<double> upper(block.information.begin() + block.information_begin[e],
                                      block.information.begin() + block.information_begin[e + 1]);
      const VertexRef* v = &block.vertices[std::size_t(block.vertex_begin[e])];
      shuffled.addEdge("EDGE_SE3:QUAT", {g.graph().id(v[0]), g.graph().id(v[1])}, z, upper);
    }
    SolveOptions options = graduatedOptions(GetParam());
    options.threads = threads;
    const Summary summary =
        optimize(shuffled.graph(), shuffled.values(), engine_.registry(), options);
    return std::make_tuple(shuffled.values().array(0), summary.chi2_final,
                           summary.graduation.off.size(), summary.graduation.iterations);
  };
  const auto reference = run(1, 0);
  EXPECT_TRUE(run(2, 1) == reference);
  EXPECT_TRUE(run(4, 2) == reference);
}

INSTANTIATE_TEST_SUITE_P(, GraduatedTest,
                         ::testing::Values(RobustEstimation::kTruncatedLeastSquares,
                                           RobustEstimation::kGemanMcClure),
                         [](const auto& info) {
                           return info.param == RobustEstimation::kGemanMcClure
                                      ? std::string("GemanMcClure")
                                      : std::string("TruncatedLeastSquares");
                         });

/// Four poses in a row; three closures say that the last is 3 m ahead, one 3 m aside.
class GraduationTrust : public ::testing::Test {
 protected:
  GraduationTrust() : graph_(engine_.registry()) {
    for (const int id : {0, 10, 20, 30}) graph_.addVertex("VERTEX_SE2", id, {id * 0.1, 0, 0});
    for (const int id : {0, 10, 20}) add(id, id + 10, 1, 0);
    add(0, 30, 3, 0.1);
    add(0, 30, 3, -0.1);
    add(0, 30, 0, 3);
    add(0, 20, 0, -7);
  }
  void add(std::int64_t a, std::int64_t b, double x, double y) {
    graph_.addEdge("EDGE_SE2", {a, b}, {x, y, 0}, {100, 0, 0, 100, 0, 100});
  }
  Summary solve(const Graduation& graduation) {
    SolveOptions options = graduatedOptions(RobustEstimation::kTruncatedLeastSquares);
    options.graduation = graduation;
    options.graduation.kind = RobustEstimation::kTruncatedLeastSquares;
    return optimize(graph_.graph(), graph_.values(), engine_.registry(), options);
  }

  Engine engine_;
  FactorGraph graph_;
};

TEST_F(GraduationTrust, ConsecutiveVerticesAreThoseThatFollowEachOther) {
  const Summary summary = solve({});
  EXPECT_EQ(summary.graduation.candidates, 4);
  ASSERT_EQ(summary.graduation.off.size(), 2u);
  EXPECT_EQ(summary.graduation.off[0].tag, "EDGE_SE2");
  EXPECT_EQ(summary.graduation.off[0].ids, (std::vector<std::int64_t>{0, 20}));
  EXPECT_EQ(summary.graduation.off[1].ids, (std::vector<std::int64_t>{0, 30}));
  EXPECT_NEAR(summary.graduation.off[1].threshold, 11.344866730144373, 1e-9);
  // e' Omega e of a measurement 3 m beside where the pose is.
  EXPECT_NEAR(summary.graduation.off[1].square, 100 * 18, 1);
  EXPECT_NEAR(graph_.estimate(30)[0], 3, 1e-9);
}

TEST_F(GraduationTrust, OptionsSayWhatIsTrusted) {
  Graduation none;
  none.trust_consecutive = false;
  EXPECT_EQ(solve(none).graduation.candidates, 7);
  Graduation tag = none;
  tag.trusted_tags = {"EDGE_SE2"};
  const Summary all_trusted = solve(tag);
  EXPECT_EQ(all_trusted.graduation.candidates, 0);
  EXPECT_TRUE(all_trusted.graduation.off.empty());
  EXPECT_GT(all_trusted.chi2_final, 100);
  tag.trusted_tags = {"EDGE_SE3"};
  EXPECT_THROW(solve(tag), Error);
}

TEST_F(GraduationTrust, EdgesOnOneVertexAreTrusted) {
  graph_.addEdge("EDGE_PRIOR_SE2", {0}, {0, 0, 0}, {1, 0, 0, 1, 0, 1});
  EXPECT_EQ(solve({}).graduation.candidates, 4);
  Graduation none;
  none.trust_consecutive = false;
  EXPECT_EQ(solve(none).graduation.candidates, 8);
}

TEST_F(GraduationTrust, KernelsOfCandidatesAreLeftOut) {
  graph_.setKernel("Huber", 10);
  const Summary summary = solve({});
  EXPECT_EQ(summary.graduation.kernels_left_out, 4);
  EXPECT_EQ(summary.graduation.off.size(), 2u);
}

TEST_F(GraduationTrust, StopsWhenAsked) {
  const std::atomic<int> interrupt(1);
  SolveOptions options = graduatedOptions(RobustEstimation::kTruncatedLeastSquares);
  options.interrupt = &interrupt;
  EXPECT_EQ(optimize(graph_.graph(), graph_.values(), engine_.registry(), options).status,
            Status::kInterrupted);
}

/// Where nothing contradicts, what is left is rounding, which is not normal.
TEST(GraduationNoise, RoundingIsNotTakenForNoise) {
  Engine engine;
  FactorGraph g(engine.registry());
  constexpr int kCount = 40;
  for (int i = 0; i < kCount; ++i) g.addVertex("VERTEX_SE2", i, {i * 0.1, i * 0.3, 0});
  for (int i = 0; i < kCount; ++i) {
    for (const int step : {1, 2, 3, 7}) {
      if (i + step >= kCount) continue;
      g.addEdge("EDGE_SE2", {i, i + step}, {step * 0.1, step * 0.3, 0}, {100, 0, 0, 100, 0, 100});
    }
  }
  for (const RobustEstimation kind :
       {RobustEstimation::kTruncatedLeastSquares, RobustEstimation::kGemanMcClure}) {
    const Summary summary =
        optimize(g.graph(), g.values(), engine.registry(), graduatedOptions(kind));
    EXPECT_TRUE(summary.graduation.off.empty());
    EXPECT_LT(summary.chi2_final, 1e-15);
  }
}

/// Where information claims ten times the deviation that there is, a false closure by a
/// little hides within the thresholds, unless they follow the noise that there is.
TEST(GraduationNoise, ThresholdsFollowTheNoiseThatTheKeptEdgesShow) {
  Engine engine;
  FactorGraph g(engine.registry());
  NormalDeviates noise(5);
  constexpr int kCount = 60;
  for (int i = 0; i < kCount; ++i) g.addVertex("VERTEX_SE2", i, {double(i), 0, 0});
  const std::vector<double> upper = {1, 0, 0, 1, 0, 1};  // 1 m, while noise is 0.1 m
  for (int i = 0; i < kCount; ++i) {
    for (const int step : {1, 2, 3, 7}) {
      if (i + step >= kCount) continue;
      g.addEdge("EDGE_SE2", {i, i + step},
                {step + 0.1 * noise.next(), 0.1 * noise.next(), 0.1 * noise.next()}, upper);
    }
  }
  g.addEdge("EDGE_SE2", {10, 40}, {28, 0, 0}, upper);
  SolveOptions options = graduatedOptions(RobustEstimation::kTruncatedLeastSquares);
  options.graduation.fit_noise = false;
  EXPECT_TRUE(optimize(g.graph(), g.values(), engine.registry(), options).graduation.off.empty());
  options.graduation.fit_noise = true;
  const Summary summary = optimize(g.graph(), g.values(), engine.registry(), options);
  ASSERT_EQ(summary.graduation.off.size(), 1u);
  EXPECT_EQ(summary.graduation.off[0].ids, (std::vector<std::int64_t>{10, 40}));
  EXPECT_NEAR(summary.graduation.noise_factor, 9 * 0.01, 0.02);
}

}  // namespace
}  // namespace graft
