// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <iterator>
#include <random>
#include <sstream>

#include "tests/support/derivatives.hpp"
#include "tests/support/test_data.hpp"
#include "types_lfd/edges/grasp_edges.hpp"
#include "types_lfd/edges/track_edges.hpp"

namespace graft::lfd {
namespace {

/// Calls an edge type across the C ABI with given vertices.
class OneEdge {
 public:
  OneEdge(const graft_edge_type& type, std::vector<const graft_vertex_type*> slots)
      : type_(type), slots_(std::move(slots)) {}

  std::vector<double> measurement;
  std::vector<double> association;

  Eigen::VectorXd error(const std::vector<std::vector<double>>& vertices) const {
    Eigen::VectorXd e(type_.error_dim);
    evaluate(vertices, e.data(), nullptr);
    return e;
  }
  Eigen::MatrixXd jacobian(const std::vector<std::vector<double>>& vertices) const {
    Eigen::VectorXd e(type_.error_dim);
    Eigen::MatrixXd j = Eigen::MatrixXd::Constant(type_.error_dim, tangentDim(), 1e300);
    evaluate(vertices, e.data(), j.data());
    EXPECT_LT((e - error(vertices)).norm(), 1e-14);
    return j;
  }
  Eigen::MatrixXd numericJacobian(const std::vector<std::vector<double>>& vertices) const {
    return testing::riddersJacobian(
        [&](const Eigen::VectorXd& delta) -> Eigen::VectorXd {
          std::vector<std::vector<double>> moved = vertices;
          int offset = 0;
          for (std::size_t k = 0; k < moved.size(); ++k) {
            slots_[k]->plus(1, vertices[k].data(), delta.data() + offset, moved[k].data());
            offset += slots_[k]->tangent_dim;
          }
          return error(moved);
        },
        tangentDim());
  }
  int tangentDim() const {
    int sum = 0;
    for (const auto* slot : slots_) sum += slot->tangent_dim;
    return sum;
  }

 private:
  void evaluate(const std::vector<std::vector<double>>& vertices, double* errors,
                double* jacobians) const {
    std::vector<const double*> pointers;
    for (const auto& v : vertices) pointers.push_back(v.data());
    const double* measured = measurement.data();
    const double* associated = association.data();
    const void* const none[2] = {};
    const void* const* resources = none;
    graft_edge_batch batch = {};
    batch.struct_size = sizeof batch;
    batch.arity = type_.arity;
    batch.error_dim = type_.error_dim;
    batch.measurement_dim = type_.measurement_dim;
    batch.association_dim = type_.association_dim;
    batch.count = 1;
    batch.vertices = pointers.data();
    batch.measurements = &measured;
    batch.associations = &associated;
    batch.resources = &resources;
    graft_message message = {};
    ASSERT_EQ(type_.evaluate(&batch, errors, jacobians, &message), GRAFT_OK) << message.text;
  }

