// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/learn/learn.hpp"

#include <filesystem>
#include <memory>

#include "apps/common/interrupt.hpp"
#include "apps/common/progress.hpp"
#include "apps/graft_lfd/commands.hpp"
#include "apps/graft_lfd/session.hpp"
#include "apps/report/report.hpp"
#include "core/base/text.hpp"
#include "types_lfd/learn/result_writer.hpp"
#include "types_lfd/learn/tune.hpp"

namespace graft::lfd {

namespace {

struct Options {
  std::string task;
  std::string out;
  int iterations = 20;
  std::string snapshots = "0,1,5,20";
  std::string grasp_mode;
  bool tune = false;
  int threads = 0;
};

/// One bar a phase, on a terminal only.
class PhaseBars {
 public:
  void operator()(const std::string& phase, double fraction) {
    if (phase != phase_) {
      bar_.reset();
      bar_ = std::make_unique<ProgressBar>(phase, 100);
      phase_ = phase;
    }
    bar_->update(int(100 * fraction), "");
  }

 private:
  std::string phase_;
  std::unique_ptr<ProgressBar> bar_;
};

void printTuning(const std::vector<TuneTrial>& trials) {
  std::printf(
      "\nweight of     weight of     gripper to   gripper to   bases in\n"
      "E6 times      E9 times      grasp, cm    hand, cm     reach, %%\n");
  for (const TuneTrial& trial : trials) {
    if (!trial.best) continue;
    std::printf("%-13.4g %-13.4g %-12.4f %-12.2f %.2f\n", trial.grasp_quality, trial.reachability,
                100 * trial.table.gripper_grasp_m, 100 * trial.table.gripper_hand_m.value_or(0),
                100 * trial.table.kinematically_achievable);
  }
}

/// Which of the modes --grasp-mode asks for.
std::vector<std::size_t> wantedModes(const std::string& text, const RecordedHolds& holds) {
  if (text.empty()) return {0};
  const std::size_t count = holds.modes.size();
  if (text == "all") {
    std::vector<std::size_t> all(count);
    for (std::size_t m = 0; m < count; ++m) all[m] = m;
    return all;
  }
  std::int64_t mode = 0;
  if (parseInteger(text, mode) != NumberStatus::kOk || mode < 0) {
    throw Error(ExitCode::kUsage,
                "--grasp-mode: expected a number or 'all', got " + graft::quoted(text));
  }
  if (mode >= std::int64_t(count)) {
    throw Error(ExitCode::kUsage, "--grasp-mode " + text +
                                      ": the demonstrations hold the object in " +
                                      std::to_string(count) +
                                      (count == 1 ? " way, number 0" : " ways, numbers 0 to ") +
                                      (count == 1 ? "" : std::to_string(count - 1)));
  }
  return {std::size_t(mode)};
}

/// Folders of an earlier --grasp-mode all; they go where a new result comes.
std::vector<std::string> modeFolders(const std::string& directory) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(directory, error)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("mode_", 0) == 0 && std::filesystem::exists(entry.path() / "metrics.json")) {
      names.push_back(name);
    }
  }
  return names;
}

ExitCode refuse(const Options& options, const RecordedTask& recorded, StagedDirectory& out) {
  writeResult(withoutCommonGrasp(recorded), out);
  out.commit();
  for (const std::string& line : describeDisagreement(recorded.holds)) {
    std::fprintf(stderr, "%s: error: %s\n", options.task.c_str(), line.c_str());
  }
  std::fprintf(stderr,
               "%s: error: no common grasp: no two demonstrations hold the object alike; %s holds "
               "metrics.json and segments.csv\n",
               options.task.c_str(), options.out.c_str());
  return ExitCode::kNoResult;
}

void describe(const LearnResult& result, const std::string& folder) {
  if (result.holds.modes.size() > 1) {
    std::printf("mode %zu of %zu: %zu of %zu demonstrations\n", result.mode,
                result.holds.modes.size(), result.task.demonstrations.size(),
                result.holds.names.size());
  }
  std::printf("%s: %zu demonstrations, %zu tuples; %d iterations, chi2 %.6g to %.6g (%s)\n",
              result.task.task.name.c_str(), result.task.demonstrations.size(),
              result.task.tupleCount(), result.summary.iterationCount(),
              result.summary.chi2_initial, result.summary.chi2_final,
              result.summary.reason.c_str());
  printTable1(result.task.task.name, &result.table_before, result.table_after);
  std::printf("grasp: row %d%s; results in %s (%.2f s)\n", result.grasp.row,
              result.grasp.choice.flipped ? ", turned by 180 degrees" : "", folder.c_str(),
              result.seconds.at("total"));
}

