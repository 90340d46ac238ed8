// SPDX-License-Identifier: BSD-3-Clause
// The learner from end to end, as a person runs it.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "core/geometry/se3.hpp"
#include "tests/apps/graft_lfd/program.hpp"

namespace graft::lfd {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::CommandResult;
using testing::graftLfd;
using testing::graftProgram;

json readJson(const std::string& path) { return json::parse(testing::readTestFile(path)); }

std::vector<std::string> linesOf(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line[0] != '#') lines.push_back(line);
  }
  return lines;
}

/// Estimates of all vertices of a graph file by id.
std::map<long, std::vector<double>> verticesOf(const std::string& path) {
  std::map<long, std::vector<double>> vertices;
  for (const std::string& line : linesOf(path)) {
    std::istringstream words(line);
    std::string tag;
    long id = 0;
    words >> tag >> id;
    if (tag != "VERTEX_SE3:QUAT" && tag != "LFD_BASE") continue;
    for (double v = 0; words >> v;) vertices[id].push_back(v);
  }
  return vertices;
}

double largestDifference(const std::string& a, const std::string& b) {
  const auto first = verticesOf(a);
  const auto second = verticesOf(b);
  EXPECT_EQ(first.size(), second.size());
  double largest = 0;
  for (const auto& [id, numbers] : first) {
    const auto other = second.find(id);
    if (other == second.end() || other->second.size() != numbers.size()) return 1e300;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      largest = std::max(largest, std::abs(numbers[i] - other->second[i]));
    }
  }
  return largest;
}

/// Equal structure, texts and integers; numbers to 1e-9.
void expectSameNumbers(const json& a, const json& b) {
  const json flat_a = a.flatten();
  const json flat_b = b.flatten();
  ASSERT_EQ(flat_a.size(), flat_b.size());
  for (const auto& [key, value] : flat_a.items()) {
    ASSERT_TRUE(flat_b.contains(key)) << key;
    if (value.is_number_float()) {
      EXPECT_NEAR(value.get<double>(), flat_b.at(key).get<double>(),
                  1e-9 * (1 + std::abs(value.get<double>())))
          << key;
    } else {
      EXPECT_EQ(value, flat_b.at(key)) << key;
    }
  }
}

/// The paper's "after" values (Table I) for one of its tasks, m and rad.
struct PaperBounds {
  const char* task;
  double grasp_m, gripper_sd_m, gripper_sd_deg, hand_sd_m, hand_sd_deg, grasp_deg;
};
constexpr PaperBounds kPaper[] = {{"room_door", 0.0055, 0.0053, 2.4, 0.0050, 4.6, 8.0},
                                  {"swivel_door", 0.0049, 0.0021, 1.6, 0.0016, 0.9, 0.7},
                                  {"drawer", 0.0037, 0.0018, 0.21, 0.0028, 0.3, 1.6},
                                  {"sliding_door", 0.0060, 0.0012, 0.34, 0.0016, 0.6, 0.5}};

void expectPaperLevel(const json& metrics, const PaperBounds& paper) {
  const json& after = metrics.at("table1").at("after");
  const double degree = 3.14159265358979323846 / 180;
  EXPECT_LE(after.at("gripper_grasp_m").get<double>(), paper.grasp_m);
  EXPECT_LE(after.at("gripper_grasp_rad").get<double>(), paper.grasp_deg * degree);
  EXPECT_LE(after.at("gripper_object_sd_m").get<double>(), paper.gripper_sd_m);
  EXPECT_LE(after.at("gripper_object_sd_rad").get<double>(), paper.gripper_sd_deg * degree);
  EXPECT_LE(after.at("hand_object_sd_m").get<double>(), paper.hand_sd_m);
  EXPECT_LE(after.at("hand_object_sd_rad").get<double>(), paper.hand_sd_deg * degree);
  EXPECT_GE(after.at("kinematically_achievable").get<double>(), 0.95);
  // Before, gripper and hand are the same thing.
  const json& before = metrics.at("table1").at("before");
  EXPECT_EQ(before.at("gripper_object_sd_m"), before.at("hand_object_sd_m"));
  EXPECT_TRUE(before.at("gripper_hand_m").is_null());
}

