// SPDX-License-Identifier: BSD-3-Clause
// The goals of the last step on recorded tasks, checked on the written files
// alone.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/apps/graft_lfd/program.hpp"
#include "types_lfd/learn/result_reader.hpp"
#include "types_lfd/learn/scene_file.hpp"

namespace graft::lfd {
namespace {

/// Rows of joints.csv; empty where no solution was found.
std::vector<std::vector<double>> readJoints(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::string field;
    std::getline(fields, field, ',');
    std::vector<double> row;
    while (std::getline(fields, field, ',')) {
      if (!field.empty()) row.push_back(std::stod(field));
    }
    rows.push_back(row);
  }
  return rows;
}

struct Counts {
  std::size_t tuples = 0;
  std::size_t reachable = 0;
  std::size_t solved = 0;
  std::size_t steps = 0;  ///< with both ends solved
  std::size_t fast = 0;
};

void checkRow(const TaskScene& scene, const DemonstrationEstimate& demo, std::size_t i,
              const std::vector<double>& row) {
  const Chain& chain = *scene.chain;
  ASSERT_EQ(row.size(), std::size_t(chain.dof()));
  const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(row.data(), chain.dof());
  const Pose world_T_base(Eigen::Vector3d(demo.base[i].x, demo.base[i].y, 0),
                          expSO3<double>(Eigen::Vector3d(0, 0, demo.base[i].theta)));
  const Pose gripper = world_T_base * chain.forward(q);
  const Vec<double, 6> e = poseError(gripper.inverse() * demo.gripper[i]);
  EXPECT_LT(e.head<3>().norm(), 1e-3) << demo.name << " " << i;
  EXPECT_LT(2 * e.tail<3>().norm(), 0.1 * 3.14159265358979323846 / 180) << demo.name << " " << i;
  if (scene.map == nullptr) return;
  const Eigen::Matrix3Xd origins = chain.origins(q);
  const Eigen::Vector3d shoulder =
      world_T_base * Vec<double, 3>(origins.col(chain.heightJoint() + 1));
  const Eigen::Vector3d wrist = world_T_base * Vec<double, 3>(origins.col(chain.dof() - 1));
  EXPECT_TRUE(scene.map->segmentFree(shoulder.head<2>(), wrist.head<2>())) << demo.name << " " << i;
}

void checkDemonstration(const TaskScene& scene, const DemonstrationEstimate& demo,
                        const std::vector<std::vector<double>>& joints, Counts& counts) {
  ASSERT_EQ(joints.size(), demo.size());
  for (std::size_t i = 0; i < demo.size(); ++i) {
    ++counts.tuples;
    if (scene.reach->contains(demo.gripper[i], demo.base[i])) ++counts.reachable;
    if (scene.footprint != nullptr) {
      EXPECT_FALSE(scene.footprint->inCollision(demo.base[i])) << demo.name << " " << i;
      if (i > 0) {
        EXPECT_TRUE(scene.footprint->pathFree(demo.base[i - 1], demo.base[i]))
            << demo.name << " " << i;
      }
    }
    if (joints[i].empty()) continue;
    ++counts.solved;
    checkRow(scene, demo, i, joints[i]);
    if (i == 0 || joints[i - 1].empty()) continue;
    ++counts.steps;
    const double seconds = demo.times[i] - demo.times[i - 1];
    double ratio = 0;
    for (std::size_t j = 0; j < joints[i].size(); ++j) {
      const double step = std::abs(joints[i][j] - joints[i - 1][j]);
      ratio = std::max(ratio, step / (scene.chain->velocity()[Eigen::Index(j)] * seconds));
    }
    if (ratio > 2) ++counts.fast;
  }
}

class RefinedTask : public ::testing::TestWithParam<const char*> {};

TEST_P(RefinedTask, IsFreeReachableAndWithinTheArmsSpeed) {
  const std::string task = std::string("tasks/") + GetParam() + "/task.xml";
  GRAFT_REQUIRE_DATA(task);
  const std::string out = testing::makeTemporaryDirectory() + "/out";
  const auto learned = testing::graftLfd("learn " + testing::dataPath(task) + " -o " + out);
  ASSERT_EQ(learned.exit_code, 0) << learned.err;
  const LearnedFolder folder = readLearnedFolder(out);
  Diagnostics diagnostics;
  const TaskScene scene = loadResultScene(folder.task, diagnostics);
  Counts counts;
  for (const DemonstrationEstimate& demo : folder.demonstrations) {
    const auto joints = readJoints(out + "/optimized/" + demo.name + "/joints.csv");
    checkDemonstration(scene, demo, joints, counts);
  }
  EXPECT_GE(double(counts.reachable), 0.999 * double(counts.tuples));
  EXPECT_GE(double(counts.solved), 0.995 * double(counts.tuples));
  EXPECT_LE(double(counts.fast), 0.01 * double(counts.steps));
  const auto metrics = nlohmann::json::parse(testing::readTestFile(out + "/metrics.json"));
  const auto& refinement = metrics.at("refinement");
  EXPECT_EQ(metrics.at("tuples").get<std::size_t>(), counts.tuples);
  EXPECT_EQ(refinement.at("unresolved").get<std::size_t>() == 0, counts.solved == counts.tuples);
  EXPECT_LE(refinement.at("moved").get<std::size_t>(), counts.tuples);
  EXPECT_LT(refinement.at("max_m").get<double>(), 1.0);
}

INSTANTIATE_TEST_SUITE_P(Recorded, RefinedTask,
                         ::testing::Values("room_door", "swivel_door", "drawer", "sliding_door",
                                           "mocap_suitcase"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace graft::lfd
