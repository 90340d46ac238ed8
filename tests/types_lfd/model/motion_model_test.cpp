// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/model/motion_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "tests/support/derivatives.hpp"
#include "tests/types_lfd/model/synthetic_motion.hpp"
#include "types_lfd/model/model_file.hpp"

namespace graft::lfd {
namespace {

using testing::SyntheticTask;

constexpr double kPi = 3.14159265358979323846;

Vec<double, 3> about(double x, double y, double z) { return {x, y, z}; }

TEST(SegmentChart, DecodeInvertsEncode) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 50; ++i) {
    const auto turn = [&] { return about(normal(random), normal(random), normal(random)); };
    SegmentChart chart{0, expSO3<double>(turn())};
    const Pose object(turn(), expSO3<double>(0.3 * turn()));
    const Pose gripper(turn(), expSO3<double>(turn()));
    const Pose2 base(normal(random), normal(random), normal(random));
    const MotionState state = chart.encode(gripper, base, object);
    EXPECT_LT(poseError(gripper.inverse() * chart.decodeGripper(state, object)).norm(), 1e-13);
    EXPECT_LT(poseError(base.inverse() * chart.decodeBase(state, object)).norm(), 1e-13);
  }
}

TEST(SegmentChart, MeanRotationHasNoResidualAndIgnoresSigns) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal(0, 0.4);
  const Eigen::Quaterniond center = expSO3<double>(about(2, 1, -1));
  std::vector<Eigen::Quaterniond> rotations;
  for (int i = 0; i < 30; ++i) {
    rotations.push_back(center *
                        expSO3<double>(about(normal(random), normal(random), normal(random))));
  }
  const Eigen::Quaterniond mean = meanRotation(rotations);
  Vec<double, 3> residual = Vec<double, 3>::Zero();
  for (const auto& q : rotations) residual += logSO3(Eigen::Quaterniond(mean.conjugate() * q));
  EXPECT_LT(residual.norm(), 1e-12);
  for (std::size_t i = 0; i < rotations.size(); i += 2) {
    rotations[i].coeffs() = -rotations[i].coeffs();
  }
  EXPECT_EQ(meanRotation(rotations).coeffs(), mean.coeffs());
}

TEST(SegmentChart, HeadingFollowsTheMostLevelAxis) {
  // z forward, y down: a camera's axes. x is level, so it gives the heading.
  const Eigen::Quaterniond camera =
      expSO3<double>(about(0, 0, -kPi / 2)) * expSO3<double>(about(-kPi / 2, 0, 0));
  EXPECT_EQ(mostLevelAxis({Pose(about(0, 0, 0), camera)}), 0);
  // x up: y gives it.
  const Eigen::Quaterniond up = expSO3<double>(about(0, -kPi / 2, 0));
  EXPECT_EQ(mostLevelAxis({Pose(about(0, 0, 0), up)}), 1);
  EXPECT_THROW(headingFrame(Pose(about(0, 0, 0), up), 0), Error);
  // Turning the object about the vertical turns the frame as much.
  const Pose object(about(1, 2, 3), expSO3<double>(about(0.2, 0.4, 0.3)));
  const Pose turn(about(0, 0, 0), expSO3<double>(about(0, 0, 1.1)));
  const double before = headingFrame(object, 0).theta;
  EXPECT_NEAR(wrapAngle(headingFrame(turn * object, 0).theta - before), 1.1, 1e-14);
}

TEST(SegmentChart, CovarianceIsThatOfThePoses) {
  const SegmentChart chart{0, expSO3<double>(about(0.1, 0.7, -0.4))};
  const Pose object(about(1, 2, 0.5), expSO3<double>(about(0.2, -0.1, 0.9)));
  MotionState state;
  state << 0.1, -0.3, 0.2, 0.8, -0.5, 0.3, -0.7, 0.2, 0.4;
  const Pose gripper = chart.decodeGripper(state, object);
  const Pose2 base = chart.decodeBase(state, object);
  const Eigen::MatrixXd jacobian = graft::testing::riddersJacobian(
      [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
        const MotionState near = state + d;
        const Pose g = chart.decodeGripper(near, object);
        const Pose2 b = chart.decodeBase(near, object);
        Eigen::VectorXd e(9);
        e << g.translation - gripper.translation,
            logSO3(Eigen::Quaterniond(gripper.rotation.conjugate() * g.rotation)), b.x - base.x,
            b.y - base.y, b.theta - base.theta;
        return e;
      },
      9);
  Mat<double, 9> covariance = Mat<double, 9>::Random();
  covariance = (covariance * covariance.transpose()).eval();
  const Eigen::MatrixXd expected = jacobian * covariance * jacobian.transpose();
  EXPECT_LT((chart.decodeCovariance(state, covariance, object) - expected).norm(), 1e-7);
}

TEST(FitSegment, FollowsTheDemonstrations) {
  SyntheticTask task;
  const auto demonstrations = task.demonstrations(0);
  FitReport report;
  const SegmentModel model = fitSegment("reach", demonstrations, FitOptions(), &report);
  EXPECT_EQ(model.demonstrations, 5);
  EXPECT_NEAR(model.duration, (3 + 3.5 + 4 + 3 + 3.5) / 5, 1e-12);
  EXPECT_EQ(model.selection.size(), 15U);
  // Demonstrations differ by a bend of about 3 cm; the mean stays within that.
  for (const auto& d : demonstrations) {
    const double first = d.samples.front().time;
    const double span = d.samples.back().time - first;
    for (const MotionSample& s : d.samples) {
      const Eigen::VectorXd mean = model.mixture.atTime((s.time - first) / span).mean;
      const MotionState truth = model.chart.encode(s.gripper, s.base, d.world_T_object);
      EXPECT_LT((mean - truth).cwiseAbs().maxCoeff(), 0.08);
    }
  }
  const Pose grasp = model.chart.decodeGripper(model.end, Pose());
  EXPECT_LT(poseError(SyntheticTask::objectTGripper().inverse() * grasp).norm(), 1e-12);
}

