// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "apps/report/page.hpp"
#include "apps/report/table_rows.hpp"

namespace graft::report {

namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

std::string seconds(double value) { return fixedNumber(value, value < 10 ? 2 : 1) + " s"; }

std::string metres(double value) {
  return value < 0.01 ? shortNumber(1000 * value, 2) + " mm"
                      : shortNumber(100 * value, value < 0.1 ? 2 : 1) + " cm";
}

std::string degrees(double value) { return shortNumber(kDegrees * value, 2) + "\u00B0"; }

std::string wholeDegrees(double value) { return fixedNumber(kDegrees * value, 0) + "\u00B0"; }

std::string plural(std::size_t count, const std::string& noun) {
  return groupedNumber(count) + " " + noun + (count == 1 ? "" : "s");
}

bool torsoEstimated(const lfd::LearnResult& result) {
  const auto& demos = result.task.demonstrations;
  return std::any_of(demos.begin(), demos.end(),
                     [](const auto& demo) { return demo.matched.torso_estimated; });
}

/// What the result itself tells beside its numbers.
std::vector<std::string> remarks(const lfd::LearnResult& result) {
  std::vector<std::string> lines;
  if (torsoEstimated(result)) {
    lines.push_back(
        "The torso was not recorded in all demonstrations; where it was not, it was estimated from "
        "the hand.");
  }
  for (const char* entity : {"hand", "object", "torso"}) {
    if (result.task.task.trackers.count(entity) > 0) continue;
    if (std::string(entity) == "torso" && torsoEstimated(result)) continue;
    lines.push_back("No accuracy was given for the tracker of the " + std::string(entity) +
                    "; it was estimated from the recordings (see Weights).");
  }
  if (result.task.task.map.empty()) {
    lines.push_back("The task has no map: collisions of the base were not considered.");
  }
  if (!result.common_grasp) return lines;
  std::size_t unsolved = 0;
  std::size_t too_fast = 0;
  for (const lfd::IkTrack& track : result.joints) {
    unsolved += track.joints.size() - track.solved;
    too_fast += track.too_fast;
  }
  if (unsolved > 0) {
    lines.push_back("No arm configuration was found for " + plural(unsolved, "tuple") +
                    "; their fields in joints.csv are empty.");
  }
  if (too_fast > 0) {
    lines.push_back(plural(too_fast, "step") +
                    " between neighbouring tuples would need joints faster than the robot's: a "
                    "change of the arm's posture, or a demonstration too fast for it.");
  }
  return lines;
}

std::string sigmaText(double sigma, bool rotation) {
  return rotation ? degrees(sigma) : metres(sigma);
}

}  // namespace

void addOverview(Page& page, const lfd::LearnResult& result) {
  page.paragraph(
      result.common_grasp
          ? "What the robot learned from watching: the recordings were corrected, a grasp for the "
            "robot's gripper was chosen, and base positions were found from which the arm reaches "
            "all of it (method: Welschehold, Dornhege, Burgard, 2017)."
          : "Nothing was learned from these recordings, because the person held the object in "
            "different ways. Below is how they differ.",
      "quiet");
  double duration = 0;
  for (const lfd::PreparedDemonstration& demo : result.task.demonstrations) {
    if (demo.size() > 0) duration += demo.matched.times.back() - demo.matched.times.front();
  }
  std::vector<std::pair<std::string, std::string>> facts{
      {"Demonstrations", groupedNumber(result.task.demonstrations.size())},
      {"Tuples", groupedNumber(result.task.tupleCount())},
      {"Recorded", seconds(duration)}};
  if (result.common_grasp) {
    facts.push_back({"Iterations", std::to_string(result.summary.iterationCount())});
    facts.push_back({"Grasp", "row " + std::to_string(result.grasp.row)});
  }
  const auto total = result.seconds.find("total");
  if (total != result.seconds.end()) facts.push_back({"Computed in", seconds(total->second)});
  page.facts(facts);
}

void addMessages(Page& page, const lfd::LearnResult& result,
                 const std::vector<std::string>& messages) {
  const std::vector<std::string> lines = remarks(result);
  if (lines.empty() && messages.empty()) return;
  page.heading("Remarks");
  if (!lines.empty()) page.list(lines);
  if (!messages.empty()) page.list(messages, "plain quiet");
}

