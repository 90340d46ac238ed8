// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>

#include "apps/common/interrupt.hpp"
#include "apps/graft/commands.hpp"
#include "apps/graft/engine_options.hpp"
#include "core/conformance/conformance.hpp"

namespace graft {

namespace {

struct CheckPluginOptions {
  std::string plugin;
  EngineOptions engine;
  ConformanceOptions conformance;
  bool verbose = false;
  bool complete = false;
};

const char* word(Verdict verdict) {
  return verdict == Verdict::kPassed   ? "passed"
         : verdict == Verdict::kFailed ? "FAILED"
                                       : "skipped";
}

/// Checks in a row that have the same to say share a line.
void printOutcomes(const std::vector<CheckOutcome>& outcomes, const Provided& type, bool verbose) {
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const CheckOutcome& one = outcomes[i];
    if (!(one.type == type) || (!verbose && one.verdict == Verdict::kPassed)) continue;
    std::size_t last = i;
    while (!one.text.empty() && last + 1 < outcomes.size() &&
           outcomes[last + 1].verdict == one.verdict && outcomes[last + 1].text == one.text) {
      ++last;
    }
    std::string checks = one.check;
    if (last > i) {
      checks += " to " + outcomes[last].check + " (" + std::to_string(last + 1 - i) + " checks)";
    }
    std::printf("    %s %s%s%s\n", word(one.verdict), checks.c_str(), one.text.empty() ? "" : ": ",
                one.text.c_str());
    i = last;
  }
}

void print(const ConformanceReport& report, bool verbose) {
  const PluginFile& file = report.file;
  std::printf("%s %s  %s\n", file.name.c_str(), file.version.c_str(), file.path.c_str());
  const auto& outcomes = report.outcomes;
  // Outcomes of one type do not stand side by side: metadata comes first.
  std::vector<Provided> types;
  for (const CheckOutcome& one : outcomes) {
    if (std::find(types.begin(), types.end(), one.type) == types.end()) types.push_back(one.type);
  }
  for (const Provided& type : types) {
    std::size_t counts[3] = {};
    for (const CheckOutcome& one : outcomes) {
      if (one.type == type) ++counts[std::size_t(one.verdict)];
    }
    std::printf("  %-8s %-24s %3zu passed, %zu failed, %zu skipped\n", metadataWord(type.kind),
                type.name.c_str(), counts[std::size_t(Verdict::kPassed)],
                counts[std::size_t(Verdict::kFailed)], counts[std::size_t(Verdict::kSkipped)]);
    printOutcomes(outcomes, type, verbose);
  }
  std::printf("%zu checks passed, %zu failed, %zu skipped\n", report.count(Verdict::kPassed),
              report.count(Verdict::kFailed), report.count(Verdict::kSkipped));
}

ExitCode run(const CheckPluginOptions& options) {
  ConformanceOptions conformance = options.conformance;
  conformance.required = options.engine.plugins;
  conformance.interrupt = &interruptFlag();
  const ConformanceReport report =
      checkPlugin(options.plugin, detail::callersPluginOptions(), conformance);
  for (const std::string& note : report.notes) {
    std::fprintf(stderr, "%s\n", formatMessage({report.file.path, 0, 0}, "note", note).c_str());
  }
  print(report, options.verbose);
  for (const CheckOutcome& one : report.outcomes) {
    if (one.verdict != Verdict::kFailed) continue;
    const std::string text = one.type.name + ": " + one.check + ": " + one.text;
    std::fprintf(stderr, "%s\n", formatMessage({report.file.path, 0, 0}, "error", text).c_str());
  }
  const std::size_t skipped = options.complete ? report.count(Verdict::kSkipped) : 0;
  if (skipped > 0) {
    std::fprintf(stderr, "%s\n",
                 formatMessage({report.file.path, 0, 0}, "error",
                               std::to_string(skipped) + " checks could not be made")
                     .c_str());
  }
  return report.count(Verdict::kFailed) + skipped == 0 ? ExitCode::kSuccess : ExitCode::kPlugin;
}

}  // namespace

void addCheckPlugin(Program& program) {
  auto options = std::make_shared<CheckPluginOptions>();
  CLI::App* command = program.add(
      "check-plugin",
      "Check every type of a plugin: derivatives, bounds, state, threads, text (exit code 7 if "
      "one fails)",
      [options] { return run(*options); });
  command->add_option("PLUGIN", options->plugin, "A file, or the name of a plugin that graft knows")
      ->required()
      ->type_name("FILE|NAME");
  ConformanceOptions& conformance = options->conformance;
  command->add_option("--graph", conformance.example,
                      "A graph whose resources, measurements and estimates are inputs, too");
  command->add_option("--only", conformance.only, "Check only the type with this tag or name")
      ->type_name("TAG");
  command->add_option("--samples", conformance.samples, "Random inputs per type")
      ->check(CLI::Range(2, 10000))
      ->capture_default_str();
  command->add_option("--seed", conformance.seed, "Seed of the random inputs")
      ->capture_default_str();
  command->add_option("--time-limit", conformance.check_seconds, "Seconds that a check may take")
      ->check(CLI::Range(0.1, 1e6))
      ->capture_default_str();
  command->add_flag("--complete", options->complete,
                    "A check that cannot be made counts as failed");
  command->add_flag("--verbose", options->verbose, "List the checks that passed, too");
  options->engine.addPluginOption(*command);
}

}  // namespace graft
