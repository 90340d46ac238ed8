// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectory.hpp"

#include <cmath>

#include "core/base/file.hpp"
#include "core/base/text.hpp"

namespace graft {

namespace {

constexpr int kColumns = 8;

/// Reads the eight numbers of a line; reports the first defect.
bool parseLine(std::string_view line, const std::string& path, std::int64_t number, double* values,
               Diagnostics& diagnostics) {
  LineTokens tokens(line);
  for (int i = 0; i < kColumns; ++i) {
    const std::string_view token = tokens.next();
    const NumberStatus status = parseDouble(token, values[i]);
    if (status == NumberStatus::kEmpty) {
      diagnostics.error(
          {path, number, tokens.column()},
          "expected 8 numbers (timestamp x y z qx qy qz qw), got " + std::to_string(i));
      return false;
    }
    if (status != NumberStatus::kOk) {
      diagnostics.error({path, number, tokens.column()}, describe(status, token));
      return false;
    }
  }
  const std::string_view extra = tokens.next();
  if (!extra.empty()) {
    diagnostics.error({path, number, tokens.column()}, "unexpected " + quoted(extra));
    return false;
  }
  return true;
}

}  // namespace

Trajectory readTum(const std::string& path, Diagnostics& diagnostics) {
  const std::string content = readFile(path);
  Trajectory trajectory;
  LineReader lines(content);
  std::string_view line;
  while (lines.next(line)) {
    if (LineTokens(line).atEnd()) continue;
    const SourceLocation where{path, lines.lineNumber(), 0};
    double v[kColumns];
    if (!parseLine(line, path, lines.lineNumber(), v, diagnostics)) continue;
    const double length = std::sqrt(v[4] * v[4] + v[5] * v[5] + v[6] * v[6] + v[7] * v[7]);
    if (!(length > 0.5 && length < 2.0)) {
      diagnostics.error(where, "the quaternion has length " + formatDouble(length) +
                                   ", expected 1 (order is qx qy qz qw)");
      continue;
    }
    if (std::abs(length - 1) > 0.01) {
      diagnostics.warning(
          where, "the quaternion has length " + formatDouble(length) + "; it is normalised");
    }
    normalizeQuaternion(v + 4);
    if (!trajectory.times.empty() && v[0] <= trajectory.times.back()) {
      diagnostics.error(where, "time stamps must rise: " + formatDouble(v[0]) + " follows " +
                                   formatDouble(trajectory.times.back()));
      continue;
    }
    trajectory.times.push_back(v[0]);
    trajectory.poses.push_back(Pose::fromArray(v + 1));
  }
  if (trajectory.size() < 2 && diagnostics.errorCount() == 0) {
    diagnostics.error({path, 0, 0}, "a track needs at least 2 poses, this has " +
                                        std::to_string(trajectory.size()));
  }
  return trajectory;
}

std::string formatTum(const Trajectory& trajectory) {
  std::string out = "# timestamp x y z qx qy qz qw\n";
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    double v[7];
    trajectory.poses[i].toArray(v);
    appendDouble(out, trajectory.times[i]);
    for (const double x : v) {
      out += ' ';
      appendDouble(out, x);
    }
    out += '\n';
  }
  return out;
}

}  // namespace graft
