// SPDX-License-Identifier: BSD-3-Clause
#include "core/plugin/probe.hpp"

#include "core/plugin/process_state.hpp"

namespace graft {

namespace {

// Words that begin the child's messages.
constexpr char kProvides = 'p';
constexpr char kChange = 'c';
constexpr char kThreads = 't';

void tryToLoad(const std::string& file_or_name, const PluginOptions& options,
               const std::vector<std::string>& required, ContainedChannel& channel) {
  channel.step("loading");
  Registry registry;
  PluginManager plugins(registry, options);
  for (const std::string& one : required) plugins.addFile(one);
  const ProcessState before;
  plugins.addFile(file_or_name);
  const ProcessState after;
  for (const std::string& change : before.changes(after)) channel.message(kChange + change);
  if (after.threads() > before.threads()) {
    channel.message(kThreads + std::to_string(after.threads() - before.threads()));
  }
  if (registry.plugins().empty()) return;
  channel.message(kProvides + formatMetadata(registry.plugins().back().provides));
}

}  // namespace

ProbeResult probePlugin(const std::string& file_or_name, const PluginOptions& options,
                        const ContainedLimits& limits, const std::vector<std::string>& required) {
  PluginOptions inner = options;
  inner.probe = false;
  const ContainedResult run = runContained(limits, [&](ContainedChannel& channel) {
    tryToLoad(file_or_name, inner, required, channel);
  });
  ProbeResult result;
  if (!run.finished) {
    result.failure = (run.threw ? "" : "plugin failed in probe: ") + run.failure;
    if (!run.said.empty()) result.failure += "; it said: " + run.said;
    return result;
  }
  std::string changes;
  for (const std::string& message : run.messages) {
    const std::string text = message.substr(1);
    if (message[0] == kChange) changes += (changes.empty() ? "" : ", ") + text;
    if (message[0] == kThreads) result.notes.push_back("loading it starts " + text + " threads");
    if (message[0] == kProvides) result.provides = parseMetadata(text);
  }
  if (!changes.empty()) result.failure = "plugin failed in probe: loading it changes " + changes;
  return result;
}

}  // namespace graft
