// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/teacher.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "core/base/text.hpp"
#include "core/io/trajectory.hpp"
#include "tests/support/test_data.hpp"
#include "types_lfd/demo/task.hpp"
#include "types_lfd/grasp/grasp_set.hpp"
#include "types_lfd/map/occupancy_map.hpp"
#include "types_lfd/xml/xml_reader.hpp"

namespace graft::lfd {
namespace {

namespace fs = std::filesystem;
using graft::testing::makeTemporaryDirectory;
using graft::testing::readTestFile;

/// All files below a folder, by relative name.
std::map<std::string, std::string> contents(const std::string& directory) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), directory).string()] = readTestFile(entry.path().string());
  }
  return files;
}

std::string taught(const std::string& task, std::uint64_t seed, const TeachOptions& options = {}) {
  const std::string directory = makeTemporaryDirectory() + "/out";
  teach(task, directory, seed, options);
  return directory;
}

Trajectory readTrack(const std::string& path) {
  Diagnostics diagnostics;
  Trajectory track = readTum(path, diagnostics);
  EXPECT_EQ(diagnostics.text(), "");
  return track;
}

TEST(Teach, FolderReadsBackWithoutAWord) {
  for (const std::string& name : teachableTasks()) {
    const std::string directory = taught(name, 5);
    Diagnostics diagnostics;
    const Task task = readTask(directory + "/task.xml", diagnostics);
    EXPECT_EQ(task.name, name);
    EXPECT_EQ(task.demonstrations.size(),
              static_cast<std::size_t>(drawScenario(name, 5, {}).demonstrations));
    const OccupancyMap map = OccupancyMap::read(task.map, diagnostics);
    EXPECT_EQ(map.formatPgm(), drawMap(drawScenario(name, 5, {})).formatPgm());
    const GraspSet grasps = GraspSet::read(task.grasps, task.min_quality, diagnostics);
    EXPECT_GE(grasps.valid().size(), 10u);
    EXPECT_LT(grasps.valid().size(), 40u);
    std::set<std::string> links;
    const XmlFile urdf(task.robot.urdf);
    for (const auto* link = urdf.root().FirstChildElement("link"); link != nullptr;
         link = link->NextSiblingElement("link")) {
      links.insert(urdf.required(*link, "name"));
    }
    EXPECT_EQ(links.count(task.robot.base_link), 1u);
    EXPECT_EQ(links.count(task.robot.tip_link), 1u);
    for (const auto* joint = urdf.root().FirstChildElement("joint"); joint != nullptr;
         joint = joint->NextSiblingElement("joint")) {
      for (const char* end : {"parent", "child"}) {
        EXPECT_EQ(links.count(urdf.required(*joint->FirstChildElement(end), "link")), 1u);
      }
    }
    EXPECT_EQ(diagnostics.text(), "") << name;
  }
}

TEST(Teach, SameSeedSameBytesOtherSeedOther) {
  for (const std::string& name : teachableTasks()) {
    const auto once = contents(taught(name, 11));
    const auto again = contents(taught(name, 11));
    EXPECT_EQ(once, again) << name;
    const auto other = contents(taught(name, 12));
    for (const auto& [file, content] : once) {
      ASSERT_EQ(other.count(file), 1u) << file;
      if (file != "robot.urdf") {
        EXPECT_NE(other.at(file), content) << file;
      }
    }
  }
}

/// The union of stamps within the span that all tracks cover: what matching
/// will make of it. Paper: 1529, 419, 656, 1482 tuples.
TEST(Teach, TracksHaveTheSizeOfTheTasks) {
  const std::map<std::string, double> expected = {
      {"room_door", 1529}, {"swivel_door", 419}, {"drawer", 656}, {"sliding_door", 1482}};
  for (const std::string& name : teachableTasks()) {
    const std::string directory = taught(name, 21);
    Diagnostics diagnostics;
    const Task task = readTask(directory + "/task.xml", diagnostics);
    std::set<std::size_t> sizes;
    double tuples = 0;
    for (const DemonstrationSpec& demonstration : task.demonstrations) {
      double from = -1e300;
      double to = 1e300;
      std::set<double> stamps;
      for (const std::string& path :
           {demonstration.hand, demonstration.object, demonstration.torso}) {
        if (path.empty()) continue;
        const Trajectory track = readTrack(path);
        from = std::max(from, track.times.front());
        to = std::min(to, track.times.back());
        stamps.insert(track.times.begin(), track.times.end());
        sizes.insert(track.size());
      }
      tuples += static_cast<double>(std::count_if(stamps.begin(), stamps.end(),
                                                  [&](double t) { return t >= from && t <= to; }));
    }
    EXPECT_NEAR(tuples / expected.at(name), 1, 0.06) << name;
    EXPECT_GT(sizes.size(), 3u) << "tracks differ in length";
  }
}

