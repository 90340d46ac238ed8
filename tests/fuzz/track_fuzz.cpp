// SPDX-License-Identifier: BSD-3-Clause
// Tracks as TUM and as CSV: stamps rise, numbers are finite, and what is written of a
// track reads back as it.
#include "core/io/trajectory.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace graft::fuzz {

namespace {

void check(const Trajectory& track) {
  require(track.times.size() == track.poses.size(), "stamps and poses do not pair up");
  for (std::size_t i = 0; i < track.size(); ++i) {
    const Pose& pose = track.poses[i];
    require(i == 0 || track.times[i] > track.times[i - 1], "stamps do not rise");
    require(pose.translation.allFinite() && pose.rotation.coeffs().allFinite(), "not finite");
    require(std::abs(pose.rotation.norm() - 1) < 1e-9, "a rotation of another length than 1");
  }
  const std::string text = formatTum(track);
  const File file(text);
  Trajectory again;
  require(accepts([&](Diagnostics& found) { again = readTum(file.path(), found); }),
          "what was written is refused:\n" + text);
  require(formatTum(again) == text, "written, read and written again it is not the same");
}

}  // namespace

void fuzzOne(std::string_view bytes) {
  for (const auto read : {&readTum, &readTrackCsv}) {
    Trajectory track;
    bool taken = false;
    {
      const File file(bytes);
      taken = accepts([&](Diagnostics& found) { track = read(file.path(), found); });
    }
    if (taken) check(track);
  }
}

}  // namespace graft::fuzz