/// One taught and learned task for all tests that only look at the result.
class LearnedDrawer : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = testing::makeTemporaryDirectory();
    taught_ = graftLfd("teach drawer --seed 4 -o " + folder_ + "/task");
    learned_ = graftLfd("learn " + folder_ + "/task/task.xml -o " + folder_ + "/out");
  }
  void SetUp() override {
    ASSERT_EQ(taught_.exit_code, 0) << taught_.err;
    ASSERT_EQ(learned_.exit_code, 0) << learned_.err;
  }
  static std::string out(const std::string& name) { return folder_ + "/out/" + name; }

  static std::string folder_;
  static CommandResult taught_;
  static CommandResult learned_;
};
std::string LearnedDrawer::folder_;
CommandResult LearnedDrawer::taught_;
CommandResult LearnedDrawer::learned_;

TEST_F(LearnedDrawer, WritesEveryFileOfTheFormat) {
  for (const char* name : {"segments.csv", "grasp.json", "graph.g2o", "graph_optimized.g2o",
                           "model.json", "metrics.json", "report.html", "pictures", "iterations/0",
                           "iterations/1", "iterations/5", "iterations/20/demo_01/base.tum",
                           "optimized/demo_06/joints.csv", "optimized/demo_01/torso.tum"}) {
    EXPECT_TRUE(fs::exists(out(name))) << name;
  }
  std::set<std::string> hidden;
  for (const auto& entry : fs::directory_iterator(folder_ + "/out")) {
    if (entry.path().filename().string()[0] == '.') hidden.insert(entry.path().filename());
  }
  EXPECT_TRUE(hidden.empty()) << "staging left behind";
}

TEST_F(LearnedDrawer, ReachesThePapersLevel) {
  const json metrics = readJson(out("metrics.json"));
  expectPaperLevel(metrics, kPaper[2]);
  EXPECT_TRUE(metrics.at("torso_estimated").get<bool>());
  for (const char* key :
       {"tuples", "grasp_modes", "weights", "iterations", "chi2", "e1_per_dof", "seconds"}) {
    EXPECT_TRUE(metrics.contains(key)) << key;
  }
}

TEST_F(LearnedDrawer, TracksStandAtTheMatchedStampsAndBasesOnTheFloor) {
  const auto hand = linesOf(out("optimized/demo_01/hand.tum"));
  for (const char* name : {"object", "torso", "gripper", "base"}) {
    const auto other = linesOf(out("optimized/demo_01/" + std::string(name) + ".tum"));
    ASSERT_EQ(other.size(), hand.size()) << name;
    for (std::size_t i = 0; i < hand.size(); ++i) {
      EXPECT_EQ(other[i].substr(0, other[i].find(' ')), hand[i].substr(0, hand[i].find(' ')));
    }
  }
  for (const std::string& line : linesOf(out("optimized/demo_01/base.tum"))) {
    std::istringstream words(line);
    double t, x, y, z, qx, qy, qz, qw;
    words >> t >> x >> y >> z >> qx >> qy >> qz >> qw;
    EXPECT_EQ(z, 0);
    EXPECT_EQ(qx, 0);
    EXPECT_EQ(qy, 0);
  }
}

TEST_F(LearnedDrawer, GraphAloneGivesTheSameResultThroughTheGenericProgram) {
  const CommandResult solved = graftProgram("optimize " + out("graph.g2o") + " -o " + folder_ +
                                            "/again.g2o --json " + folder_ + "/again.json");
  ASSERT_EQ(solved.exit_code, 0) << solved.err;
  EXPECT_LT(largestDifference(folder_ + "/again.g2o", out("graph_optimized.g2o")), 1e-6);
  const CommandResult task =
      graftProgram("optimize " + folder_ + "/task/task.xml --json " + folder_ + "/task.json");
  ASSERT_EQ(task.exit_code, 0) << task.err;
  const double from_graph = readJson(folder_ + "/again.json").at("chi2_final").get<double>();
  const double from_task = readJson(folder_ + "/task.json").at("chi2_final").get<double>();
  EXPECT_NEAR(from_task, from_graph, 1e-9 * from_graph);
  EXPECT_EQ(readJson(folder_ + "/again.json").at("edges"),
            readJson(folder_ + "/task.json").at("edges"));
}