TEST(FitSegment, SignsOfQuaternionsChangeNothing) {
  SyntheticTask task;
  auto demonstrations = task.demonstrations(1);
  const MotionModel a{"t", {fitSegment("manipulate", demonstrations, FitOptions())}};
  for (auto& d : demonstrations) {
    d.world_T_object.rotation.coeffs() = -d.world_T_object.rotation.coeffs();
    for (std::size_t i = 0; i < d.samples.size(); i += 3) {
      d.samples[i].gripper.rotation.coeffs() = -d.samples[i].gripper.rotation.coeffs();
    }
  }
  const MotionModel b{"t", {fitSegment("manipulate", demonstrations, FitOptions())}};
  EXPECT_EQ(formatModel(a), formatModel(b));
}

TEST(FitSegment, WholeTurnsOfTheBaseAreUnwrapped) {
  // The base turns by 400 degrees, the gripper by 300; the demonstrations start
  // on both sides of the cut at 180 degrees.
  std::vector<SegmentDemonstration> demonstrations;
  for (const double start : {kPi - 0.05, kPi + 0.05, kPi - 0.02}) {
    SegmentDemonstration d;
    for (int i = 0; i <= 100; ++i) {
      const double s = i / 100.0;
      MotionSample sample;
      sample.time = s;
      sample.base = Pose2(0, 0, wrapAngle(start + s * 400 * kPi / 180));
      sample.gripper.rotation = expSO3<double>(about(0, 0, start + s * 300 * kPi / 180));
      d.samples.push_back(sample);
    }
    demonstrations.push_back(d);
  }
  FitReport report;
  const SegmentModel model = fitSegment("turn", demonstrations, FitOptions(), &report);
  EXPECT_NEAR(model.end[8] - model.start[8], 400 * kPi / 180, 1e-9);
  EXPECT_NEAR((model.end - model.start).segment<3>(3).norm(), 300 * kPi / 180, 1e-9);
  double previous = model.mixture.atTime(0).mean[8];
  for (int i = 1; i <= 1000; ++i) {
    const Eigen::VectorXd mean = model.mixture.atTime(i / 1000.0).mean;
    EXPECT_NEAR(mean[8] - previous, 0.001 * 400 * kPi / 180, 0.003);
    previous = mean[8];
  }
  ASSERT_FALSE(report.notes.empty());
  EXPECT_NE(report.notes[0].find("gripper orientations spread"), std::string::npos);
}

TEST(FitSegment, MovingAWholeDemonstrationChangesNothing) {
  SyntheticTask task;
  auto demonstrations = task.demonstrations(0);
  const SegmentModel a = fitSegment("reach", demonstrations, FitOptions());
  const Pose move(about(3, -4, 0), expSO3<double>(about(0, 0, 2.1)));
  for (MotionSample& s : demonstrations[2].samples) {
    s.gripper = move * s.gripper;
    s.base = Pose2(3, -4, 2.1) * s.base;
    s.base.renormalize();
  }
  demonstrations[2].world_T_object = move * demonstrations[2].world_T_object;
  const SegmentModel b = fitSegment("reach", demonstrations, FitOptions());
  ASSERT_EQ(a.mixture.components.size(), b.mixture.components.size());
  EXPECT_LT((a.start - b.start).norm() + (a.end - b.end).norm(), 1e-12);
  for (const double t : {0.0, 0.3, 1.0}) {
    EXPECT_LT((a.mixture.atTime(t).mean - b.mixture.atTime(t).mean).norm(), 1e-9);
  }
}

TEST(FitSegment, BadDemonstrationsAreNamed) {
  SyntheticTask task;
  const auto good = task.demonstrations(0);
  const auto messageOf = [](const std::vector<SegmentDemonstration>& d) -> std::string {
    try {
      fitSegment("reach", d, FitOptions());
    } catch (const Error& e) {
      return std::to_string(static_cast<int>(e.code())) + " " + e.what();
    }
    return "accepted";
  };
  auto late = good;
  late[1].samples[5].time = late[1].samples[4].time;
  EXPECT_EQ(messageOf(late),
            "3 segment 'reach', demonstration 2: the time of sample 6 does not rise");
  auto hole = good;
  hole[0].samples[2].base.x = std::nan("");
  EXPECT_EQ(messageOf(hole), "3 segment 'reach', demonstration 1: sample 3 is not finite");
  EXPECT_EQ(messageOf({}), "4 segment 'reach': no demonstration with at least two samples");

  auto brief = good;
  brief[3].samples.resize(1);
  FitReport report;
  EXPECT_EQ(fitSegment("reach", brief, FitOptions(), &report).demonstrations, 4);
  EXPECT_EQ(report.notes.at(0), "demonstration 4 left out: fewer than two samples");

  // A person who stands still is no reason to fail.
  auto still = good;
  for (auto& d : still) {
    for (auto& s : d.samples) {
      s.gripper = d.world_T_object;
      s.base = headingFrame(d.world_T_object, 0);
    }
  }
  const SegmentModel model = fitSegment("still", still, FitOptions());
  EXPECT_LT(model.mixture.atTime(0.4).mean.norm(), 1e-9);
}

}  // namespace
}  // namespace graft::lfd