void addTable(Page& page, const lfd::LearnResult& result) {
  const std::string& task = result.task.task.name;
  const bool paper = isTaskOfPaper(task);
  page.heading("Before and after");
  std::vector<std::string> head{"", "before", "after"};
  if (paper) head.insert(head.end(), {"paper, before", "paper, after"});
  std::vector<std::vector<std::string>> cells;
  for (const TableRow& row : tableRows(task, result.table_before, result.table_after)) {
    std::vector<std::string> line{row.label, formatValue(row.before, row.unit),
                                  formatValue(row.after, row.unit)};
    if (paper) {
      line.push_back(formatGiven(row.paper_before, row.unit));
      line.push_back(formatGiven(row.paper_after, row.unit));
    }
    cells.push_back(line);
  }
  page.table(head, cells);
  std::string note =
      "\u201CBefore\u201D takes the recording as it is: the gripper is where the hand was, the "
      "base "
      "under the torso. A dash is a row that is not defined there.";
  if (paper) {
    note +=
        " The paper's figures (its Table I) come from its own recordings of a task of this kind.";
  }
  page.paragraph(note, "quiet");
  page.paragraph("The optimized hand and object differ from what was measured by " +
                     shortNumber(result.residual_per_dof, 2) +
                     " times the variance stated for the trackers, per degree of freedom: about 1 "
                     "means that the correction is as large as their noise.",
                 "quiet");
}

void addGrasp(Page& page, const lfd::LearnResult& result) {
  const lfd::LearnedGrasp& grasp = result.grasp;
  page.heading("The grasp");
  std::string text = "Row " + std::to_string(grasp.row) + " of the grasp file";
  if (grasp.choice.flipped) text += ", turned by 180\u00B0 about its approach,";
  text += " was chosen; its cost is " + roughNumber(grasp.choice.cost) + ".";
  if (grasp.runner_up.index >= 0) {
    text += " The runner-up is row " + std::to_string(grasp.runner_up_row) + " with cost " +
            roughNumber(grasp.runner_up.cost) + ".";
  } else {
    text += " There is no other valid grasp.";
  }
  text +=
      " The cost is the squared distance between estimate and grasp in standard deviations of "
      "the edge for grasp quality.";
  page.paragraph(text);
  const auto found = grasp.covariance.find("object_T_gripper");
  if (found != grasp.covariance.end() && found->second.rows() == 6) {
    const Eigen::MatrixXd& c = found->second;
    page.paragraph("The gripper's place on the object is known to " +
                   metres(std::sqrt(std::max(0.0, c.topLeftCorner(3, 3).trace()))) + " and " +
                   degrees(std::sqrt(std::max(0.0, c.bottomRightCorner(3, 3).trace()))) +
                   " (one standard deviation, from the graph).");
  }
  std::vector<std::vector<std::string>> rows;
  for (std::size_t d = 0; d < grasp.hand_T_gripper.size(); ++d) {
    const Vec<double, 6> e = poseError(grasp.hand_T_gripper[d]);
    const std::string name = d < result.task.demonstrations.size()
                                 ? result.task.demonstrations[d].matched.name
                                 : std::to_string(d + 1);
    rows.push_back({name, fixedNumber(100 * e.head<3>().norm(), 2) + " cm",
                    fixedNumber(kDegrees * e.tail<3>().norm(), 1) + "\u00B0"});
  }
  if (!rows.empty()) page.table({"Gripper in the hand", "distance", "angle"}, rows);
}

void addModes(Page& page, const lfd::LearnResult& result) {
  const lfd::RecordedHolds& holds = result.holds;
  page.heading("Ways of holding the object");
  const std::size_t left_out = holds.names.size() - result.task.demonstrations.size();
  page.paragraph("The demonstrations hold the object in " + plural(holds.modes.size(), "way") +
                     ", and one grasp cannot serve them all. This is what was learned from mode " +
                     std::to_string(result.mode) + "; " + plural(left_out, "demonstration") +
                     " of other modes " + (left_out == 1 ? "is" : "are") + " left out.",
                 "warning");
  std::vector<std::vector<std::string>> rows;
  for (std::size_t m = 0; m < holds.modes.size(); ++m) {
    const lfd::GraspMode& mode = holds.modes[m];
    std::string names;
    for (const std::size_t d : mode.demonstrations) {
      names += (names.empty() ? "" : ", ") + holds.names[d];
    }
    const bool one = mode.demonstrations.size() == 1;
    rows.push_back({std::to_string(m) + (m == result.mode ? " (learned)" : ""), names,
                    one ? "\u2013" : metres(mode.distance), one ? "\u2013" : degrees(mode.angle)});
  }
  page.table({"Mode", "demonstrations", "spread", "turn"}, rows);
  page.list(lfd::describeLeftOut(holds, result.mode));
  page.paragraph("The same way means within " + metres(lfd::kSameGraspDistance) + " and " +
                     wholeDegrees(lfd::kSameGraspAngle) +
                     ", any two of a mode; a hand turned by half a turn about its approach counts "
                     "as the same. Learn another with --grasp-mode N, or each with --grasp-mode "
                     "all.",
                 "quiet");
}

