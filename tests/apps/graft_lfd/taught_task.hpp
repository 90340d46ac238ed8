// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "core/io/trajectory.hpp"
#include "tests/apps/graft_lfd/program.hpp"

namespace graft::testing {

/// A task folder that the simulated teacher wrote, to be changed as a test wants.
class TaughtTask {
 public:
  explicit TaughtTask(const std::string& task = "drawer", int seed = 5)
      : folder_(makeTemporaryDirectory()) {
    const CommandResult taught =
        graftLfd("teach " + task + " --seed " + std::to_string(seed) + " -o " + folder_);
    EXPECT_EQ(taught.exit_code, 0) << taught.err;
  }
  const std::string& folder() const { return folder_; }
  std::string task() const { return folder_ + "/task.xml"; }

  /// Replaces the first `part` of task.xml.
  void replace(const std::string& part, const std::string& by) {
    std::string xml = readTestFile(task());
    const std::size_t at = xml.find(part);
    ASSERT_NE(at, std::string::npos) << part;
    write(task(), xml.replace(at, part.size(), by));
  }
  /// Adds an attribute to a demonstration.
  void attribute(const std::string& demo, const std::string& name, const std::string& value) {
    const std::string named = "name=\"" + demo + "\"";
    replace(named, named + " " + name + "=\"" + value + "\"");
  }
  void remove(const std::string& demo) {
    std::string xml = readTestFile(task());
    const std::size_t name = xml.find("name=\"" + demo + "\"");
    const std::size_t begin = xml.rfind("<demonstration", name);
    write(task(), xml.erase(begin, xml.find("/>", name) + 2 - begin));
  }
  Trajectory track(const std::string& name) const {
    Diagnostics diagnostics;
    return readTum(folder_ + "/" + name, diagnostics);
  }
  void setTrack(const std::string& name, const Trajectory& track) const {
    write(folder_ + "/" + name, formatTum(track));
  }
  /// change(time, pose) on every pose of tracks "hand", "object", "torso" of all
  /// demonstrations, or of one.
  template <class Change>
  void forEachPose(const std::string& entity, const Change& change,
                   const std::string& only = "") const {
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      const std::string demo = entry.path().filename().string();
      const std::string name = demo + "/" + entity + ".tum";
      if (demo.rfind("demo_", 0) != 0 || (!only.empty() && demo != only)) continue;
      if (!std::filesystem::exists(folder_ + "/" + name)) continue;
      Trajectory all = track(name);
      for (std::size_t i = 0; i < all.size(); ++i) change(all.times[i], all.poses[i]);
      setTrack(name, all);
    }
  }

 private:
  static void write(const std::string& path, const std::string& content) {
    std::ofstream(path, std::ios::binary) << content;
  }
  std::string folder_;
};

/// A track of a result folder.
inline Trajectory resultTrack(const std::string& path) {
  Diagnostics diagnostics;
  return readTum(path, diagnostics);
}

}  // namespace graft::testing