TEST(Teach, NoiseAgainstTruthHasTheStatedSigma) {
  for (const std::string& name : teachableTasks()) {
    TeachOptions options;
    options.demonstrations = 8;
    const std::string directory = taught(name, 31, options);
    Diagnostics diagnostics;
    const Task task = readTask(directory + "/task.xml", diagnostics);
    for (const auto& [entity, accuracy] : task.trackers) {
      double square_t = 0;
      double square_r = 0;
      int count = 0;
      for (const DemonstrationSpec& d : task.demonstrations) {
        const Trajectory seen = readTrack(directory + "/" + d.name + "/" + entity + ".tum");
        const Trajectory truth = readTrack(directory + "/truth/" + d.name + "_" + entity + ".tum");
        EXPECT_LT(seen.size(), truth.size());
        for (std::size_t i = 0; i < seen.size(); ++i) {
          const auto at = std::find(truth.times.begin(), truth.times.end(), seen.times[i]);
          ASSERT_NE(at, truth.times.end());
          const Pose& exact = truth.poses[static_cast<std::size_t>(at - truth.times.begin())];
          square_t += (seen.poses[i].translation - exact.translation).squaredNorm() / 3;
          square_r +=
              logSO3<double>(exact.rotation.conjugate() * seen.poses[i].rotation).squaredNorm() / 3;
          ++count;
        }
      }
      // 8 tracks of at least 7 s and slow noise of 1 s: some 30 independent
      // triples of it, which leaves 3 % of sigma.
      EXPECT_NEAR(std::sqrt(square_t / count) / accuracy.sigma_t, 1, 0.1) << name << entity;
      EXPECT_NEAR(std::sqrt(square_r / count) / accuracy.sigma_r, 1, 0.1) << name << entity;
    }
  }
}

TEST(Teach, SegmentsAreFramesOfTheTruth) {
  const std::string directory = taught("drawer", 41);
  const std::string segments = readTestFile(directory + "/truth/segments.csv");
  LineReader lines(segments);
  std::string_view line;
  ASSERT_TRUE(lines.next(line));
  EXPECT_EQ(line, "demo,grasp_time,release_time");
  int count = 0;
  while (lines.next(line)) {
    const std::size_t first = line.find(',');
    const std::size_t second = line.find(',', first + 1);
    double grasp = 0;
    double release = 0;
    ASSERT_EQ(parseDouble(line.substr(first + 1, second - first - 1), grasp), NumberStatus::kOk);
    ASSERT_EQ(parseDouble(line.substr(second + 1), release), NumberStatus::kOk);
    const Trajectory hand =
        readTrack(directory + "/truth/" + std::string(line.substr(0, first)) + "_hand.tum");
    EXPECT_EQ(std::count(hand.times.begin(), hand.times.end(), grasp), 1);
    EXPECT_EQ(std::count(hand.times.begin(), hand.times.end(), release), 1);
    EXPECT_GT(release, grasp + 4);
    ++count;
  }
  EXPECT_EQ(count, 6);
}

TEST(Teach, ExactTracksOnRequest) {
  TeachOptions options;
  options.noise_scale = 0;
  options.occlusions = false;
  options.demonstrations = 1;
  const std::string directory = taught("swivel_door", 51, options);
  for (const char* entity : {"hand", "object", "torso"}) {
    EXPECT_EQ(readTestFile(directory + "/demo_01/" + entity + ".tum"),
              readTestFile(directory + "/truth/demo_01_" + entity + ".tum"));
  }
}

TEST(Teach, ReplacesDemonstrationsOfAnEarlierRun) {
  const std::string directory = makeTemporaryDirectory() + "/out";
  teach("drawer", directory, 1);
  graft::testing::writeTestFile(directory, "notes.txt", "mine");
  TeachOptions options;
  options.demonstrations = 2;
  teach("drawer", directory, 1, options);
  EXPECT_TRUE(fs::exists(directory + "/demo_02"));
  EXPECT_FALSE(fs::exists(directory + "/demo_03"));
  EXPECT_FALSE(fs::exists(directory + "/truth/demo_03_hand.tum"));
  EXPECT_EQ(readTestFile(directory + "/notes.txt"), "mine");
}

TEST(Teach, LeavesNothingBehindOnError) {
  const std::string directory = makeTemporaryDirectory() + "/out";
  EXPECT_THROW(teach("window", directory, 1), Error);
  EXPECT_FALSE(fs::exists(directory));
}

}  // namespace
}  // namespace graft::lfd
