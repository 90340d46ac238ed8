// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <map>

#include "apps/common/interrupt.hpp"
#include "apps/common/last_words.hpp"
#include "apps/common/progress.hpp"
#include "apps/graft/commands.hpp"
#include "apps/graft/engine_options.hpp"
#include "apps/graft/optimize_report.hpp"
#include "apps/graft/robust_options.hpp"
#include "core/base/file.hpp"
#include "core/base/text.hpp"
#include "core/io/g2o_writer.hpp"
#include "core/solve/covariance.hpp"
#include "core/solve/optimizer.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

struct OptimizeOptions {
  EngineOptions engine;
  std::string input;
  std::string output;
  std::string json;
  std::string covariance;
  std::string guess = "auto";
  RobustOptions robust;
  std::string threads = "all";
  SolveOptions solve;
};

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

int threadCount(const std::string& text) {
  if (text == "all") return 0;
  std::int64_t count = 0;
  if (parseInteger(text, count) != NumberStatus::kOk || count < 1 || count > 1024) {
    throw Error(ExitCode::kUsage,
                "--threads: expected 'all' or a number from 1 to 1024, got " + graft::quoted(text));
  }
  return int(count);
}

void refuseContradictions(const OptimizeOptions& options) {
  int wanting = 0;
  for (const std::string* path : {&options.output, &options.json, &options.covariance}) {
    if (*path == "-") ++wanting;
  }
  if (wanting > 1) {
    throw Error(ExitCode::kUsage, "only one of -o, --json, --covariance can be - (stdout)");
  }
}

void requireSolver(Engine& engine, const std::string& name) {
  if (name == "block" || engine.registry().solver(name) != nullptr) return;
  std::string known = knownNames(engine, Kind::kSolver);
  known = known.empty() ? " (known: block)" : " (known: block, " + known.substr(9);
  throw Error(ExitCode::kUsage, "unknown linear solver " + graft::quoted(name) + known);
}

/// Sets the guess by its name, built in or of a plugin.
void setGuess(Engine& engine, const std::string& name, SolveOptions& options) {
  const std::map<std::string, InitialGuess> built_in = {
      {"auto", InitialGuess::kAuto},
      {"file", InitialGuess::kFile},
      {"spanning-tree", InitialGuess::kSpanningTree},
      {"chordal", InitialGuess::kChordal}};
  const auto found = built_in.find(name);
  if (found != built_in.end()) {
    options.initial_guess = found->second;
    return;
  }
  if (engine.registry().guess(name) == nullptr) {
    std::string known = knownNames(engine, Kind::kGuess);
    known = known.empty() ? ")" : ", " + known.substr(9);
    throw Error(ExitCode::kUsage, "--initial-guess: unknown initial guess " + graft::quoted(name) +
                                      " (known: auto, file, spanning-tree, chordal" + known);
  }
  options.initial_guess = InitialGuess::kPlugin;
  options.guess_name = name;
}

Summary solve(const Graph& graph, Values& values, Engine& engine, SolveOptions options,
              double patience) {
  const Watchdog watchdog(options.time_limit, patience);
  ProgressBar bar("optimize", options.iterations);
  options.interrupt = &interruptFlag();
  options.callback = [&bar](const IterationRecord& record, const Values&) {
    char text[64];
    std::snprintf(text, sizeof text, "chi2 %.8g", record.chi2);
    bar.update(record.iteration, text);
    return true;
  };
  return optimize(graph, values, engine.registry(), options);
}

/// One line a vertex by rising id: tag, id, upper triangle of the covariance in
/// its tangent, row by row.
std::string formatCovariances(const Graph& graph, const Values& values,
                              const CovarianceOptions& options) {
  const std::vector<VertexRef> vertices = graph.verticesById();
  const std::vector<Eigen::MatrixXd> covariances =
      marginalCovariances(graph, values, vertices, options);
  std::string out;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    out += std::string(graph.type(vertices[i]).tag) + ' ' + std::to_string(graph.id(vertices[i]));
    const Eigen::MatrixXd& covariance = covariances[i];
    for (Eigen::Index r = 0; r < covariance.rows(); ++r) {
      for (Eigen::Index c = r; c < covariance.cols(); ++c) {
        out += ' ';
        appendDouble(out, covariance(r, c) + 0.0);  // no -0
      }
    }
    out += '\n';
  }
  return out;
}

