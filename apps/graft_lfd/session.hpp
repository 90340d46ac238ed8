// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/plugin/plugin_manager.hpp"
#include "core/types/registry.hpp"
#include "types_lfd/eval/metrics.hpp"

namespace graft::lfd {

/// Registry and plugins of one run.
class Session {
 public:
  Session() : plugins_(registry_) {}
  Registry& registry() { return registry_; }

 private:
  Registry registry_;
  PluginManager plugins_;
};

/// Prints Table I before and after, with the paper's figures where the task is
/// one of the paper's, on standard output.
void printTable1(const std::string& task_name, const Table1* before, const Table1& after);

/// "0,1,5" as numbers; Error(kUsage) naming the option.
std::vector<int> parseList(const std::string& text, const std::string& option);
/// "x y z qx qy qz qw" as a pose; Error(kUsage) naming the option.
Pose parsePose(const std::string& text, const std::string& option);

}  // namespace graft::lfd
