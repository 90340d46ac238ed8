// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/table_rows.hpp"

#include "apps/report/svg.hpp"

namespace graft::report {

namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr std::size_t kRows = 11;
constexpr double kNone = -1;

/// The paper's figures in the order of the rows, before and after.
struct PaperColumn {
  const char* task;
  std::array<double, kRows> before;
  std::array<double, kRows> after;
};

constexpr PaperColumn kPaper[] = {
    {"room_door",
     {2.82, 18.3, kNone, kNone, 1.7, 20.5, 1.7, 20.5, 89.2, 69.8, kNone},
     {0.55, 8.0, 2.2, 13.5, 0.53, 2.4, 0.5, 4.6, 99.74, 96.86, kNone}},
    {"swivel_door",
     {2.36, 5.3, kNone, kNone, 2.35, 19.3, 2.35, 19.3, kNone, 85.9, kNone},
     {0.49, 0.7, 2.68, 3.0, 0.21, 1.6, 0.16, 0.9, kNone, 99.52, kNone}},
    {"drawer",
     {6.33, 5.4, kNone, kNone, 2.66, 0.88, 2.66, 0.88, kNone, 87.3, kNone},
     {0.37, 1.6, 5.54, 2.8, 0.18, 0.21, 0.28, 0.3, kNone, 100, kNone}},
    {"sliding_door",
     {3.23, 6.5, kNone, kNone, 0.51, 3.4, 0.51, 3.4, kNone, 63.2, kNone},
     {0.60, 0.5, 3.13, 5.8, 0.12, 0.34, 0.16, 0.6, kNone, 99.93, kNone}},
};

const PaperColumn* columnOf(const std::string& task) {
  for (const PaperColumn& column : kPaper) {
    if (task == column.task) return &column;
  }
  return nullptr;
}

std::optional<double> scaled(const std::optional<double>& value, Unit unit) {
  if (!value.has_value()) return std::nullopt;
  return *value * (unit == Unit::kDegree ? kDegrees : 100.0);
}

std::string suffix(Unit unit) {
  return unit == Unit::kDegree ? "\u00B0" : std::string(" ") + unitName(unit);
}

std::optional<double> given(double value) {
  return value == kNone ? std::nullopt : std::optional<double>(value);
}

}  // namespace

const char* unitName(Unit unit) {
  switch (unit) {
    case Unit::kCentimetre:
      return "cm";
    case Unit::kDegree:
      return "degrees";
    case Unit::kPercent:
      return "%";
  }
  return "";
}

bool isTaskOfPaper(const std::string& task) { return columnOf(task) != nullptr; }

std::vector<TableRow> tableRows(const std::string& task, const lfd::Table1& before,
                                const lfd::Table1& after) {
  std::vector<TableRow> rows;
  const auto add = [&](const char* label, const char* key, const char* meaning, Unit unit,
                       const std::optional<double>& b, const std::optional<double>& a) {
    rows.push_back({label, key, meaning, unit, scaled(b, unit), scaled(a, unit), {}, {}});
  };
  add("Gripper to grasp, distance", "gripper_grasp_m",
      "From the gripper at the moment of grasping to the nearest valid grasp; mean over "
      "demonstrations.",
      Unit::kCentimetre, before.gripper_grasp_m, after.gripper_grasp_m);
  add("Gripper to grasp, angle", "gripper_grasp_rad", "Likewise, rotation.", Unit::kDegree,
      before.gripper_grasp_rad, after.gripper_grasp_rad);
  add("Gripper to hand, distance", "gripper_hand_m",
      "How far the robot's gripper is from where the person's hand was; mean over all tuples.",
      Unit::kCentimetre, before.gripper_hand_m, after.gripper_hand_m);
  add("Gripper to hand, angle", "gripper_hand_rad", "Likewise, rotation.", Unit::kDegree,
      before.gripper_hand_rad, after.gripper_hand_rad);
  add("Gripper on object, spread", "gripper_object_sd_m",
      "Standard deviation of the gripper seen from the object while it is manipulated.",
      Unit::kCentimetre, before.gripper_object_sd_m, after.gripper_object_sd_m);
  add("Gripper on object, spread of rotation", "gripper_object_sd_rad", "Likewise, rotation.",
      Unit::kDegree, before.gripper_object_sd_rad, after.gripper_object_sd_rad);
  add("Hand on object, spread", "hand_object_sd_m",
      "Standard deviation of the hand seen from the object while it is manipulated.",
      Unit::kCentimetre, before.hand_object_sd_m, after.hand_object_sd_m);
  add("Hand on object, spread of rotation", "hand_object_sd_rad", "Likewise, rotation.",
      Unit::kDegree, before.hand_object_sd_rad, after.hand_object_sd_rad);
  add("Base free of the map's obstacles", "map_collision_free",
      "Share of tuples whose footprint touches no occupied cell.", Unit::kPercent,
      before.map_collision_free, after.map_collision_free);
  add("Base can reach the gripper's pose", "kinematically_achievable",
      "Share of tuples found in the inverse reachability map.", Unit::kPercent,
      before.kinematically_achievable, after.kinematically_achievable);
  add("Arm configuration found", "ik_achievable",
      "Share of tuples for which inverse kinematics gave joint angles (not in the paper).",
      Unit::kPercent, before.ik_achievable, after.ik_achievable);
  if (const PaperColumn* paper = columnOf(task)) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].paper_before = given(paper->before[i]);
      rows[i].paper_after = given(paper->after[i]);
    }
  }
  return rows;
}

std::string formatValue(const std::optional<double>& value, Unit unit) {
  if (!value.has_value()) return "\u2013";
  int decimals = 2;
  if (unit != Unit::kPercent && *value > 0) decimals += (*value < 0.1) + (*value < 0.01);
  return fixedNumber(*value, decimals) + suffix(unit);
}

std::string formatGiven(const std::optional<double>& value, Unit unit) {
  return value.has_value() ? shortNumber(*value) + suffix(unit) : "\u2013";
}

}  // namespace graft::report