  const graft_edge_type& type_;
  std::vector<const graft_vertex_type*> slots_;
};

class Edges : public ::testing::Test {
 protected:
  std::vector<double> randomPose(double scale, double angle) {
    std::normal_distribution<double> normal;
    const Vec<double, 3> axis =
        Vec<double, 3>(normal(random_), normal(random_), normal(random_)).normalized();
    const Pose pose(scale * Vec<double, 3>(normal(random_), normal(random_), normal(random_)),
                    expSO3<double>(angle * axis));
    std::vector<double> numbers(7);
    pose.toArray(numbers.data());
    return numbers;
  }
  static std::vector<double> turned(const std::vector<double>& pose) {
    std::vector<double> numbers(7);
    flippedGrasp(Pose::fromArray(pose.data())).toArray(numbers.data());
    return numbers;
  }
  std::vector<double> randomBase() {
    std::uniform_real_distribution<double> uniform(-1, 1);
    return {uniform(random_), uniform(random_), uniform(random_)};
  }
  void expectJacobian(const OneEdge& edge, const std::vector<std::vector<double>>& vertices) {
    const Eigen::MatrixXd analytic = edge.jacobian(vertices);
    const Eigen::MatrixXd numeric = edge.numericJacobian(vertices);
    EXPECT_LT((analytic - numeric).lpNorm<Eigen::Infinity>(), 1e-7 * (1 + numeric.norm()));
  }
  std::mt19937_64 random_{11};
  const graft_vertex_type* se3_ = &vertexType<SE3>();
  const graft_vertex_type* base_ = &vertexType<BasePose>();
};

TEST_F(Edges, OfTurnedHandsAreThoseOfTheHandTurnedBack) {
  const std::vector<double> hand = randomPose(1, 0.7);
  const std::vector<double> object = randomPose(1, 0.4);
  const std::vector<double> grasp = randomPose(1, 0.9);
  const OneEdge human(HumanGraspEdge::descriptor(), {se3_, se3_, se3_});
  const OneEdge human_turned(TurnedHumanGraspEdge::descriptor(), {se3_, se3_, se3_});
  EXPECT_LT((human.error({hand, object, grasp}) - human_turned.error({turned(hand), object, grasp}))
                .norm(),
            1e-14);
  // No turn beyond the half one: no error.
  const std::vector<double> half = turned({0, 0, 0, 0, 0, 0, 1});
  const OneEdge resemblance(TurnedResemblanceEdge::descriptor(), {se3_});
  EXPECT_LT(resemblance.error({half}).norm(), 1e-15);
  EXPECT_NEAR(resemblance.error({{0, 0, 0, 0, 0, 0, 1}}).norm(), 3.14159265358979323846, 1e-12);
}

TEST_F(Edges, JacobiansMatchRidders) {
  for (const double angle : {1e-9, 0.3, 1.2}) {
    OneEdge observation(ObservationEdge::descriptor(), {se3_});
    observation.measurement = randomPose(1, angle);
    expectJacobian(observation, {randomPose(1, angle)});
    OneEdge motion(RelativeMotionEdge::descriptor(), {se3_, se3_});
    motion.measurement = randomPose(1, angle);
    expectJacobian(motion, {randomPose(1, angle), randomPose(1, angle)});
    expectJacobian(OneEdge(GripperSmoothEdge::descriptor(), {se3_, se3_}),
                   {randomPose(1, angle), randomPose(1, angle)});
    expectJacobian(OneEdge(HumanGraspEdge::descriptor(), {se3_, se3_, se3_}),
                   {randomPose(1, angle), randomPose(1, angle), randomPose(1, angle)});
    expectJacobian(OneEdge(ResemblanceEdge::descriptor(), {se3_}), {randomPose(1, angle)});
    // These are for turned hands; at a hand that is not, the logarithm has its cut.
    expectJacobian(OneEdge(TurnedHumanGraspEdge::descriptor(), {se3_, se3_, se3_}),
                   {turned(randomPose(1, angle)), randomPose(1, angle), randomPose(1, angle)});
    expectJacobian(OneEdge(TurnedResemblanceEdge::descriptor(), {se3_}),
                   {turned(randomPose(1, angle))});
    OneEdge quality(GraspQualityEdge::descriptor(), {se3_});
    quality.association = randomPose(1, angle);
    quality.association.resize(9);
    expectJacobian(quality, {randomPose(1, angle)});
    expectJacobian(
        OneEdge(GraspAgreementEdge::descriptor(), {se3_, se3_, se3_, se3_}),
        {randomPose(1, angle), randomPose(1, angle), randomPose(1, angle), randomPose(1, angle)});
    OneEdge steady(SteadyMotionEdge::descriptor(), {se3_, se3_, se3_});
    steady.measurement = {0.07, 0.11};
    expectJacobian(steady, {randomPose(1, angle), randomPose(1, angle), randomPose(1, angle)});
    OneEdge prior(BasePriorEdge::descriptor(), {base_});
    prior.measurement = randomBase();
    expectJacobian(prior, {randomBase()});
    expectJacobian(OneEdge(BaseSmoothEdge::descriptor(), {base_, base_}),
                   {randomBase(), randomBase()});
  }
}

TEST_F(Edges, FixedTransformIsZeroExactlyWhereThePaperSaysSo) {
  const Pose object = Pose::fromArray(randomPose(1, 0.8).data());
  const Pose object_T_hand = Pose::fromArray(randomPose(0.2, 1.1).data());
  std::vector<double> hand(7), o(7), rel(7);
  (object * object_T_hand).toArray(hand.data());
  object.toArray(o.data());
  object_T_hand.toArray(rel.data());
  const OneEdge edge(HumanGraspEdge::descriptor(), {se3_, se3_, se3_});
  EXPECT_LT(edge.error({hand, o, rel}).norm(), 1e-14);
  // A hand 1 cm further along its own x axis is 1 cm of error along x.
  (object * object_T_hand * Pose(Vec<double, 3>(0.01, 0, 0), Eigen::Quaterniond::Identity()))
      .toArray(hand.data());
  EXPECT_NEAR(edge.error({hand, o, rel})[0], 0.01, 1e-14);
  EXPECT_NEAR(edge.error({hand, o, rel}).norm(), 0.01, 1e-14);
}

TEST_F(Edges, SteadyMotionIsZeroAtConstantVelocityWithUnevenSteps) {
  OneEdge edge(SteadyMotionEdge::descriptor(), {se3_, se3_, se3_});
  edge.measurement = {0.1, 0.25};
  std::vector<std::vector<double>> track;
  for (const double t : {0.0, 0.1, 0.35}) {
    std::vector<double> numbers(7);
    Pose(Vec<double, 3>(0.3 * t, -t, 2 * t), expSO3<double>(Vec<double, 3>(t, 2 * t, 0)))
        .toArray(numbers.data());
    track.push_back(numbers);
  }
  EXPECT_LT(edge.error(track).norm(), 1e-13);
}

TEST_F(Edges, GraspQualityPicksTheNearestOfAllTurnedBothWays) {
  std::vector<Grasp> grasps;
  for (int i = 0; i < 12; ++i) {
    grasps.push_back({Pose::fromArray(randomPose(0.05, 2.5).data()), 0.9, i});
  }
  const GraspSet set(grasps);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(6, 6);
  information.diagonal() << 1e6, 1e6, 1e6, 1e3, 1e3, 1e3;
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<double> x = randomPose(0.05, 2.5);
    double association[9] = {};
    GraspQualityEdge edge;
    std::get<0>(edge.resources) = &set;
    edge.associate(true, Pose::fromArray(x.data()), InformationBlock(information.data(), 6, 6),
                   association);
    double best = 1e300;
    int best_row = -1;
    for (const Grasp& g : grasps) {
      for (const Pose& candidate : {g.object_T_gripper, flippedGrasp(g.object_T_gripper)}) {
        const Vec<double, 6> e = poseError(Pose::fromArray(x.data()).inverse() * candidate);
        const double cost = e.dot(information * e);
        if (cost < best) {
          best = cost;
          best_row = g.row;
        }
      }
    }
    EXPECT_EQ(association[7], best_row);
  }
}

TEST_F(Edges, GraspQualityChoosesAmongCandidatesOnly) {
  std::vector<Grasp> grasps;
  for (int i = 0; i < 12; ++i) {
    grasps.push_back({Pose::fromArray(randomPose(0.05, 0.1).data()), 0.9, i});
  }
  GraspSet set(grasps);
  set.keepLike(grasps[3].object_T_gripper, 1e-3, 1);  // nothing else within 5 mm
  ASSERT_EQ(set.candidates().size(), 1u);
  const Eigen::MatrixXd information = Eigen::MatrixXd::Identity(6, 6);
  GraspQualityEdge edge;
  std::get<0>(edge.resources) = &set;
  double association[9] = {};
  for (const Grasp& g : grasps) {
    edge.associate(true, g.object_T_gripper, InformationBlock(information.data(), 6, 6),
                   association);
    EXPECT_EQ(association[7], 3);
    EXPECT_EQ(association[8], 0);
  }
  double other[9] = {};
  EXPECT_TRUE(edge.alternative(0, other));
  EXPECT_EQ(other[7], 3);
  EXPECT_FALSE(edge.alternative(1, other));
}

TEST(GraspSetResource, TakesAPersonsGrasp) {
  const std::string folder = testing::makeTemporaryDirectory();
  testing::writeTestFile(folder, "g.csv",
                         "x,y,z,qx,qy,qz,qw,quality\n0,0,0,0,0,0,1,1\n1,0,0,0,0,0,1,1\n");
  const auto load = [&](const std::string& text) {
    std::istringstream stream(text);
    const std::vector<std::string> tokens{std::istream_iterator<std::string>(stream), {}};
    return ResourceTag<GraspSet>::load(folder, tokens)->candidates().size();
  };
  EXPECT_EQ(load("g.csv 0.5"), 4u);
  EXPECT_EQ(load("g.csv 0.5 0.9 0 0 0 0 0 1 0.01 0.06"), 1u);
  const std::pair<const char*, const char*> bad[] = {
      {"g.csv", "expected a file and a minimum quality, then nothing or a pose and two sigmas"},
      {"g.csv 0.5 0.9 0 0 0 0 0 1 0.01", "expected a file and a minimum quality, then"},
      {"g.csv 0.5 x 0 0 0 0 0 1 0.01 0.06", "'x' is not a number"},
      {"g.csv 0.5 0.9 0 0 0 0 0 2 0.01 0.06", "the grasp's quaternion has length 2"},
      {"g.csv 0.5 0.9 0 0 0 0 0 0 0.01 0.06", "the grasp's quaternion has length 0"},
      {"g.csv 0.5 0.9 0 0 0 0 0 1 0 0.06", "the sigmas are 0 and 0.06"},
      {"g.csv 0.5 0.9 0 0 0 0 0 1 0.01 -1", "the sigmas are 0.01 and -1"}};
  for (const auto& [text, message] : bad) {
    try {
      load(text);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos)
          << text << ": " << error.what();
    }
  }
}

}  // namespace
}  // namespace graft::lfd
