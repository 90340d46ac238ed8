// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/geometry/se3.hpp"

namespace graft {

/// Poses with time stamps (s), in one fixed frame; times[i] belongs to poses[i].
struct Trajectory {
  std::vector<double> times;
  std::vector<Pose> poses;
  std::size_t size() const { return times.size(); }
};

/// Reads a TUM file: "timestamp x y z qx qy qz qw" a line, '#' comments.
/// Stamps must rise strictly; quaternions are normalised (one whose length is
/// off by more than 1 % is a warning, by more than a factor of 2 an error).
/// Every defect goes to `diagnostics` with its line; the caller decides.
Trajectory readTum(const std::string& path, Diagnostics& diagnostics);

/// Reads a track from a CSV with a header that names the columns: timestamp, x, y,
/// z, qx, qy, qz, qw in any order. Other columns are not read, and a note names
/// them. Empty lines and lines that begin with '#' are skipped; all else as in
/// readTum().
Trajectory readTrackCsv(const std::string& path, Diagnostics& diagnostics);

/// A file whose name ends in .csv as CSV, any other as TUM.
Trajectory readTrack(const std::string& path, Diagnostics& diagnostics);

/// The TUM format with shortest round-trip numbers.
std::string formatTum(const Trajectory& trajectory);

}  // namespace graft