struct Learned {
  LearnResult result;
  std::vector<TuneTrial> trials;  ///< of other weights, if asked for
  std::string folder;
};

/// One way of holding the object, with its report, into a staged folder.
/// `reading` is what was said about the recordings.
Learned learnMode(const RecordedTask& recorded, std::size_t mode, StagedDirectory& out,
                  Registry& registry, const Diagnostics& reading, LearnOptions options, bool tune) {
  auto bars = std::make_shared<PhaseBars>();
  options.progress = [bars](const std::string& phase, double fraction) {
    (*bars)(phase, fraction);
  };
  Diagnostics diagnostics;
  Learned learned;
  learned.result = learn(recorded, mode, out.stagingPath(), registry, diagnostics, options);
  if (tune) {
    learned.trials = tuneWeights(recorded, mode, out.stagingPath(), registry, options);
    out.write("tune.json", formatTuning(learned.trials));
    report::writeTuning(learned.trials, out);
  }
  options.progress = nullptr;
  bars.reset();
  printMessages(diagnostics);
  Diagnostics all = reading;
  all.append(diagnostics);
  writeResult(learned.result, out, all.lines());
  report::writeReport(learned.result, out, all.lines());
  return learned;
}

ExitCode run(const Options& options) {
  Session session;
  StagedDirectory out(options.out);
  std::vector<std::string> replaced = learnOutputs();
  for (const std::string& name : modeFolders(options.out)) replaced.push_back(name);
  out.replaces(replaced);
  LearnOptions learn_options;
  learn_options.iterations = options.iterations;
  learn_options.snapshots = parseList(options.snapshots, "--snapshots");
  learn_options.threads = options.threads;
  learn_options.interrupt = &interruptFlag();
  Diagnostics reading;
  const RecordedTask recorded = readRecordings(options.task, reading);
  printMessages(reading);
  const std::vector<std::size_t> modes = wantedModes(options.grasp_mode, recorded.holds);
  if (!recorded.holds.common()) return refuse(options, recorded, out);
  if (options.grasp_mode != "all") {
    // The report tells of them, too, in a section of its own.
    Diagnostics left_out;
    warnOfLeftOut(recorded.task, recorded.holds, modes.front(), left_out);
    printMessages(left_out);
  }
  std::vector<Learned> all;
  for (const std::size_t mode : modes) {
    if (options.grasp_mode != "all") {
      all.push_back(
          learnMode(recorded, mode, out, session.registry(), reading, learn_options, options.tune));
      all.back().folder = options.out;
      continue;
    }
    const std::string name = "mode_" + std::to_string(mode);
    StagedDirectory folder(out.stagingPath() + "/" + name);
    all.push_back(learnMode(recorded, mode, folder, session.registry(), reading, learn_options,
                            options.tune));
    all.back().folder = options.out + "/" + name;
    folder.commit();
  }
  out.commit();
  for (const Learned& learned : all) {
    describe(learned.result, learned.folder);
    if (options.tune) printTuning(learned.trials);
  }
  return interruptFlag() != 0 ? interruptExitCode() : ExitCode::kSuccess;
}

}  // namespace

void addLearn(Program& program) {
  auto options = std::make_shared<Options>();
  CLI::App* app = program.add("learn", "Learn from a task folder: all stages, all outputs",
                              [options] { return run(*options); });
  app->add_option("TASK.xml", options->task, "Task file")->required();
  app->add_option("-o,--output", options->out, "Folder for the results")->required();
  app->add_option("--iterations", options->iterations, "Iterations of the optimizer")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000000));
  app->add_option("--snapshots", options->snapshots,
                  "Iterations whose estimates are written to iterations/")
      ->capture_default_str();
  app->add_option("--grasp-mode", options->grasp_mode,
                  "Way of holding the object to learn, where there are several: its index in "
                  "grasp_modes of metrics.json, from 0; all = each into mode_N/ "
                  "(default: the one that most demonstrations show)");
  app->add_flag("--tune", options->tune,
                "Also optimize with other weights of E6 (sure grasp against likeness to the "
                "person) and E9 (reach); tune.json and pictures/tune.svg show the best trade-offs");
  app->add_option("--threads", options->threads, "Threads, 0 = all processors")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
}

}  // namespace graft::lfd