TEST_F(LearnedDrawer, GraspJsonAgreesWithTheGraspFile) {
  const json grasp = readJson(out("grasp.json"));
  const auto rows = linesOf(folder_ + "/task/grasps.csv");
  std::string row = rows.at(1 + grasp.at("grasp_row").get<std::size_t>());
  for (char& c : row) c = c == ',' ? ' ' : c;
  std::istringstream words(row);
  double chosen[7];
  for (double& v : chosen) words >> v;
  normalizeQuaternion(chosen + 3);
  Pose expected = Pose::fromArray(chosen);
  if (grasp.at("flipped").get<bool>()) {
    expected.rotation = expected.rotation * Eigen::Quaterniond(0, 1, 0, 0);
  }
  const auto numbers = grasp.at("object_T_gripper").get<std::vector<double>>();
  const Pose estimated = Pose::fromArray(numbers.data());
  EXPECT_LT((estimated.inverse() * expected).translation.norm(), 0.0037);
  EXPECT_LT(grasp.at("cost").get<double>(), grasp.at("runner_up").at("cost").get<double>());
  EXPECT_NE(grasp.at("runner_up").at("grasp_row"), grasp.at("grasp_row"));
  EXPECT_EQ(grasp.at("hand_T_gripper").size(), 6u);
  EXPECT_EQ(grasp.at("covariance").at("object_T_gripper").size(), 6u);
}

TEST_F(LearnedDrawer, EvaluateRecomputesTheTableFromTheFiles) {
  const CommandResult evaluated = graftLfd("evaluate " + folder_ + "/out --json");
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  const json rows = json::parse(evaluated.out);
  const json after = readJson(out("metrics.json")).at("table1").at("after");
  for (const char* key : {"gripper_grasp_m", "gripper_hand_rad", "gripper_object_sd_m",
                          "hand_object_sd_rad", "kinematically_achievable"}) {
    EXPECT_NEAR(rows.at(key).get<double>(), after.at(key).get<double>(), 1e-9) << key;
  }
}

/// Names and contents of a result's report and pictures.
std::map<std::string, std::string> reportOf(const std::string& folder) {
  std::map<std::string, std::string> files{
      {"report.html", testing::readTestFile(folder + "/report.html")}};
  for (const auto& entry : fs::directory_iterator(folder + "/pictures")) {
    files[entry.path().filename()] = testing::readTestFile(entry.path());
  }
  return files;
}

TEST_F(LearnedDrawer, ReportIsWrittenAnewFromTheFilesAlone) {
  const std::string copy = folder_ + "/copy";
  fs::copy(folder_ + "/out", copy, fs::copy_options::recursive);
  const auto written = reportOf(copy);
  ASSERT_GT(written.size(), 8u);
  fs::remove(copy + "/report.html");
  fs::remove_all(copy + "/pictures");
  fs::create_directory(copy + "/pictures");
  testing::writeTestFile(copy + "/pictures", "stale.svg", "x");
  const CommandResult run = graftLfd("report " + copy);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto again = reportOf(copy);
  for (const auto& [name, content] : written) {
    ASSERT_EQ(again.count(name), 1u) << name;
    EXPECT_TRUE(again.at(name) == content) << name << " differs";
  }
  EXPECT_EQ(again.size(), written.size());
  EXPECT_EQ(testing::readTestFile(copy + "/metrics.json"),
            testing::readTestFile(out("metrics.json")));
}

