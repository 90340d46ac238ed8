// SPDX-License-Identifier: BSD-3-Clause
#include "core/conformance/conformance.hpp"

#include <algorithm>
#include <memory>

#include "core/conformance/checks.hpp"
#include "core/io/graph_loader.hpp"
#include "core/plugin/probe.hpp"

namespace graft {

namespace {

using conformance::Check;
using conformance::Checks;
using conformance::Context;

/// The plugins of one child, and the example graph.
struct Bench {
  Bench(const std::string& plugin, const PluginOptions& plugin_options,
        const ConformanceOptions& options)
      : plugins(registry, plugin_options) {
    for (const std::string& one : options.required) plugins.addFile(one);
    plugins.addFile(plugin);
    if (options.example.empty()) return;
    Diagnostics diagnostics;
    example = std::make_unique<LoadedGraph>(
        loadGraph(options.example, registry, LoadOptions(), diagnostics));
  }
  Context context(const ConformanceOptions& options) {
    Context result{registry, options};
    if (example == nullptr) return result;
    result.example = &example->graph;
    result.example_values = &example->values;
    return result;
  }
  Registry registry;
  PluginManager plugins;
  std::unique_ptr<LoadedGraph> example;
};

Checks checksOf(const Context& context, const Provided& type) {
  Checks checks;
  Registry& registry = context.registry;
  const std::string& name = type.name;
  if (type.kind == Kind::kVertex) addVertexChecks(context, *registry.vertex(name), checks);
  if (type.kind == Kind::kEdge) addEdgeChecks(context, *registry.edge(name), checks);
  if (type.kind == Kind::kKernel) addKernelChecks(context, *registry.kernel(name), checks);
  if (type.kind == Kind::kSolver) addSolverChecks(context, *registry.solver(name), checks);
  if (type.kind == Kind::kResource) addResourceChecks(context, *registry.resource(name), checks);
  if (type.kind == Kind::kLoader) addLoaderChecks(context, *registry.loader(name), checks);
  if (type.kind == Kind::kGuess) addGuessChecks(context, *registry.guess(name), checks);
  return checks;
}

/// Runs one check; the verdict as one line: letter, name, blank, text.
std::string verdictOf(const Check& check) {
  try {
    check.run();
    return "p" + check.name + " ";
  } catch (const conformance::Skip& skip) {
    return "s" + check.name + " " + skip.what();
  } catch (const std::exception& e) {
    return "f" + check.name + " " + e.what();
  } catch (...) {
    return "f" + check.name + " throws what is no std::exception";
  }
}

CheckOutcome outcomeOf(const Provided& type, const std::string& line) {
  const std::size_t blank = line.find(' ');
  const Verdict verdict = line[0] == 'p'   ? Verdict::kPassed
                          : line[0] == 's' ? Verdict::kSkipped
                                           : Verdict::kFailed;
  return {type, line.substr(1, blank - 1), verdict, line.substr(blank + 1)};
}

/// All checks of one type. A check that brings down its child has failed, and
/// the next child goes on behind it.
void checkType(const std::string& plugin, const PluginOptions& plugin_options,
               const ConformanceOptions& options, const Provided& type, ConformanceReport& report) {
  ContainedLimits limits;
  limits.step_seconds = options.check_seconds;
  limits.interrupt = options.interrupt;
  for (std::size_t first = 0;;) {
    const ContainedResult run = runContained(limits, [&](ContainedChannel& channel) {
      channel.step("0 load");
      Bench bench(plugin, plugin_options, options);
      const Checks checks = checksOf(bench.context(options), type);
      for (std::size_t i = first; i < checks.size(); ++i) {
        channel.step(std::to_string(i + 1) + " " + checks[i].name);
        channel.message(verdictOf(checks[i]));
      }
    });
    for (const std::string& line : run.messages) {
      report.outcomes.push_back(outcomeOf(type, line));
    }
    if (run.finished) return;
    const std::size_t blank = run.last_step.find(' ');
    const std::size_t index = blank == std::string::npos ? 0 : std::stoul(run.last_step);
    std::string text = run.failure;
    if (!run.said.empty()) text += "; it said: " + run.said;
    report.outcomes.push_back(
        {type, index == 0 ? "load" : run.last_step.substr(blank + 1), Verdict::kFailed, text});
    if (index == 0) return;
    first = index;
  }
}

void compareMetadata(const PluginFile& file, const std::vector<Provided>& registered,
                     ConformanceReport& report) {
  const auto fail = [&](const Provided& type, const std::string& text) {
    report.outcomes.push_back({type, "metadata", Verdict::kFailed, text});
  };
  for (const Provided& type : registered) {
    const bool listed =
        std::find(file.provides.begin(), file.provides.end(), type) != file.provides.end();
    if (listed)
      report.outcomes.push_back({type, "metadata", Verdict::kPassed, ""});
    else if (!file.has_metadata)
      fail(type, "the file has no list of what it provides");
    else
      fail(type, "the file's list of what it provides does not have it");
  }
  for (const Provided& type : file.provides) {
    if (std::find(registered.begin(), registered.end(), type) == registered.end()) {
      fail(type, "the file says that it provides this, but does not register it");
    }
  }
}

}  // namespace

std::size_t ConformanceReport::count(Verdict verdict) const {
  return std::size_t(std::count_if(outcomes.begin(), outcomes.end(), [&](const CheckOutcome& one) {
    return one.verdict == verdict;
  }));
}

ConformanceReport checkPlugin(const std::string& file_or_name, const PluginOptions& plugins,
                              const ConformanceOptions& options) {
  ConformanceReport report;
  report.file = findPluginFile(file_or_name, plugins);
  const std::string& path = report.file.path;
  if (!report.file.refusal.empty()) {
    throw Error(ExitCode::kPlugin, {path, 0, 0}, report.file.refusal);
  }
  ContainedLimits limits;
  limits.step_seconds = options.check_seconds;
  limits.interrupt = options.interrupt;
  const ProbeResult probe = probePlugin(path, plugins, limits, options.required);
  if (!probe.failure.empty()) throw Error(ExitCode::kPlugin, {path, 0, 0}, probe.failure);
  report.notes = probe.notes;
  compareMetadata(report.file, probe.provides, report);
  bool found = false;
  for (const Provided& type : probe.provides) {
    if (!options.only.empty() && type.name != options.only) continue;
    found = true;
    checkType(path, plugins, options, type, report);
  }
  if (!found && !options.only.empty()) {
    throw Error(ExitCode::kUsage, {path, 0, 0}, "it has no type " + quoted(options.only));
  }
  return report;
}

}  // namespace graft
