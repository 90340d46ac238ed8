// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

#include "apps/report/table_rows.hpp"
#include "tests/apps/report/synthetic_result.hpp"
#include "tests/apps/report/written_report.hpp"

namespace graft::report::testing {
namespace {

using Files = std::map<std::string, std::string>;

std::string printed(double value, const char* format) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

void expectSound(const Files& files) {
  for (const auto& [name, content] : files) EXPECT_EQ(defectOf(content), "") << name;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Report, WritesPageAndPicturesSoundly) {
  const Files files = writtenReport(syntheticResult(), {"task.xml:3: warning: <odd> & \"even\""});
  for (const char* name :
       {"report.html", "pictures/graph.svg", "pictures/map_iteration_0.svg",
        "pictures/map_iteration_5.svg", "pictures/map_iteration_20.svg", "pictures/grasp.svg",
        "pictures/segments.svg", "pictures/convergence.svg", "pictures/table1.svg",
        "pictures/tracks.svg"}) {
    EXPECT_EQ(files.count(name), 1u) << name;
  }
  EXPECT_EQ(files.size(), 10u);
  expectSound(files);
  const std::string& html = files.at("report.html");
  EXPECT_TRUE(has(html, "&lt;odd&gt; &amp; &quot;even&quot;"));
  EXPECT_EQ(occurrences(html, "<svg class"), 9u);
}

TEST(Report, AFewIterationsHaveWholeNumbers) {
  lfd::LearnResult result = syntheticResult();
  result.summary.iterations.clear();
  for (int i = 0; i <= 4; ++i) {
    IterationRecord record;
    record.iteration = i;
    record.chi2 = 1e4 / (i + 1);
    result.summary.iterations.push_back(record);
  }
  const std::string svg = writtenReport(result).at("pictures/convergence.svg");
  EXPECT_TRUE(has(svg, ">3</text>"));
  EXPECT_FALSE(has(svg, ">2.5</text>"));
}

TEST(Report, TableHoldsTheMetrics) {
  const lfd::LearnResult result = syntheticResult();
  const auto rows = tableRowsOf(writtenReport(result).at("report.html"));
  const lfd::Table1& a = result.table_before;
  const lfd::Table1& b = result.table_after;
  const double degrees = 180 / std::acos(-1.0);
  const std::string dash = "\u2013";
  const auto cm = [](double v) { return printed(100 * v, "%.2f cm"); };
  const auto deg = [&](double v) { return printed(degrees * v, "%.2f\u00B0"); };
  const auto share = [](double v) { return printed(100 * v, "%.2f %%"); };
  const std::vector<std::vector<std::string>> expected{
      {"Gripper to grasp, distance", cm(a.gripper_grasp_m), cm(b.gripper_grasp_m), "6.33 cm",
       "0.37 cm"},
      {"Gripper to grasp, angle", deg(a.gripper_grasp_rad), deg(b.gripper_grasp_rad), "5.4\u00B0",
       "1.6\u00B0"},
      {"Gripper to hand, distance", dash, cm(*b.gripper_hand_m), dash, "5.54 cm"},
      {"Gripper to hand, angle", dash, deg(*b.gripper_hand_rad), dash, "2.8\u00B0"},
      {"Gripper on object, spread", cm(a.gripper_object_sd_m), cm(b.gripper_object_sd_m), "2.66 cm",
       "0.18 cm"},
      {"Gripper on object, spread of rotation", deg(a.gripper_object_sd_rad),
       deg(b.gripper_object_sd_rad), "0.88\u00B0", "0.21\u00B0"},
      {"Hand on object, spread", cm(a.hand_object_sd_m), cm(b.hand_object_sd_m), "2.66 cm",
       "0.28 cm"},
      {"Hand on object, spread of rotation", deg(a.hand_object_sd_rad), deg(b.hand_object_sd_rad),
       "0.88\u00B0", "0.3\u00B0"},
      {"Base free of the map's obstacles", share(*a.map_collision_free),
       share(*b.map_collision_free), dash, dash},
      {"Base can reach the gripper's pose", share(a.kinematically_achievable),
       share(b.kinematically_achievable), "87.3 %", "100 %"},
      {"Arm configuration found", dash, share(*b.ik_achievable), dash, dash}};
  ASSERT_GE(rows.size(), expected.size() + 1);
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(rows[i + 1], expected[i]);
}

TEST(Report, PaperColumnsOnlyForItsTasks) {
  ResultOptions options;
  options.task = "cupboard";
  const std::string html = writtenReport(syntheticResult(options)).at("report.html");
  EXPECT_FALSE(has(html, "paper, before"));
  EXPECT_EQ(tableRowsOf(html)[1].size(), 3u);
}

// Before optimization gripper and hand are one thing, so their rows agree; and
// what the paper leaves undefined is undefined here.
TEST(Report, PaperFiguresAreConsistent) {
  for (const char* task : {"room_door", "swivel_door", "drawer", "sliding_door"}) {
    ASSERT_TRUE(isTaskOfPaper(task));
    const std::vector<TableRow> rows = tableRows(task, {}, {});
    ASSERT_EQ(rows.size(), 11u);
    EXPECT_EQ(rows[4].paper_before, rows[6].paper_before);
    EXPECT_EQ(rows[5].paper_before, rows[7].paper_before);
    EXPECT_FALSE(rows[2].paper_before.has_value());
    EXPECT_FALSE(rows[10].paper_after.has_value());
    EXPECT_EQ(rows[8].paper_after.has_value(), std::string(task) == "room_door");
    for (const TableRow& row : rows) {
      if (!row.paper_before.has_value()) continue;
      EXPECT_EQ(row.unit == Unit::kPercent, *row.paper_after > *row.paper_before) << row.key;
    }
  }
}

// The map's caption counts again, on its own, what the pictures draw.
TEST(Report, MapsCountFootprintsAndReach) {
  const lfd::LearnResult result = syntheticResult();
  const Files files = writtenReport(result);
  std::size_t colliding_somewhere = 0;
  for (const auto& [iteration, demos] : result.snapshots) {
    std::size_t tuples = 0;
    std::size_t colliding = 0;
    std::size_t unreachable = 0;
    for (const lfd::DemonstrationEstimate& demo : demos) {
      for (std::size_t i = 0; i < demo.size(); ++i) {
        ++tuples;
        colliding += result.scene.footprint->inCollision(demo.base[i]) ? 1 : 0;
        unreachable += result.scene.reach->contains(demo.gripper[i], demo.base[i]) ? 0 : 1;
      }
    }
    colliding_somewhere += colliding;
    const std::string caption =
        "Out of reach: " + printed(100.0 * double(unreachable) / double(tuples), "%.1f %%") +
        ". In collision: " + printed(100.0 * double(colliding) / double(tuples), "%.1f %%") + ".";
    EXPECT_TRUE(has(files.at("report.html"), caption)) << caption;
    // One closed line of four corners per footprint in collision.
    const std::string& svg =
        files.at("pictures/map_iteration_" + std::to_string(iteration) + ".svg");
    const std::string start = "class=\"s-bad w1 faint\" d=\"";
    const std::size_t at = svg.find(start);
    const std::string path =
        at == std::string::npos
            ? ""
            : svg.substr(at + start.size(), svg.find('"', at + start.size()) - at - start.size());
    EXPECT_EQ(occurrences(path, "Z"), colliding);
  }
  EXPECT_GT(colliding_somewhere, 0u);
}

TEST(Report, WritesTheSameTwice) {
  EXPECT_EQ(writtenReport(syntheticResult()), writtenReport(syntheticResult()));
}

TEST(Report, WithoutMap) {
  ResultOptions options;
  options.map = false;
  const Files files = writtenReport(syntheticResult(options));
  expectSound(files);
  EXPECT_TRUE(has(files.at("report.html"), "The task has no map"));
  EXPECT_FALSE(has(files.at("pictures/map_iteration_0.svg"), "footprint in collision"));
}

TEST(Report, WithoutSnapshotsShowsBeforeAndAfter) {
  ResultOptions options;
  options.snapshots = false;
  const Files files = writtenReport(syntheticResult(options));
  expectSound(files);
  EXPECT_EQ(files.count("pictures/map_before.svg"), 1u);
  EXPECT_EQ(files.count("pictures/map_after.svg"), 1u);
}

TEST(Report, TellsOfEstimatedTorsos) {
  EXPECT_FALSE(has(writtenReport(syntheticResult()).at("report.html"), "torso was not recorded"));
  ResultOptions options;
  options.torso_estimated = true;
  EXPECT_TRUE(
      has(writtenReport(syntheticResult(options)).at("report.html"), "torso was not recorded"));
}

TEST(Report, ExplainsWhyThereIsNoCommonGrasp) {
  ResultOptions options;
  options.common_grasp = false;
  const lfd::LearnResult result = syntheticResult(options);
  const Files files = writtenReport(result);
  expectSound(files);
  const std::string text = plainText(files.at("report.html"));
  const std::vector<std::string> lines = lfd::describeDisagreement(result.holds);
  EXPECT_EQ(lines.size(), 2u);  // the third of three against each other
  for (const std::string& line : lines) EXPECT_TRUE(has(text, line)) << line;
  EXPECT_TRUE(has(text, "No common grasp"));
  EXPECT_FALSE(has(text, "learned from demonstrations"));
  EXPECT_EQ(files.count("pictures/holds.svg"), 1u);
  EXPECT_EQ(files.count("pictures/segments.svg"), 1u);
  EXPECT_EQ(files.count("pictures/convergence.svg"), 0u);
}

TEST(Report, TellsWhichDemonstrationsAreLeftOut) {
  EXPECT_EQ(writtenReport(syntheticResult()).count("pictures/holds.svg"), 0u);
  ResultOptions options;
  options.left_out = true;
  const lfd::LearnResult result = syntheticResult(options);
  ASSERT_EQ(result.holds.modes.size(), 2u);
  const Files files = writtenReport(result);
  expectSound(files);
  const std::string text = plainText(files.at("report.html"));
  const std::vector<std::string> lines = lfd::describeLeftOut(result.holds, 0);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(has(text, lines[0])) << lines[0];
  EXPECT_TRUE(has(text, "0 (learned)"));
  EXPECT_TRUE(has(plainText(files.at("pictures/holds.svg")), "left out"));
  EXPECT_TRUE(has(text, "learned from demonstrations"));
}

TEST(Report, EscapesNames) {
  ResultOptions options;
  options.task = "a <script>\"x\"</script> & \x02 \xFF";
  options.demo_prefix = "d<&\"'>";
  for (const bool common : {true, false}) {
    options.common_grasp = common;
    const Files files = writtenReport(syntheticResult(options));
    expectSound(files);
    EXPECT_TRUE(has(files.at("report.html"), "a &lt;script&gt;"));
    EXPECT_TRUE(has(plainText(files.at("pictures/segments.svg")), "d<&\"'>1"));
  }
}

TEST(Report, StandsNumbersThatAreNotFinite) {
  lfd::LearnResult result = syntheticResult();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  result.table_after.gripper_grasp_m = nan;
  result.table_before.kinematically_achievable = std::numeric_limits<double>::infinity();
  result.summary.chi2_by_tag["LFD_OBSERVATION"] = nan;
  result.summary.iterations[2].chi2 = nan;
  result.summary.iterations[3].chi2 = std::numeric_limits<double>::infinity();
  result.grasp.choice.cost = nan;
  for (auto* demos : {&result.before, &result.after, &result.snapshots[0]}) {
    (*demos)[0].gripper[3].translation[1] = nan;
    (*demos)[0].object[14].translation[0] = nan;
    (*demos)[0].base[5].x = nan;
  }
  expectSound(writtenReport(result));
}

TEST(Report, StandsAlmostNothing) {
  ResultOptions options;
  options.demonstrations = 1;
  lfd::LearnResult result = syntheticResult(options);
  result.snapshots.clear();
  result.summary = Summary();
  result.grasp.runner_up = {};
  result.grasp.covariance.clear();
  result.model.segments.clear();
  result.seconds.clear();
  result.graph.clear();
  result.joints.clear();
  expectSound(writtenReport(result));
  result.before.clear();
  result.after.clear();
  result.scene = {};
  expectSound(writtenReport(result));
}

}  // namespace
}  // namespace graft::report::testing
