// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/grasp/grasp_set.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/base/file.hpp"
#include "core/base/text.hpp"

namespace graft::lfd {

namespace {

constexpr std::string_view kHeader = "x,y,z,qx,qy,qz,qw,quality";
constexpr int kColumns = 8;

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// Splits a line at commas into eight numbers; reports the first defect.
bool parseRow(std::string_view line, SourceLocation where, double* values,
              Diagnostics& diagnostics) {
  std::size_t begin = 0;
  for (int i = 0; i < kColumns; ++i) {
    const std::size_t comma = line.find(',', begin);
    const bool last = comma == std::string_view::npos;
    where.column = static_cast<std::int64_t>(begin) + 1;
    const std::string_view token = trimmed(line.substr(begin, last ? comma : comma - begin));
    const NumberStatus status = parseDouble(token, values[i]);
    if (status != NumberStatus::kOk) {
      diagnostics.error(where, status == NumberStatus::kEmpty
                                   ? "field " + std::to_string(i + 1) + " is empty"
                                   : describe(status, token));
      return false;
    }
    if (last != (i == kColumns - 1)) {
      where.column = 0;
      diagnostics.error(where, last ? "expected 8 fields (" + std::string(kHeader) + "), got " +
                                          std::to_string(i + 1)
                                    : "more than 8 fields (" + std::string(kHeader) + ")");
      return false;
    }
    begin = comma + 1;
  }
  return true;
}

bool checkRow(const double* values, const SourceLocation& where, Diagnostics& diagnostics) {
  const double length =
      std::hypot(std::hypot(values[3], values[4]), std::hypot(values[5], values[6]));
  if (!(length > 0.5 && length < 2.0)) {
    diagnostics.error(where, "the quaternion has length " + formatDouble(length) +
                                 ", expected 1 (order is qx qy qz qw)");
    return false;
  }
  if (std::abs(length - 1) > 0.01) {
    diagnostics.warning(where,
                        "the quaternion has length " + formatDouble(length) + "; it is normalised");
  }
  if (!(values[7] >= 0 && values[7] <= 1)) {
    diagnostics.error(where, "the quality is " + formatDouble(values[7]) + ", expected 0 to 1");
    return false;
  }
  return true;
}

double cost(const Pose& gripper_T_object, const Pose& object_T_grasp, double sigma_t,
            double sigma_r) {
  const Vec<double, 6> e = poseError(gripper_T_object * object_T_grasp);
  return e.head<3>().squaredNorm() / (sigma_t * sigma_t) +
         e.tail<3>().squaredNorm() / (sigma_r * sigma_r);
}

}  // namespace

GraspSet::GraspSet(std::vector<Grasp> valid) : valid_(std::move(valid)) {
  for (int i = 0; i < static_cast<int>(valid_.size()); ++i) {
    const int row = valid_[static_cast<std::size_t>(i)].row;
    for (const bool flipped : {false, true})
      candidates_.push_back({pose(i, flipped), row, flipped});
  }
}

void GraspSet::keepLike(const Pose& object_T_hand, double sigma_t, double sigma_r) {
  if (candidates_.empty()) return;
  const Pose hand_T_object = object_T_hand.inverse();
  const auto offset = [&](const Pose& grasp) { return poseError(hand_T_object * grasp); };
  const Vec<double, 6> least = offset(pose(nearest(object_T_hand, sigma_t, sigma_r)));
  const double distance = least.head<3>().norm() + kFartherDistance;
  const double angle = least.tail<3>().norm() + kFartherAngle;
  const auto is_farther = [&](const Candidate& c) {
    const Vec<double, 6> e = offset(c.object_T_gripper);
    return e.head<3>().norm() > distance || e.tail<3>().norm() > angle;
  };
  candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), is_farther),
                    candidates_.end());
}

GraspSet GraspSet::read(const std::string& csv_path, double min_quality, Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.errorCount();
  const std::string content = readFile(csv_path);
  LineReader lines(content);
  std::string_view line;
  if (!lines.next(line) || line != kHeader) {
    diagnostics.error({csv_path, 1, 0},
                      "expected the header " + std::string(kHeader) + ", got " + quoted(line));
    return {};
  }
  std::vector<Grasp> valid;
  int row = -1;
  double best = -1;
  std::int64_t empty_line = 0;
  while (lines.next(line)) {
    if (trimmed(line).empty()) {
      if (empty_line == 0) empty_line = lines.lineNumber();
      continue;
    }
    // Rows are counted by lines; only at the end can one be left empty.
    if (empty_line != 0) diagnostics.error({csv_path, empty_line, 0}, "the line is empty");
    empty_line = 0;
    ++row;
    double values[kColumns];
    const SourceLocation where{csv_path, lines.lineNumber(), 0};
    if (!parseRow(line, where, values, diagnostics)) continue;
    if (!checkRow(values, where, diagnostics)) continue;
    normalizeQuaternion(values + 3);
    best = std::max(best, values[7]);
    if (values[7] >= min_quality) valid.push_back({Pose::fromArray(values), values[7], row});
  }
  if (diagnostics.errorCount() > errors) return {};
  if (row < 0) {
    diagnostics.error({csv_path, 0, 0}, "there is no grasp below the header");
  } else if (valid.empty()) {
    diagnostics.error({csv_path, 0, 0}, "no grasp with quality >= " + formatDouble(min_quality) +
                                            " (best " + formatDouble(best) + ")");
  }
  return GraspSet(std::move(valid));
}

GraspSet::Choice GraspSet::nearest(const Pose& object_T_gripper, double sigma_t, double sigma_r,
                                   Choice* runner_up) const {
  const Pose gripper_T_object = object_T_gripper.inverse();
  Choice best;
  Choice second;
  for (std::size_t i = 0; i < valid_.size(); ++i) {
    const int index = static_cast<int>(i);
    Choice candidate{index, false, cost(gripper_T_object, pose(index, false), sigma_t, sigma_r)};
    const double turned = cost(gripper_T_object, pose(index, true), sigma_t, sigma_r);
    if (turned < candidate.cost) candidate = {index, true, turned};
    if (best.index < 0 || candidate.cost < best.cost) {
      second = best;
      best = candidate;
    } else if (second.index < 0 || candidate.cost < second.cost) {
      second = candidate;
    }
  }
  if (runner_up != nullptr) *runner_up = second;
  return best;
}

Pose GraspSet::pose(int index, bool flipped) const {
  const Pose& given = valid_[static_cast<std::size_t>(index)].object_T_gripper;
  return flipped ? flippedGrasp(given) : given;
}

Pose flippedGrasp(const Pose& object_T_gripper) {
  // q * (1, 0, 0, 0) in x y z w, written out: exact, no rounding.
  const Eigen::Quaterniond& q = object_T_gripper.rotation;
  return Pose(object_T_gripper.translation, Eigen::Quaterniond(-q.x(), q.w(), q.z(), -q.y()));
}

}  // namespace graft::lfd
