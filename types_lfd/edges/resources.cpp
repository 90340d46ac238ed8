// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "core/base/text.hpp"
#include "types_lfd/edges/grasp_edges.hpp"
#include "types_lfd/edges/reachability_edge.hpp"

namespace graft {

namespace {

std::string pathIn(const std::string& directory, const std::string& name) {
  return name.empty() || name.front() == '/' || directory.empty() ? name : directory + "/" + name;
}

double numberOf(const std::string& token) {
  double value = 0;
  const NumberStatus status = parseDouble(token, value);
  if (status != NumberStatus::kOk) throw Error(ExitCode::kInput, describe(status, token));
  return value;
}

/// The ABI carries one text for a resource that fails to load.
void requireClean(const Diagnostics& diagnostics) {
  if (diagnostics.errorCount() > 0) throw Error(ExitCode::kInput, diagnostics.lines().front());
}

/// `file min_quality x y z qx qy qz qw sigma_t sigma_r`
void keepLike(const std::vector<std::string>& tokens, lfd::GraspSet& set) {
  double numbers[9];
  for (std::size_t i = 0; i < 9; ++i) numbers[i] = numberOf(tokens[i + 2]);
  const double length =
      std::hypot(std::hypot(numbers[3], numbers[4]), std::hypot(numbers[5], numbers[6]));
  if (!(std::abs(length - 1) <= 0.01)) {
    throw Error(ExitCode::kInput, "the grasp's quaternion has length " + formatDouble(length) +
                                      ", expected 1 (order is qx qy qz qw)");
  }
  if (!(numbers[7] > 0 && numbers[8] > 0)) {
    throw Error(ExitCode::kInput, "the sigmas are " + tokens[9] + " and " + tokens[10] +
                                      ", expected positive numbers");
  }
  normalizeQuaternion(numbers + 3);
  set.keepLike(Pose::fromArray(numbers), numbers[7], numbers[8]);
}

}  // namespace

std::unique_ptr<const lfd::GraspSet> ResourceTag<lfd::GraspSet>::load(
    const std::string& directory, const std::vector<std::string>& tokens) {
  if (tokens.size() != 2 && tokens.size() != 11) {
    throw Error(ExitCode::kInput,
                "expected a file and a minimum quality, then nothing or a pose and two sigmas");
  }
  Diagnostics diagnostics;
  auto set = std::make_unique<lfd::GraspSet>(
      lfd::GraspSet::read(pathIn(directory, tokens[0]), numberOf(tokens[1]), diagnostics));
  requireClean(diagnostics);
  if (tokens.size() > 2) keepLike(tokens, *set);
  return set;
}

std::unique_ptr<const lfd::ReachMap> ResourceTag<lfd::ReachMap>::load(
    const std::string& directory, const std::vector<std::string>& tokens) {
  if (tokens.size() != 1) throw Error(ExitCode::kInput, "expected one file");
  return std::make_unique<lfd::ReachMap>(lfd::ReachMap::load(pathIn(directory, tokens[0])));
}

std::unique_ptr<const lfd::FreeSpace> ResourceTag<lfd::FreeSpace>::load(
    const std::string& directory, const std::vector<std::string>& tokens) {
  if (tokens.size() < 7 || tokens.size() % 2 == 0) {
    throw Error(ExitCode::kInput, "expected a map file or '-', and at least three x y pairs");
  }
  auto space = std::make_unique<lfd::FreeSpace>();
  if (tokens[0] == "-") return space;
  std::vector<Eigen::Vector2d> footprint;
  for (std::size_t i = 1; i + 1 < tokens.size(); i += 2) {
    footprint.emplace_back(numberOf(tokens[i]), numberOf(tokens[i + 1]));
  }
  Diagnostics diagnostics;
  space->map = std::make_unique<lfd::OccupancyMap>(
      lfd::OccupancyMap::read(pathIn(directory, tokens[0]), diagnostics));
  requireClean(diagnostics);
  space->checker = std::make_unique<lfd::FootprintChecker>(*space->map, footprint);
  return space;
}

}  // namespace graft
