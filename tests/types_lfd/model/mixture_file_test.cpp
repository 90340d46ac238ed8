// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/model/mixture_file.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/base/text.hpp"
#include "tests/support/test_data.hpp"

namespace graft::lfd {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

struct Published {
  const char* file;
  std::size_t components;
  const char* object;
};

std::ostream& operator<<(std::ostream& out, const Published& p) { return out << p.file; }

class PublishedMixtures : public ::testing::TestWithParam<Published> {};

TEST_P(PublishedMixtures, RegressIntoSmoothMotions) {
  const std::string name = std::string("motion_models/") + GetParam().file;
  GRAFT_REQUIRE_DATA(name);
  Diagnostics diagnostics;
  const MixtureFile file = readMixtureFile(graft::testing::dataPath(name), diagnostics);
  EXPECT_EQ(file.mixture.components.size(), GetParam().components);
  EXPECT_EQ(file.mixture.dimension(), 15);
  EXPECT_EQ(file.object_name, GetParam().object);
  EXPECT_GE(diagnostics.warningCount(), 1U);  // rounded covariances
  double priors = 0;
  for (const GaussianComponent& c : file.mixture.components) {
    priors += c.weight;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(c.covariance);
    EXPECT_GT(eigen.eigenvalues()[0], -1e-12);
    EXPECT_EQ(c.covariance, c.covariance.transpose());
  }
  EXPECT_NEAR(priors, 1, 1e-12);

  const SegmentModel model = toSegmentModel(file, "published", 30, diagnostics);
  const auto poseAt = [&](double t) {
    return model.chart.decodeGripper(model.mixture.atTime(t).mean, file.model_T_object);
  };
  Pose previous = poseAt(0);
  for (int i = 1; i <= 2000; ++i) {
    const Pose pose = poseAt(i / 2000.0);
    EXPECT_NEAR(pose.rotation.norm(), 1, 1e-14);
    EXPECT_LT(rotationAngle(previous.rotation.conjugate() * pose.rotation), 0.2 * kDegree) << i;
    EXPECT_LT((pose.translation - previous.translation).norm(), 0.0015) << i;
    previous = pose;
  }
  // Ends of the motion: the first and last means of the file.
  for (const double t : {0.0, 1.0}) {
    const auto& all = file.mixture.components;
    const Eigen::VectorXd& mean = t == 0 ? all.front().mean : all.back().mean;
    const Eigen::Quaterniond q(Vec<double, 4>(mean.segment<4>(4)));
    const Pose pose = poseAt(t);
    EXPECT_LT((pose.translation - mean.segment<3>(1)).norm(), 0.004);
    EXPECT_LT(rotationAngle(q.normalized().conjugate() * pose.rotation), 0.6 * kDegree);
    const Pose2 base = model.chart.decodeBase(model.mixture.atTime(t).mean, file.model_T_object);
    EXPECT_LT(std::hypot(base.x - mean[8], base.y - mean[9]), 0.006);
    EXPECT_LT(std::abs(wrapAngle(base.theta - 2 * std::atan2(mean[13], mean[14]))), kDegree);
  }
}

INSTANTIATE_TEST_SUITE_P(MixtureFile, PublishedMixtures,
                         ::testing::Values(Published{"GMM_grasp_KallaxTuer.csv", 10, "Kallax_Tuer"},
                                           Published{"GMM_move_KallaxTuer.csv", 10, "Kallax_Tuer"},
                                           Published{"GMM_grasp_roomDoor.csv", 8, "roomDoor"},
                                           Published{"GMM_move_roomDoor.csv", 8, "roomDoor"},
                                           Published{"GMM_release_roomDoor.csv", 7, "roomDoor"}));

/// A file with two components: gripper and base turn by a right angle about z,
/// and the second quaternion of the gripper has the other sign.
std::string smallFile() {
  const double h = std::sqrt(0.5);
  const double means[15][2] = {{0, 0.8}, {-0.4, 0}, {0.1, 0}, {0, 0},     {0, 0},
                               {0, 0},   {0, -h},   {1, -h},  {-1, -0.7}, {0, 0.1},
                               {0, 0},   {0, 0},    {0, 0},   {0, h},     {1, h}};
  const char* labels[15] = {"t", "x", "y", "z",  "qx", "qy", "qz", "qw",
                            "x", "y", "z", "qx", "qy", "qz", "qw"};
  std::string text = "\"Priors\"\np 0.5 0.5\n  \n\"Mu\"\n";
  for (int i = 0; i < 15; ++i) {
    text += std::string(labels[i]) + " " + formatDouble(means[i][0]) + " " +
            formatDouble(means[i][1]) + "  \n";
  }
  for (int k = 1; k <= 2; ++k) {
    text += "\n\"Sigma" + std::to_string(k) + "\"\n";
    for (int i = 0; i < 15; ++i) {
      text += "s";
      for (int j = 0; j < 15; ++j) text += i == j ? " 0.01" : " 0";
      text += "\n";
    }
  }
  return text + "\n\"Related_Object\"\npose 1 2 0.5 0 0 0 1\ngrasp 0 0 0\nname door\n";
}

TEST(MixtureFile, IsPlacedAtTheObject) {
  Diagnostics diagnostics;
  const MixtureFile file = parseMixtureFile(smallFile(), "f.csv", diagnostics);
  EXPECT_EQ(diagnostics.warningCount(), 0U);
  const SegmentModel model = toSegmentModel(file, "reach", 5, diagnostics);
  EXPECT_EQ(model.duration, 5);
  EXPECT_NEAR(model.mixture.components[1].mean[0], 1, 1e-15);
  // The object moved by (1, 2, 0.5) from the model's origin: with the object
  // there, the motion is the file's.
  const Pose end = model.chart.decodeGripper(model.end, file.model_T_object);
  EXPECT_LT(end.translation.norm(), 1e-14);
  EXPECT_NEAR(rotationAngle(end.rotation), 90 * kDegree, 1e-12);
  const Pose2 base = model.chart.decodeBase(model.end, file.model_T_object);
  EXPECT_NEAR(base.x, -0.7, 1e-14);
  EXPECT_NEAR(base.theta, 90 * kDegree, 1e-12);
  // Half way the gripper has turned half way: the sign does not matter.
  const Pose middle =
      model.chart.decodeGripper(model.mixture.atTime(0.5).mean, file.model_T_object);
  EXPECT_NEAR(rotationAngle(middle.rotation), 45 * kDegree, 1e-9);
  // Rotation by 2 |dq| for small dq: 0.01 in a quaternion's parts is 0.04 in rad^2.
  EXPECT_NEAR(model.mixture.components[0].covariance(9, 9), 0.04, 1e-12);
}

struct BadFile {
  const char* what;
  const char* replace;
  const char* by;
  const char* message;
};

std::ostream& operator<<(std::ostream& out, const BadFile& bad) { return out << bad.what; }

class BadMixtureFiles : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadMixtureFiles, AreRefusedWithTheirLine) {
  std::string text = smallFile();
  const std::size_t at = text.find(GetParam().replace);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, std::string(GetParam().replace).size(), GetParam().by);
  Diagnostics diagnostics;
  try {
    parseMixtureFile(text, "f.csv", diagnostics);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kInput);
    EXPECT_EQ(e.formatted(), GetParam().message);
  }
}

