// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft_lfd/session.hpp"

#include <cmath>
#include <cstdio>
#include <limits>

#include "core/base/text.hpp"

namespace graft::lfd {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegrees = 180 / 3.14159265358979323846;

/// Columns of the paper's Table I, before and after, cm, degrees and percent.
struct PaperColumn {
  const char* task;
  double before[10];
  double after[10];
};
constexpr PaperColumn kPaper[] = {{"room_door",
                                   {2.82, 18.3, kNone, kNone, 1.7, 20.5, 1.7, 20.5, 89.2, 69.8},
                                   {0.55, 8.0, 2.2, 13.5, 0.53, 2.4, 0.5, 4.6, 99.74, 96.86}},
                                  {"swivel_door",
                                   {2.36, 5.3, kNone, kNone, 2.35, 19.3, 2.35, 19.3, kNone, 85.9},
                                   {0.49, 0.7, 2.68, 3.0, 0.21, 1.6, 0.16, 0.9, kNone, 99.52}},
                                  {"drawer",
                                   {6.33, 5.4, kNone, kNone, 2.66, 0.88, 2.66, 0.88, kNone, 87.3},
                                   {0.37, 1.6, 5.54, 2.8, 0.18, 0.21, 0.28, 0.3, kNone, 100}},
                                  {"sliding_door",
                                   {3.23, 6.5, kNone, kNone, 0.51, 3.4, 0.51, 3.4, kNone, 63.2},
                                   {0.60, 0.5, 3.13, 5.8, 0.12, 0.34, 0.16, 0.6, kNone, 99.93}}};

struct Row {
  const char* name;
  const char* unit;
  double before;
  double after;
};

double percent(const std::optional<double>& share) { return share ? 100 * *share : kNone; }

std::vector<Row> rowsOf(const Table1* b, const Table1& a) {
  const auto pair = [&](const char* name, const char* unit, double scale, double Table1::*field) {
    return Row{name, unit, b != nullptr ? scale * (b->*field) : kNone, scale * (a.*field)};
  };
  const auto only = [&](const char* name, const char* unit, double scale,
                        const std::optional<double>& value) {
    return Row{name, unit, kNone, value ? scale * *value : kNone};
  };
  return {pair("distance gripper-grasp", "cm", 100, &Table1::gripper_grasp_m),
          pair("angle gripper-grasp", "deg", kDegrees, &Table1::gripper_grasp_rad),
          only("distance gripper-hand", "cm", 100, a.gripper_hand_m),
          only("angle gripper-hand", "deg", kDegrees, a.gripper_hand_rad),
          pair("spread gripper-object", "cm", 100, &Table1::gripper_object_sd_m),
          pair("spread gripper-object", "deg", kDegrees, &Table1::gripper_object_sd_rad),
          pair("spread hand-object", "cm", 100, &Table1::hand_object_sd_m),
          pair("spread hand-object", "deg", kDegrees, &Table1::hand_object_sd_rad),
          {"map-collision-free", "%", b != nullptr ? percent(b->map_collision_free) : kNone,
           percent(a.map_collision_free)},
          pair("kinematically achievable", "%", 100, &Table1::kinematically_achievable),
          {"arm configuration found", "%", b != nullptr ? percent(b->ik_achievable) : kNone,
           percent(a.ik_achievable)}};
}

std::string cell(double value) {
  if (std::isnan(value)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

}  // namespace

void printTable1(const std::string& task_name, const Table1* before, const Table1& after) {
  const PaperColumn* paper = nullptr;
  for (const PaperColumn& column : kPaper) {
    if (task_name == column.task) paper = &column;
  }
  std::printf("%-26s %4s %9s %9s", "", "", "before", "after");
  if (paper != nullptr) std::printf(" %14s %9s", "paper: before", "after");
  std::printf("\n");
  const std::vector<Row> rows = rowsOf(before, after);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::printf("%-26s %4s %9s %9s", rows[i].name, rows[i].unit, cell(rows[i].before).c_str(),
                cell(rows[i].after).c_str());
    if (paper != nullptr && i < 10) {
      std::printf(" %14s %9s", cell(paper->before[i]).c_str(), cell(paper->after[i]).c_str());
    }
    std::printf("\n");
  }
}

std::vector<int> parseList(const std::string& text, const std::string& option) {
  std::vector<int> list;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    std::int64_t value = 0;
    if (parseInteger(text.substr(begin, end - begin), value) != NumberStatus::kOk || value < 0 ||
        value > 1000000) {
      throw Error(ExitCode::kUsage,
                  option + ": expected numbers separated by commas, got " + quoted(text));
    }
    list.push_back(int(value));
    begin = end + 1;
  }
  return list;
}

Pose parsePose(const std::string& text, const std::string& option) {
  double v[7];
  LineTokens tokens(text);
  for (double& value : v) {
    if (parseDouble(tokens.next(), value) != NumberStatus::kOk) {
      throw Error(ExitCode::kUsage, option + ": expected \"x y z qx qy qz qw\"");
    }
  }
  if (!tokens.atEnd() || !normalizeQuaternion(v + 3)) {
    throw Error(ExitCode::kUsage, option + ": expected \"x y z qx qy qz qw\"");
  }
  return Pose::fromArray(v);
}

}  // namespace graft::lfd
