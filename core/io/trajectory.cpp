// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

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

/// Checks the eight numbers of a line and appends the pose; reports a defect.
void append(double* v, const SourceLocation& where, Trajectory& trajectory,
            Diagnostics& diagnostics) {
  const double length = std::sqrt(v[4] * v[4] + v[5] * v[5] + v[6] * v[6] + v[7] * v[7]);
  if (!(length > 0.5 && length < 2.0)) {
    diagnostics.error(where, "the quaternion has length " + formatDouble(length) +
                                 ", expected 1 (order is qx qy qz qw)");
    return;
  }
  if (std::abs(length - 1) > 0.01) {
    diagnostics.warning(where,
                        "the quaternion has length " + formatDouble(length) + "; it is normalised");
  }
  normalizeQuaternion(v + 4);
  if (!trajectory.times.empty() && v[0] <= trajectory.times.back()) {
    diagnostics.error(where, "time stamps must rise: " + formatDouble(v[0]) + " follows " +
                                 formatDouble(trajectory.times.back()));
    return;
  }
  trajectory.times.push_back(v[0]);
  trajectory.poses.push_back(Pose::fromArray(v + 1));
}

void requireTwo(const std::string& path, const Trajectory& trajectory, Diagnostics& diagnostics) {
  if (trajectory.size() >= 2 || diagnostics.errorCount() > 0) return;
  diagnostics.error({path, 0, 0}, "a track needs at least 2 poses, this has " +
                                      std::to_string(trajectory.size()));
}

/// Fields between commas, without blanks around them.
std::vector<std::string_view> fieldsOf(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0;;) {
    const std::size_t comma = std::min(line.find(',', begin), line.size());
    std::string_view field = line.substr(begin, comma - begin);
    while (!field.empty() && (field.front() == ' ' || field.front() == '\t')) {
      field.remove_prefix(1);
    }
    while (!field.empty() && (field.back() == ' ' || field.back() == '\t')) field.remove_suffix(1);
    fields.push_back(field);
    if (comma == line.size()) return fields;
    begin = comma + 1;
  }
}

constexpr const char* kNames[kColumns] = {"timestamp", "x", "y", "z", "qx", "qy", "qz", "qw"};
constexpr const char* kHeader = "timestamp,x,y,z,qx,qy,qz,qw";

/// Which column of a CSV holds which number.
struct Columns {
  std::size_t count = 0;  ///< of the header
  std::size_t of[kColumns] = {};
};

/// Reads the header; false, with an error, unless every name is there once.
bool readHeader(std::string_view line, const SourceLocation& where, Columns& columns,
                Diagnostics& diagnostics) {
  const std::vector<std::string_view> fields = fieldsOf(line);
  columns.count = fields.size();
  std::string ignored;
  int found[kColumns] = {};
  for (std::size_t c = 0; c < fields.size(); ++c) {
    bool known = false;
    for (int k = 0; k < kColumns; ++k) {
      if (fields[c] != kNames[k]) continue;
      known = true;
      columns.of[k] = c;
      ++found[k];
    }
    if (!known) ignored += (ignored.empty() ? "" : ", ") + quoted(fields[c]);
  }
  for (int k = 0; k < kColumns; ++k) {
    if (found[k] == 1) continue;
    diagnostics.error(where, (found[k] == 0 ? "no column " : "more than one column ") +
                                 quoted(kNames[k]) + "; expected a header with the names " +
                                 kHeader + " in any order, separated by commas, got " +
                                 quoted(line));
    return false;
  }
  if (!ignored.empty()) diagnostics.note(where, "columns that are not read: " + ignored);
  return true;
}

/// Reads the numbers of a line of a CSV; reports the first defect.
bool parseFields(std::string_view line, SourceLocation where, const Columns& columns,
                 double* values, Diagnostics& diagnostics) {
  const std::vector<std::string_view> fields = fieldsOf(line);
  if (fields.size() != columns.count) {
    diagnostics.error(where, "expected " + std::to_string(columns.count) +
                                 " fields as in the header, got " + std::to_string(fields.size()));
    return false;
  }
  for (int k = 0; k < kColumns; ++k) {
    const std::string_view field = fields[columns.of[k]];
    const NumberStatus status = parseDouble(field, values[k]);
    if (status == NumberStatus::kOk) continue;
    where.column = field.data() - line.data() + 1;
    diagnostics.error(where, status == NumberStatus::kEmpty
                                 ? "the field " + quoted(kNames[k]) + " is empty"
                                 : describe(status, field));
    return false;
  }
  return true;
}

bool endsWithCsv(const std::string& path) {
  if (path.size() < 4) return false;
  std::string end = path.substr(path.size() - 4);
  for (char& c : end) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return end == ".csv";
}

}  // namespace

Trajectory readTum(const std::string& path, Diagnostics& diagnostics) {
  const std::string content = readFile(path);
  Trajectory trajectory;
  LineReader lines(content);
  std::string_view line;
  while (lines.next(line)) {
    if (LineTokens(line).atEnd()) continue;
    double v[kColumns];
    if (!parseLine(line, path, lines.lineNumber(), v, diagnostics)) continue;
    append(v, {path, lines.lineNumber(), 0}, trajectory, diagnostics);
  }
  requireTwo(path, trajectory, diagnostics);
  return trajectory;
}

Trajectory readTrackCsv(const std::string& path, Diagnostics& diagnostics) {
  const std::string content = readFile(path);
  Trajectory trajectory;
  LineReader lines(content);
  std::string_view line;
  Columns columns;
  bool header = false;
  while (lines.next(line)) {
    if (LineTokens(line).atEnd()) continue;
    const SourceLocation where{path, lines.lineNumber(), 0};
    double v[kColumns];
    if (!header) {
      if (!readHeader(line, where, columns, diagnostics)) return trajectory;
      header = true;
    } else if (parseFields(line, where, columns, v, diagnostics)) {
      append(v, where, trajectory, diagnostics);
    }
  }
  requireTwo(path, trajectory, diagnostics);
  return trajectory;
}

Trajectory readTrack(const std::string& path, Diagnostics& diagnostics) {
  return endsWithCsv(path) ? readTrackCsv(path, diagnostics) : readTum(path, diagnostics);
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