TEST_F(LearnedDrawer, ReportRefusesFoldersThatAreNoResult) {
  struct Case {
    const char* file;
    const char* find;
    const char* replacement;  ///< null: the file is deleted
    const char* message;
  };
  const Case cases[] = {
      {"resources/scene.json", "", nullptr, "holds no learned result"},
      {"metrics.json", "", nullptr, "metrics.json: error: No such file"},
      {"metrics.json", "\"history\"", "\"histery\"", "metrics.json: error: .*history"},
      {"metrics.json", "{", "[", "metrics.json: error: .*parse"},
      {"graph.g2o", "LFD_OBSERVATION ", "LFD_OBSERVATION x",
       "graph.g2o:\\d+: error: expected an id"},
      {"grasp.json", "\"cost\": ", "\"cost\": \"much\", \"x\": ", "grasp.json: error: "},
      {"grasp.json", "\"object_T_hand\": [", "\"object_T_hand\": [0,",
       "grasp.json: error: a pose needs 7"},
      {"optimized/demo_02/joints.csv", "\n", "\nx,y\n", "joints.csv:2: error: 'y' is not a number"},
      {"optimized/demo_02/base.tum", "", nullptr, "base.tum: error: No such file"},
      {"segments.csv", "demo_01,", "demo_01;", "segments.csv:2: error: expected a name"}};
  for (const Case& one : cases) {
    SCOPED_TRACE(one.message);
    const std::string copy = testing::makeTemporaryDirectory() + "/copy";
    fs::copy(folder_ + "/out", copy, fs::copy_options::recursive);
    const std::string file = copy + "/" + one.file;
    if (one.replacement == nullptr) {
      fs::remove(file);
    } else {
      std::string content = testing::readTestFile(file);
      content.replace(content.find(one.find), std::string(one.find).size(), one.replacement);
      std::ofstream(file, std::ios::binary) << content;
    }
    const CommandResult run = graftLfd("report " + copy);
    EXPECT_EQ(run.exit_code, 3) << run.err;
    EXPECT_TRUE(std::regex_search(run.err, std::regex(one.message))) << run.err;
    EXPECT_EQ(reportOf(copy), reportOf(folder_ + "/out"));
  }
}

TEST_F(LearnedDrawer, ReproduceEndsReachingAtTheGrasp) {
  const CommandResult motion = graftLfd("reproduce " + folder_ + "/out -o " + folder_ + "/motion");
  ASSERT_EQ(motion.exit_code, 0) << motion.err;
  const auto gripper = linesOf(folder_ + "/motion/motion/gripper.tum");
  const auto base = linesOf(folder_ + "/motion/motion/base.tum");
  const auto joints = linesOf(folder_ + "/motion/motion/joints.csv");
  ASSERT_GT(gripper.size(), 50u);
  EXPECT_EQ(base.size(), gripper.size());
  EXPECT_EQ(joints.size(), gripper.size() + 1);
  EXPECT_EQ(joints[0].substr(0, 5), "time,");
  EXPECT_NE(joints[0].find(",base_x,base_y,base_yaw"), std::string::npos);
  // Somewhere on the way the gripper stands at the learned grasp of the object.
  const auto grasp = readJson(out("grasp.json")).at("object_T_gripper").get<std::vector<double>>();
  const auto segments = linesOf(out("segments.csv"));
  std::string grasp_time = segments[1].substr(segments[1].find(',') + 1);
  grasp_time = grasp_time.substr(0, grasp_time.find(','));
  Pose object;
  for (const std::string& line : linesOf(out("optimized/demo_01/object.tum"))) {
    if (line.rfind(grasp_time + " ", 0) != 0) continue;
    std::istringstream words(line);
    double t, v[7];
    words >> t;
    for (double& x : v) words >> x;
    object = Pose::fromArray(v);
  }
  const Pose wanted = object * Pose::fromArray(grasp.data());
  double nearest = 1e300;
  for (const std::string& line : gripper) {
    std::istringstream words(line);
    double t, x, y, z;
    words >> t >> x >> y >> z;
    nearest = std::min(nearest, (Vec<double, 3>(x, y, z) - wanted.translation).norm());
  }
  EXPECT_LT(nearest, 0.005);
}