void addDisagreement(Page& page, const lfd::LearnResult& result) {
  page.heading("No common grasp");
  page.paragraph(
      "No two demonstrations hold the object in the same way, so there is no grasp to "
      "learn. Nothing was optimized. They differ by up to " +
          metres(result.holds.spread.distance) + " and " + wholeDegrees(result.holds.spread.angle) +
          "; the same grasp means within " + metres(lfd::kSameGraspDistance) + " and " +
          wholeDegrees(lfd::kSameGraspAngle) + ".",
      "warning");
  page.list(lfd::describeDisagreement(result.holds), "two");
  page.paragraph(
      "Learn from demonstrations that hold the object alike: leave the others out of the "
      "task file, or record them again.");
}

void addSolve(Page& page, const lfd::LearnResult& result) {
  const Summary& summary = result.summary;
  page.heading("Optimization");
  std::string status = statusName(summary.status);
  std::replace(status.begin(), status.end(), '_', ' ');
  std::string text = "Status: " + status;
  if (!summary.reason.empty()) text += " (" + summary.reason + ")";
  text +=
      " after " + plural(std::size_t(summary.iterationCount()), "iteration") + "; \u03C7\u00B2 " +
      roughNumber(summary.chi2_initial) + " \u2192 " + roughNumber(summary.chi2_final) + ". " +
      plural(std::size_t(std::max<std::int64_t>(0, summary.associations_changed)), "association") +
      " with grasps and reachable cells changed on the way.";
  page.paragraph(text);
  if (!summary.notes.empty()) page.list(summary.notes, "plain quiet");
}

void addModel(Page& page, const lfd::LearnResult& result) {
  if (result.model.segments.empty()) return;
  page.heading("Motion models");
  page.paragraph(
      "One mixture of Gaussians per segment over time, gripper and base; the number of "
      "components was chosen by the Bayesian information criterion.");
  std::vector<std::vector<std::string>> rows;
  for (const lfd::SegmentModel& segment : result.model.segments) {
    rows.push_back({segment.name, fixedNumber(segment.duration, 2) + " s",
                    std::to_string(segment.mixture.components.size()),
                    std::to_string(segment.demonstrations), std::to_string(segment.samples)});
  }
  page.table({"Segment", "duration", "components", "demonstrations", "samples"}, rows);
}

void addWeights(Page& page, const lfd::LearnResult& result) {
  page.heading("Weights");
  page.paragraph("Standard deviations of the edges' errors, as used.", "quiet");
  const lfd::Weights& weights = result.task.weights;
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, sigma] : lfd::namedWeights(weights)) {
    rows.push_back({name, sigmaText(sigma.t, false), sigmaText(sigma.r, true)});
  }
  page.table({"Edge", "translation", "rotation"}, rows);
  rows.clear();
  for (const lfd::PreparedDemonstration& demo : result.task.demonstrations) {
    std::vector<std::string> row{demo.matched.name};
    for (const lfd::TrackerAccuracy* a :
         {&demo.accuracy.hand, &demo.accuracy.object, &demo.accuracy.torso}) {
      row.push_back(metres(a->sigma_t) + ", " + degrees(a->sigma_r));
    }
    rows.push_back(row);
  }
  page.table({"Trackers", "hand", "object", "torso"}, rows);
  page.paragraph("Factors: relative motion " + shortNumber(weights.relative_motion_factor) +
                     " times the tracker's, " + shortNumber(weights.interpolated_factor) +
                     " times more between interpolated poses; smoothness " +
                     shortNumber(weights.smooth_factor) + " times the demonstrated step.",
                 "quiet");
}

void addSeconds(Page& page, const lfd::LearnResult& result) {
  if (result.seconds.empty()) return;
  page.heading("Time");
  std::vector<std::pair<std::string, double>> phases;
  for (const auto& phase : result.seconds) {
    if (phase.first != "total") phases.push_back(phase);
  }
  std::stable_sort(phases.begin(), phases.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::vector<std::vector<std::string>> rows;
  rows.reserve(phases.size() + 1);
  for (const auto& [phase, value] : phases) {
    rows.push_back({phase, fixedNumber(value, 3) + " s"});
  }
  const auto total = result.seconds.find("total");
  if (total != result.seconds.end()) {
    rows.push_back({"total", fixedNumber(total->second, 3) + " s"});
  }
  page.table({"Phase", "seconds"}, rows);
}

}  // namespace graft::report