INSTANTIATE_TEST_SUITE_P(
    MixtureFile, BadMixtureFiles,
    ::testing::Values(
        BadFile{"no priors", "\"Priors\"", "Priors",
                "f.csv:1:1: error: expected \"Priors\", found 'Priors'"},
        BadFile{"empty priors", "p 0.5 0.5", "p", "f.csv:2: error: row 'p' has 0 numbers"},
        BadFile{"negative prior", "p 0.5 0.5", "p 1.5 -0.5",
                "f.csv:2: error: priors must be positive"},
        BadFile{"no number", "p 0.5 0.5", "p 0.5 half", "f.csv:2:7: error: 'half' is not a number"},
        BadFile{"row too short", "\nx -0.4 0", "\nx -0.4",
                "f.csv:6: error: row 'x' has 1 numbers, not 2"},
        BadFile{"rows swapped", "\ny 0.1 0", "\nz 0.1 0",
                "f.csv:7:1: error: expected y, found 'z'"},
        BadFile{"long quaternion", "\nqw 1 ", "\nqw 2 ",
                "f.csv:12: error: the quaternion of a mean does not have length 1"},
        BadFile{"variance of t", "s 0.01 0", "s 0 0",
                "f.csv:22: error: the variance of t must be positive"},
        BadFile{"not symmetric", "s 0.01 0", "s 0.01 0.5",
                "f.csv:36: error: Sigma1 is not symmetric"},
        BadFile{"sigma missing", "\"Sigma2\"", "\"Sigma3\"",
                "f.csv:38:1: error: expected \"Sigma2\", found '\"Sigma3\"'"},
        BadFile{"zero quaternion", "0.5 0 0 0 1\n", "0.5 0 0 0 0\n",
                "f.csv:56: error: the quaternion is zero"},
        BadFile{"no name", "name door", "name", "f.csv:58: error: the object has no name"},
        BadFile{"two names", "name door", "name door 2", "f.csv:58:11: error: unexpected '2'"},
        BadFile{"more text", "name door\n", "name door\n\nend",
                "f.csv:60:1: error: unexpected 'end'"},
        BadFile{"cut off", "grasp 0 0 0\nname door\n", "",
                "f.csv:56: error: the file ends where grasp should follow"}));

TEST(MixtureFile, TimesThatDoNotRiseAreRefused) {
  std::string text = smallFile();
  text.replace(text.find("t 0 0.8"), 7, "t 0.8 0");
  Diagnostics diagnostics;
  const MixtureFile file = parseMixtureFile(text, "f.csv", diagnostics);
  EXPECT_THROW(toSegmentModel(file, "reach", 5, diagnostics), Error);
}

TEST(MixtureFile, RepairsAreCounted) {
  std::string text = smallFile();
  text.replace(text.find("p 0.5 0.5"), 9, "p 0.5 0.2");
  const std::size_t second_row = text.find("s 0 0.01");
  text.replace(second_row, 8, "s 0 -0.1");
  Diagnostics diagnostics;
  const MixtureFile file = parseMixtureFile(text, "f.csv", diagnostics);
  ASSERT_EQ(diagnostics.lines().size(), 2U);
  EXPECT_EQ(diagnostics.lines()[0], "f.csv: warning: priors sum to 0.7: scaled to 1");
  EXPECT_EQ(diagnostics.lines()[1],
            "f.csv: warning: 1 negative eigenvalues of covariances set to 0");
  EXPECT_NEAR(file.mixture.components[0].covariance(1, 1), 0, 1e-15);
}

}  // namespace
}  // namespace graft::lfd