TEST_F(LearnedDrawer, RunsTwiceToTheSameBytes) {
  const CommandResult again =
      graftLfd("learn " + folder_ + "/task/task.xml --threads 1 -o " + folder_ + "/twice");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  for (const char* name : {"graph.g2o", "graph_optimized.g2o", "model.json", "grasp.json",
                           "segments.csv", "optimized/demo_03/joints.csv"}) {
    EXPECT_EQ(testing::readTestFile(out(name)), testing::readTestFile(folder_ + "/twice/" + name))
        << name;
  }
}

TEST_F(LearnedDrawer, StagesAloneGiveTheSameFiles) {
  ASSERT_EQ(graftLfd("segment " + folder_ + "/task/task.xml -o " + folder_ + "/seg.csv").exit_code,
            0);
  EXPECT_EQ(testing::readTestFile(folder_ + "/seg.csv"),
            testing::readTestFile(out("segments.csv")));
  ASSERT_EQ(graftLfd("build " + folder_ + "/task/task.xml -o " + folder_ + "/built").exit_code, 0);
  EXPECT_EQ(testing::readTestFile(folder_ + "/built/graph.g2o"),
            testing::readTestFile(out("graph.g2o")));
  ASSERT_EQ(graftLfd("fit " + folder_ + "/out -o " + folder_ + "/model.json").exit_code, 0);
  // Bases go through a file as quaternions, which costs the yaw its last bits.
  expectSameNumbers(readJson(folder_ + "/model.json"), readJson(out("model.json")));
  EXPECT_EQ(graftLfd("check " + folder_ + "/task/task.xml").exit_code, 0);
  EXPECT_EQ(graftLfd("match " + folder_ + "/task/task.xml -o " + folder_ + "/matched").exit_code,
            0);
}

TEST(LearnSharedTasks, ReachThePapersLevelOnAllFour) {
  GRAFT_REQUIRE_DATA("tasks");
  for (const PaperBounds& paper : kPaper) {
    SCOPED_TRACE(paper.task);
    const std::string out = testing::makeTemporaryDirectory() + "/out";
    const CommandResult run =
        graftLfd("learn " + testing::dataPath("tasks/" + std::string(paper.task) + "/task.xml") +
                 " -o " + out);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    expectPaperLevel(readJson(out + "/metrics.json"), paper);
    const CommandResult solved =
        graftProgram("optimize " + out + "/graph.g2o -o " + out + "/again.g2o");
    ASSERT_EQ(solved.exit_code, 0) << solved.err;
    EXPECT_LT(largestDifference(out + "/again.g2o", out + "/graph_optimized.g2o"), 1e-6);
  }
}

TEST(LearnSharedTasks, LearnsFromRealMotionCapture) {
  GRAFT_REQUIRE_DATA("tasks/mocap_suitcase/task.xml");
  const std::string out = testing::makeTemporaryDirectory() + "/out";
  const CommandResult run =
      graftLfd("learn " + testing::dataPath("tasks/mocap_suitcase/task.xml") + " -o " + out);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json after = readJson(out + "/metrics.json").at("table1").at("after");
  EXPECT_LE(after.at("gripper_grasp_m").get<double>(), 0.003);
  EXPECT_LE(after.at("gripper_object_sd_m").get<double>(), 0.001);
  EXPECT_GE(after.at("kinematically_achievable").get<double>(), 0.95);
  EXPECT_TRUE(after.at("map_collision_free").is_null());
}

TEST(LearnerProgram, HoldsNoEdgeTypeOfItsOwn) {
  const CommandResult symbols =
      testing::runCommand("nm -C " + testing::binaryDirectory() + "/bin/graft-lfd");
  ASSERT_EQ(symbols.exit_code, 0);
  ASSERT_NE(symbols.out.find("graft::lfd::"), std::string::npos) << "the program is stripped";
  for (const char* name :
       {"ObservationEdge", "ReachabilityEdge", "GraspQualityEdge", "graft_plugin_register"}) {
    EXPECT_EQ(symbols.out.find(name), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace graft::lfd
