// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/learn/learn.hpp"

#include <memory>

#include "apps/common/interrupt.hpp"
#include "apps/common/progress.hpp"
#include "apps/graft_lfd/commands.hpp"
#include "apps/graft_lfd/session.hpp"
#include "apps/report/report.hpp"
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

/// What other weights would give: tune.json and a picture.
std::vector<TuneTrial> tune(const Options& options, const LearnOptions& learn_options,
                            Registry& registry, StagedDirectory& out) {
  const LearnRun once = [&](const LearnOptions& one) {
    Diagnostics quiet;
    return learn(options.task, out.stagingPath(), registry, quiet, one);
  };
  std::vector<TuneTrial> trials = tuneWeights(once, learn_options);
  out.write("tune.json", formatTuning(trials));
  report::writeTuning(trials, out);
  return trials;
}

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

ExitCode run(const Options& options) {
  if (!options.grasp_mode.empty()) {
    throw Error(ExitCode::kUsage,
                "--grasp-mode: several ways of grasping cannot be separated yet; demonstrations "
                "must hold the object in one way");
  }
  Session session;
  StagedDirectory out(options.out);
  out.replaces(learnOutputs());
  Diagnostics diagnostics;
  LearnOptions learn_options;
  learn_options.iterations = options.iterations;
  learn_options.snapshots = parseList(options.snapshots, "--snapshots");
  learn_options.threads = options.threads;
  learn_options.interrupt = &interruptFlag();
  auto bars = std::make_shared<PhaseBars>();
  learn_options.progress = [bars](const std::string& phase, double fraction) {
    (*bars)(phase, fraction);
  };
  const LearnResult result =
      learn(options.task, out.stagingPath(), session.registry(), diagnostics, learn_options);
  learn_options.progress = nullptr;
  bars.reset();
  printMessages(diagnostics);
  writeResult(result, out);
  if (result.common_grasp) report::writeReport(result, out, diagnostics.lines());
  std::vector<TuneTrial> trials;
  if (result.common_grasp && options.tune) {
    bars = std::make_shared<PhaseBars>();
    learn_options.progress = [bars](const std::string& phase, double fraction) {
      (*bars)(phase, fraction);
    };
    trials = tune(options, learn_options, session.registry(), out);
    learn_options.progress = nullptr;
    bars.reset();
  }
  out.commit();
  if (!result.common_grasp) {
    for (const std::string& line : describeDisagreement(result)) {
      std::fprintf(stderr, "%s: error: %s\n", options.task.c_str(), line.c_str());
    }
    std::fprintf(stderr, "%s: error: no common grasp; %s holds metrics.json and segments.csv\n",
                 options.task.c_str(), options.out.c_str());
    return ExitCode::kNoResult;
  }
  std::printf("%s: %zu demonstrations, %zu tuples; %d iterations, chi2 %.6g to %.6g (%s)\n",
              result.task.task.name.c_str(), result.task.demonstrations.size(),
              result.task.tupleCount(), result.summary.iterationCount(),
              result.summary.chi2_initial, result.summary.chi2_final,
              result.summary.reason.c_str());
  printTable1(result.task.task.name, &result.table_before, result.table_after);
  std::printf("grasp: row %d%s; results in %s (%.2f s)\n", result.grasp.row,
              result.grasp.choice.flipped ? ", turned by 180 degrees" : "", options.out.c_str(),
              result.seconds.at("total"));
  if (options.tune) printTuning(trials);
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
  app->add_option("--grasp-mode", options->grasp_mode, "Way of grasping to learn (N or all)");
  app->add_flag("--tune", options->tune,
                "Also optimize with other weights of E6 (sure grasp against likeness to the "
                "person) and E9 (reach); tune.json and pictures/tune.svg show the best trade-offs");
  app->add_option("--threads", options->threads, "Threads, 0 = all processors")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
}

}  // namespace graft::lfd
