// SPDX-License-Identifier: BSD-3-Clause
// What innovations predict of taking edges out and in, against solving without and with.
#include "core/solve/innovations.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "apps/graft/simulated_world.hpp"
#include "core/graph/factor_graph.hpp"
#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"

namespace graft {
namespace {

/// Poses in a row with noisy closures; small errors, so that first order is nearly exact.
class InnovationsTest : public ::testing::Test {
 protected:
  static constexpr int kCount = 20;

  InnovationsTest() : graph_(engine_.registry()) {
    NormalDeviates noise(3);
    for (int i = 0; i < kCount; ++i) graph_.addVertex("VERTEX_SE2", i, {double(i), 0, 0});
    const std::vector<double> upper = {1e6, 0, 0, 1e6, 0, 1e6};
    for (const int step : {1, 4, 9}) {
      for (int i = 0; i + step < kCount; i += step == 1 ? 1 : 3) {
        graph_.addEdge("EDGE_SE2", {i, i + step},
                       {step + 1e-3 * noise.next(), 1e-3 * noise.next(), 1e-3 * noise.next()},
                       upper);
      }
    }
  }

  /// F at the minimum with the weights that the problem has.
  double minimum(State& state) {
    rounds_->run(WeightedRounds::Effort::kExact, state);
    return tools_->linearizer.evaluate(state).chi2;
  }

  void begin() {
    options_.graduation.kind = RobustEstimation::kTruncatedLeastSquares;
    problem_ = std::make_unique<Problem>(graph_.graph(), InformationPolicy::kError);
    linearizer_ = std::make_unique<Linearizer>(*problem_, pool_);
    edges_ = std::make_unique<RobustEdges>(*problem_, options_.graduation, report_);
    solver_ = LinearSolver::create("block", engine_.registry(), pool_);
    tools_.reset(new GraduationTools{*linearizer_, *solver_, memory_, pool_, seconds_,
                                     [] { return false; }});
    rounds_ = std::make_unique<WeightedRounds>(*edges_, options_, *tools_, report_);
    linearizer_->begin(graph_.values(), state_);
    edges_->trustOnly();
    edges_->setWeight(edges_->candidates(), 1);
  }

  Engine engine_;
  FactorGraph graph_;
  ThreadPool pool_{1};
  SolveOptions options_;
  GraduationReport report_;
  PatternMemory memory_;
  std::map<std::string, double> seconds_;
  State state_;
  std::unique_ptr<Problem> problem_;
  std::unique_ptr<Linearizer> linearizer_;
  std::unique_ptr<RobustEdges> edges_;
  std::unique_ptr<LinearSolver> solver_;
  std::unique_ptr<GraduationTools> tools_;
  std::unique_ptr<WeightedRounds> rounds_;
};

TEST_F(InnovationsTest, RemovalsTellWhatChi2FallsBy) {
  begin();
  const double all = minimum(state_);
  Innovations innovations(*problem_, pool_);
  ASSERT_TRUE(innovations.begin(*tools_, state_));
  const std::vector<RobustEdges::Place>& candidates = edges_->candidates();
  ASSERT_EQ(candidates.size(), 10U);
  const std::vector<Innovations::Removal> removals = innovations.removals(candidates);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    edges_->setWeight(candidates, 1);
    edges_->setWeight({candidates[i]}, 0);
    State without = state_;
    EXPECT_NEAR(removals[i].fall, all - minimum(without), 0.02 * removals[i].fall) << i;
    EXPECT_GT(removals[i].checked, 0);
    EXPECT_LT(removals[i].checked, 1);
  }
}

TEST_F(InnovationsTest, SamplesTellWhatChi2RisesBy) {
  begin();
  const std::vector<RobustEdges::Place> candidates = edges_->candidates();
  std::vector<double> sampled;
  std::vector<double> true_rises;
  for (const RobustEdges::Place& p : candidates) {
    edges_->setWeight(candidates, 1);
    edges_->setWeight({p}, 0);
    const double without = minimum(state_);
    Innovations innovations(*problem_, pool_);
    ASSERT_TRUE(innovations.begin(*tools_, state_));
    const std::vector<Innovations::View> views = innovations.sample({p});
    sampled.push_back(views[0].square);
    EXPECT_GT(views[0].spread, 0);
    edges_->setWeight({p}, 1);
    true_rises.push_back(minimum(state_) - without);
  }
  double ratio = 0;
  for (std::size_t i = 0; i < sampled.size(); ++i) {
    EXPECT_GT(sampled[i], 0.4 * true_rises[i]) << i;
    EXPECT_LT(sampled[i], 2.5 * true_rises[i]) << i;
    ratio += sampled[i] / true_rises[i] / double(sampled.size());
  }
  EXPECT_NEAR(ratio, 1, 0.3);
}

TEST_F(InnovationsTest, SpreadIsThatOfOdometry) {
  begin();
  edges_->trustOnly();
  minimum(state_);
  Innovations innovations(*problem_, pool_);
  ASSERT_TRUE(innovations.begin(*tools_, state_));
  const std::vector<Innovations::View> views = innovations.sample(edges_->candidates());
  // Along the way n equal steps have n times the variance of one, and a closure's comes to
  // that; aside and in the angle there is more. So the mean of the logarithms is more.
  for (std::size_t i = 0; i < views.size(); ++i) {
    const RobustEdges::Place p = edges_->candidates()[i];
    const VertexRef* v = &problem_->groups()[p.first].vertices[2 * p.second];
    const auto steps = double(graph_.graph().id(v[1]) - graph_.graph().id(v[0]));
    EXPECT_GT(views[i].spread, std::log(1 + steps) * 0.8) << i;
    EXPECT_LT(views[i].spread, std::log(1 + steps * steps * steps)) << i;
  }
}

TEST_F(InnovationsTest, SayWhereTheEdgesInUseLeaveVerticesOpen) {
  graph_.addVertex("VERTEX_SE2", 100, {0, 0, 0});
  graph_.addEdge("EDGE_SE2", {3, 100}, {1, 0, 0}, {1, 0, 0, 1, 0, 1});
  begin();
  edges_->trustOnly();
  Innovations innovations(*problem_, pool_);
  EXPECT_FALSE(innovations.begin(*tools_, state_));
}

}  // namespace
}  // namespace graft
