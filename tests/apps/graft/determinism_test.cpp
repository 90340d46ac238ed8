// SPDX-License-Identifier: BSD-3-Clause
// The same bits for 1, 2 and 4 threads and for any order of lines: of the written file
// and of every number of chi2, on the public graphs and on one of every family of types.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "tests/support/test_data.hpp"

namespace graft {
namespace {

/// Lines of a file; what belongs to the line before it stays with it.
std::vector<std::string> recordsOf(const std::string& text) {
  std::vector<std::string> records;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const bool attached =
        line.rfind("ROBUST_KERNEL", 0) == 0 || line.rfind("G2O_EDGE_LEVEL", 0) == 0;
    if (attached && !records.empty()) {
      records.back() += line + '\n';
    } else {
      records.push_back(line + '\n');
    }
  }
  return records;
}

/// Takes out what clocks say, and what depends on threads by its nature.
void dropTimes(nlohmann::json& document) {
  if (document.is_object()) {
    document.erase("seconds");
    document.erase("phases");
    document.erase("factor_bytes");  // every thread needs room of its own
  }
  for (auto& item : document) {
    if (item.is_structured()) dropTimes(item);
  }
}

class Determinism : public ::testing::Test {
 protected:
  /// The written file and the numbers of the summary that may not change.
  struct Outcome {
    std::string file;
    std::string summary;
    bool operator==(const Outcome& o) const { return file == o.file && summary == o.summary; }
  };
  Outcome solve(const std::string& path, int threads, const std::string& options) {
    const testing::CommandResult result =
        testing::runCommand(testing::binaryDirectory() + "/bin/graft optimize " + path + " -o " +
                            folder_ + "/out.g2o --json " + folder_ + "/out.json --threads " +
                            std::to_string(threads) + ' ' + options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    auto document = nlohmann::json::parse(testing::readTestFile(folder_ + "/out.json"));
    dropTimes(document);
    for (const char* key : {"threads", "factor_bytes"}) document.erase(key);  // more for more
    if (document.contains("gnc")) {
      for (auto& off : document["gnc"]["off"]) off.erase("line");
    }
    return {testing::readTestFile(folder_ + "/out.g2o"), document.dump()};
  }
  /// Compares the outcomes for all numbers of threads and for two shuffled files.
  void check(const std::string& path, const std::string& options = "") {
    const Outcome first = solve(path, 1, options);
    EXPECT_GT(first.file.size(), 100u);
    for (const int threads : {2, 4}) {
      EXPECT_TRUE(solve(path, threads, options) == first) << path << ' ' << threads;
    }
    std::vector<std::string> records = recordsOf(testing::readTestFile(path));
    std::mt19937_64 random(11);
    for (const int threads : {1, 2}) {
      std::shuffle(records.begin(), records.end(), random);
      std::string text;
      for (const std::string& record : records) text += record;
      const std::string shuffled = testing::writeTestFile(folder_, "shuffled.g2o", text);
      const Outcome outcome = solve(shuffled, threads, options);
      EXPECT_EQ(outcome.summary, first.summary) << path;
      EXPECT_TRUE(outcome.file == first.file) << path << " shuffled";
    }
  }

  std::string folder_ = testing::makeTemporaryDirectory();
};

class DeterminismOfData : public Determinism, public ::testing::WithParamInterface<const char*> {};

TEST_P(DeterminismOfData, OfPublicGraphs) {
  const std::string relative = "pose_graphs/" + std::string(GetParam()) + ".g2o";
  GRAFT_REQUIRE_DATA(relative);
  check(testing::dataPath(relative));
}

INSTANTIATE_TEST_SUITE_P(, DeterminismOfData,
                         ::testing::Values("tinyGrid3D", "smallGrid3D", "MIT", "CSAIL", "intel",
                                           "M3500", "dlr", "parking-garage", "sphere2500",
                                           "torus3D"),
                         [](const auto& info) {
                           std::string name = info.param;
                           name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
                           return name;
                         });

/// Numbers for graphs of one family: around `middle`, the same on every machine.
class Numbers {
 public:
  double near(double middle, double extent = 0.1) {
    return middle + extent * (2 * double(random_() % 100001) / 100000 - 1);
  }
  std::string text(std::initializer_list<double> middles, double extent = 0.1) {
    std::string result;
    for (const double middle : middles) result += ' ' + std::to_string(near(middle, extent));
    return result;
  }