ExitCode run(OptimizeOptions& options, Clock::time_point start) {
  refuseContradictions(options);
  SolveOptions solve_options = options.solve;
  solve_options.threads = threadCount(options.threads);
  if (options.engine.information == "project") {
    solve_options.information = InformationPolicy::kProject;
  }
  for (const std::string* path : {&options.output, &options.json, &options.covariance}) {
    if (!path->empty() && *path != "-") checkWritable(*path);
  }
  const auto engine = makeEngine(options.engine);
  requireSolver(*engine, solve_options.linear_solver);
  setGuess(*engine, options.guess, solve_options);
  options.robust.resolve(*engine, solve_options);
  const std::string invalid = solve_options.validate();
  if (!invalid.empty()) throw Error(ExitCode::kUsage, invalid);

  RunTimes times;
  const auto load_start = Clock::now();
  LoadedGraph loaded = loadAndReport(options.input, *engine, options.engine);
  // What options say about kernels holds for this run; the output keeps the file's.
  std::unique_ptr<Graph> with_kernels;
  if (options.robust.givesKernels()) {
    with_kernels = std::make_unique<Graph>(loaded.graph);
    options.robust.applyKernels(*with_kernels);
  }
  const Graph& graph = with_kernels != nullptr ? *with_kernels : loaded.graph;
  times.load = secondsSince(load_start);

  const WorkSubject subject(options.input.c_str());
  const Summary summary =
      solve(graph, loaded.values, *engine, solve_options, options.engine.patience);
  for (const std::string& note : summary.notes) printMessage("note", note);

  const auto write_start = Clock::now();
  options.robust.markSwitchedOff(summary, loaded.graph);
  if (!options.output.empty() && summary.usable()) {
    writeFileAtomically(options.output,
                        formatG2o(loaded.graph, loaded.values,
                                  {directoryOf(options.input), directoryOf(options.output)}));
  }
  if (!options.covariance.empty() && summary.usable()) {
    writeFileAtomically(
        options.covariance,
        formatCovariances(solvedGraph(graph, solve_options.level, summary), loaded.values,
                          {solve_options.information, solve_options.threads}));
  }
  times.write = secondsSince(write_start);
  times.total = secondsSince(start);
  if (!options.json.empty()) {
    writeFileAtomically(options.json, formatJson(loaded, summary, times));
  }
  const bool stdout_taken =
      options.output == "-" || options.json == "-" || options.covariance == "-";
  std::fputs(formatSummary(loaded, summary, times).c_str(), stdout_taken ? stderr : stdout);
  if (!summary.usable()) {
    throw Error(ExitCode::kNoResult, {options.input, 0, 0}, "no usable result: " + summary.reason);
  }
  if (summary.status == Status::kInterrupted) return interruptExitCode();
  return ExitCode::kSuccess;
}

}  // namespace

void addOptimize(Program& program, Clock::time_point start) {
  auto options = std::make_shared<OptimizeOptions>();
  CLI::App* command = program.add("optimize", "Find the estimates that fit the edges best",
                                  [options, start] { return run(*options, start); });
  SolveOptions& solve = options->solve;
  command->add_option("IN", options->input, "Graph file (.g2o, or what a plugin reads); - = stdin")
      ->required();
  command->add_option("-o,--output", options->output,
                      "Write the optimized graph here, - = stdout; without it: summary only");
  command->add_option("--iterations", solve.iterations, "Iterations at most")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  const std::map<std::string, Algorithm> algorithms = {{"lm", Algorithm::kLevenbergMarquardt},
                                                       {"gn", Algorithm::kGaussNewton},
                                                       {"dogleg", Algorithm::kDogleg}};
  command
      ->add_option("--algorithm", solve.algorithm,
                   "lm (Levenberg-Marquardt, default), gn (Gauss-Newton) or dogleg")
      ->type_name("NAME")
      ->transform(CLI::CheckedTransformer(algorithms).description(""));
  command
      ->add_option("--linear-solver", solve.linear_solver,
                   "block, or a plugin's solver; see 'graft plugins'")
      ->capture_default_str();
  options->engine.addPluginOption(*command);
  options->robust.addTo(*command);
  command
      ->add_option("--initial-guess", options->guess,
                   "file, spanning-tree, chordal (rotations as free matrices by least squares, "
                   "projected, then translations), a plugin's guess (see 'graft types'), or auto: "
                   "the lowest initial chi2 wins; chordal takes part where the others' is above 10 "
                   "per measured number and rotations are measured around loops")
      ->type_name("NAME")
      ->capture_default_str();
  options->engine.addLoadOptions(*command);
  command
      ->add_option("--alternatives", solve.alternatives,
                   "Other choices of edges that list theirs (which grasp, say) to try once "
                   "converged, those that promise most first; 0 = none")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command
      ->add_option(
          "--inner-iterations", solve.inner_iterations,
          "At most so many after every step for vertices that only edges which choose what "
          "they measure to tie to others, those held; 0 = none")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command->add_option("--time-limit", solve.time_limit, "Stop after this many seconds, 0 = never")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--threads", options->threads, "Threads; the result does not depend on it")
      ->capture_default_str();
  command->add_option("--covariance", options->covariance,
                      "Write here a line per vertex: tag, id, upper triangle of its covariance");
  command->add_option("--json", options->json, "Write the summary as JSON here, - = stdout");
}

}  // namespace graft
