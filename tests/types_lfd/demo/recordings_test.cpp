// SPDX-License-Identifier: BSD-3-Clause
// From task folders to segments, on the shared recordings.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "core/base/text.hpp"
#include "tests/support/test_data.hpp"
#include "types_lfd/demo/clean.hpp"
#include "types_lfd/demo/match.hpp"
#include "types_lfd/demo/segment.hpp"

namespace graft::lfd {
namespace {

struct Truth {
  double grasp = 0;
  double release = 0;
};

std::map<std::string, Truth> readTruth(const std::string& path) {
  std::string content = testing::readTestFile(path);
  std::replace(content.begin(), content.end(), ',', ' ');
  std::map<std::string, Truth> truth;
  LineReader lines(content);
  std::string_view line;
  lines.next(line);  // header
  while (lines.next(line)) {
    LineTokens tokens(line);
    const std::string name(tokens.next());
    if (name.empty()) continue;
    Truth& times = truth[name];
    EXPECT_EQ(parseDouble(tokens.next(), times.grasp), NumberStatus::kOk) << path;
    EXPECT_EQ(parseDouble(tokens.next(), times.release), NumberStatus::kOk) << path;
  }
  return truth;
}

struct Errors {
  std::vector<double> grasp;  // found minus true, s
  std::vector<double> release;
};

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

std::vector<double> magnitudes(const Errors& errors) {
  std::vector<double> all;
  for (const auto* list : {&errors.grasp, &errors.release}) {
    for (const double error : *list) all.push_back(std::abs(error));
  }
  return all;
}

void print(const char* name, const Errors& errors) {
  const std::vector<double> all = magnitudes(errors);
  std::printf(
      "%-30s |error| median %.2f 90 %% %.2f max %.2f s; grasp median %+.2f [%+.2f %+.2f], "
      "release %+.2f [%+.2f %+.2f]\n",
      name, quantile(all, 0.5), quantile(all, 0.9), quantile(all, 1), quantile(errors.grasp, 0.5),
      quantile(errors.grasp, 0), quantile(errors.grasp, 1), quantile(errors.release, 0.5),
      quantile(errors.release, 0), quantile(errors.release, 1));
}

/// Reads, cleans, matches and segments a task; errors against its truth.
Errors segmentTask(const std::string& folder, bool clean) {
  Diagnostics diagnostics;
  const Task task = readTask(testing::dataPath(folder + "/task.xml"), diagnostics);
  std::vector<Demonstration> demonstrations = readDemonstrations(task, diagnostics);
  EXPECT_EQ(diagnostics.text(), "") << folder;
  const auto truth = readTruth(testing::dataPath(folder + "/truth/segments.csv"));
  Errors errors;
  for (Demonstration& demonstration : demonstrations) {
    const std::vector<double> stamps = matchTracks(demonstration).times;
    if (clean) removeOutliers(demonstration);
    const MatchedDemonstration matched = matchTracks(demonstration);
    EXPECT_EQ(matched.times, stamps) << "cleaning changed the tuples of " << demonstration.name;
    const Segmentation segments = segmentDemonstration(matched);
    EXPECT_LT(0U, segments.grasp);
    EXPECT_LT(segments.grasp, segments.release);
    const Truth& expected = truth.at(demonstration.name);
    errors.grasp.push_back(matched.times[segments.grasp] - expected.grasp);
    errors.release.push_back(matched.times[segments.release] - expected.release);
  }
  return errors;
}

TEST(Recordings, SegmentsAreNearTheTruth) {
  for (const bool clean : {false, true}) {
    Errors pooled;
    for (const char* name : {"room_door", "swivel_door", "drawer", "sliding_door", "mocap_suitcase",
                             "mocap_largetable_many_grasps"}) {
      GRAFT_REQUIRE_DATA(std::string("tasks/") + name + "/task.xml");
      const Errors errors = segmentTask(std::string("tasks/") + name, clean);
      print(name, errors);
      pooled.grasp.insert(pooled.grasp.end(), errors.grasp.begin(), errors.grasp.end());
      pooled.release.insert(pooled.release.end(), errors.release.begin(), errors.release.end());
    }
    print(clean ? "all, outliers removed" : "all", pooled);
    const std::vector<double> all = magnitudes(pooled);
    EXPECT_LE(quantile(all, 0.5), 0.25);
    EXPECT_LE(quantile(all, 0.9), 0.6);
    EXPECT_LE(quantile(pooled.grasp, 0.5), 0.0) << "rather early than late";
  }
}

TEST(Recordings, TuplesAreTheUnionOfTheStamps) {
  GRAFT_REQUIRE_DATA("tasks/room_door/task.xml");
  Diagnostics diagnostics;
  const Task task = readTask(testing::dataPath("tasks/room_door/task.xml"), diagnostics);
  std::size_t tuples = 0;
  for (const Demonstration& demonstration : readDemonstrations(task, diagnostics)) {
    const MatchedDemonstration matched = matchTracks(demonstration);
    tuples += matched.size();
    for (std::size_t i = 0; i < matched.size(); ++i) {
      EXPECT_TRUE(matched.hand.measured[i] != 0 || matched.object.measured[i] != 0 ||
                  matched.torso.measured[i] != 0);
    }
    const TimeSpan common = commonSpan(demonstration);
    EXPECT_EQ(matched.times.front(), common.first);
    EXPECT_EQ(matched.times.back(), common.last);
  }
  std::printf("room_door: %zu tuples\n", tuples);
}

}  // namespace
}  // namespace graft::lfd