 private:
  std::mt19937_64 random_{17};
};

std::string unit(int n) {
  std::string text;
  for (int r = 0; r < n; ++r) {
    for (int c = r; c < n; ++c) text += r == c ? " 1" : " 0";
  }
  return text;
}

std::string id(int i) { return ' ' + std::to_string(i); }

/// Poses, points, bearings, priors and sightings of many points, with kernels and levels.
std::string planarGraph() {
  Numbers numbers;
  std::string text;
  for (int i = 0; i < 40; ++i) {
    text += "VERTEX_SE2" + id(i) + numbers.text({1.0 * i, 0, 0}) + '\n';
    text += "VERTEX_XY" + id(100 + i) + numbers.text({1.0 * i, 1}) + '\n';
    text += "EDGE_SE2_XY" + id(i) + id(100 + i) + numbers.text({0, 1}) + unit(2) + '\n';
    if (i % 3 == 0) text += "ROBUST_KERNEL Cauchy 0.5\n";
    text += "EDGE_PRIOR_SE2_XY" + id(i) + numbers.text({1.0 * i, 0}) + unit(2) + '\n';
    if (i == 0) continue;
    text += "EDGE_SE2" + id(i - 1) + id(i) + numbers.text({1, 0, 0}) + unit(3) + '\n';
    text +=
        "EDGE_BEARING_SE2_XY" + id(i - 1) + id(100 + i) + numbers.text({0.785}) + unit(1) + '\n';
    if (i % 4 == 0) text += "ROBUST_KERNEL Huber 0.1\nG2O_EDGE_LEVEL 1\n";
  }
  return text;
}

/// Poses, points, priors and cameras in space.
std::string spatialGraph() {
  Numbers numbers;
  std::string text = "PARAMS_SE3OFFSET 900 0 0 0.1 0 0 0 1\n";
  for (int i = 0; i < 30; ++i) {
    text += "VERTEX_SE3:QUAT" + id(i) + numbers.text({1.0 * i, 0, 0}) + " 0 0 0 1\n";
    text += "VERTEX_TRACKXYZ" + id(100 + i) + numbers.text({1.0 * i, 1, 2}) + '\n';
    text += "EDGE_SE3_TRACKXYZ" + id(i) + id(100 + i) + " 900" + numbers.text({0, 1, 2}) + unit(3) +
            '\n';
    if (i == 0) continue;
    text += "EDGE_SE3:QUAT" + id(i - 1) + id(i) + numbers.text({1, 0, 0}) + " 0 0.02 0.01 1" +
            unit(6) + '\n';
    text += "EDGE_SE3_TRACKXYZ" + id(i - 1) + id(100 + i) + " 900" + numbers.text({1, 1, 2}) +
            unit(3) + '\n';
  }
  return text;
}

/// Planes, and Euler-angle poses.
std::string planeGraph() {
  Numbers numbers;
  std::string text;
  for (int i = 0; i < 20; ++i) {
    text += "VERTEX3" + id(i) + numbers.text({1.0 * i, 0, 0, 0, 0, 0}, 0.05) + '\n';
    text += "VERTEX_PLANE" + id(100 + i) + numbers.text({0, 0, 1, 1.0 * i}) + " 0 0 0\n";
    if (i > 0) {
      text +=
          "EDGE_PLANE" + id(100) + id(100 + i) + numbers.text({0, 0, 0, 1.0 * i}) + unit(4) + '\n';
      text += "EDGE_PLANE" + id(99 + i) + id(100 + i) + numbers.text({0, 0, 0, 1}) + unit(4) + '\n';
      text += "EDGE3" + id(i - 1) + id(i) + numbers.text({1, 0, 0, 0, 0, 0}, 0.02) + unit(6) + '\n';
    }
  }
  return text;
}

TEST_F(Determinism, OfEveryFamilyOfTypes) {
  for (const std::string& text : {planarGraph(), spatialGraph(), planeGraph()}) {
    const std::string path = testing::writeTestFile(folder_, "in.g2o", text);
    check(path);
    check(path, "--level all --algorithm dogleg");
    check(path, "--robust-kernel Welsch:2");
  }
}

TEST_F(Determinism, OfSimulatedGraphsWithGraduation) {
  for (const char* world : {"sphere --size 9", "manhattan --size 250"}) {
    const std::string path = folder_ + "/world.g2o";
    ASSERT_EQ(testing::runCommand(testing::binaryDirectory() + "/bin/graft simulate " + world +
                                  " -o " + path)
                  .exit_code,
              0);
    std::string text = testing::readTestFile(path);
    // Closures that are false: one edge's measurement between other vertices.
    for (const std::string& record : recordsOf(text)) {
      const std::size_t first = record.find(' ');
      if (record.rfind("EDGE", 0) != 0 || record.find(" 2 3 ") != first) continue;
      const std::string rest = record.substr(record.find(' ', first + 3));
      for (int i = 0; i < 12; ++i) {
        text += record.substr(0, first) + id(i) + id(70 - 3 * i) + rest;
      }
    }
    const std::string with_false = testing::writeTestFile(folder_, "false.g2o", text);
    for (const char* kind : {"--gnc tls", "--gnc gm"}) {
      check(with_false, kind);
      EXPECT_NE(solve(with_false, 1, kind).summary.find("\"tag\":"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace graft
