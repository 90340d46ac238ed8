// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/graft/commands.hpp"
#include "apps/graft/engine_options.hpp"
#include "apps/graft/robust_options.hpp"
#include "core/base/file.hpp"
#include "core/base/text.hpp"
#include "core/solve/evaluation.hpp"

namespace graft {

namespace {

struct EvaluateOptions {
  EngineOptions engine;
  std::string input;
  std::string json;
  std::string residuals;
  std::string level = "0";
  int worst = 10;
};

struct TagSum {
  std::size_t edges = 0;
  double chi2 = 0;
};

/// Everything that the command says.
struct Report {
  double chi2 = 0;
  double gradient_max = 0;
  std::map<std::string, TagSum> by_tag;
  std::vector<const EdgeEvaluation*> worst;
};

Report makeReport(const std::vector<EdgeEvaluation>& edges, const Linearization& linear,
                  int worst) {
  Report report;
  report.chi2 = linear.chi2;
  if (linear.gradient.size() > 0) report.gradient_max = linear.gradient.lpNorm<Eigen::Infinity>();
  for (const EdgeEvaluation& edge : edges) {
    TagSum& sum = report.by_tag[edge.type->tag];
    ++sum.edges;
    sum.chi2 += edge.chi2;
    report.worst.push_back(&edge);
  }
  std::stable_sort(
      report.worst.begin(), report.worst.end(),
      [](const EdgeEvaluation* a, const EdgeEvaluation* b) { return a->chi2 > b->chi2; });
  report.worst.resize(std::min(report.worst.size(), std::size_t(worst)));
  return report;
}

template <class List, class Text>
std::string joined(const List& list, const Text& text) {
  std::string out;
  for (const auto& one : list) out += (out.empty() ? "" : " ") + text(one);
  return out;
}

std::string errorText(const EdgeEvaluation& edge) {
  return joined(edge.error, [](double number) { return formatDouble(number); });
}

/// One line an edge; lists inside a field are separated by blanks.
std::string formatResiduals(const Graph& graph, const std::vector<EdgeEvaluation>& edges) {
  std::string out = "tag,vertices,line,chi2,weight,error,whitened\n";
  for (const EdgeEvaluation& edge : edges) {
    out += std::string(edge.type->tag) + ',' +
           joined(edge.vertices, [&](VertexRef v) { return std::to_string(graph.id(v)); }) + ',' +
           std::to_string(edge.line) + ',' + formatDouble(edge.chi2) + ',' +
           formatDouble(edge.weight) + ',' + errorText(edge) + ',' +
           joined(edge.whitened, [](double number) { return formatDouble(number); }) + '\n';
  }
  return out;
}

std::string formatJson(const LoadedGraph& loaded, const Report& report) {
  nlohmann::ordered_json document;
  document["chi2"] = report.chi2;
  document["gradient_max"] = report.gradient_max;
  document["vertices"] = loaded.counts.vertices;
  document["edges"] = loaded.counts.edges;
  document["by_tag"] = nlohmann::ordered_json::object();
  for (const auto& [tag, sum] : report.by_tag) {
    document["by_tag"][tag] = {{"edges", sum.edges}, {"chi2", sum.chi2}};
  }
  document["worst"] = nlohmann::ordered_json::array();
  for (const EdgeEvaluation* edge : report.worst) {
    nlohmann::ordered_json one;
    one["tag"] = edge->type->tag;
    one["vertices"] = nlohmann::ordered_json::array();
    for (const VertexRef v : edge->vertices) one["vertices"].push_back(loaded.graph.id(v));
    one["line"] = edge->line;
    one["chi2"] = edge->chi2;
    one["weight"] = edge->weight;
    one["error"] = std::vector<double>(edge->error.begin(), edge->error.end());
    document["worst"].push_back(std::move(one));
  }
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

void printSummary(const LoadedGraph& loaded, const Report& report, std::FILE* stream) {
  std::fprintf(stream, "chi2           %.10g\n", report.chi2);
  for (const auto& [tag, sum] : report.by_tag) {
    std::fprintf(stream, "               %.10g  %zu %s\n", sum.chi2, sum.edges, tag.c_str());
  }
  std::fprintf(stream, "gradient       %.3g at most\n", report.gradient_max);
  for (const EdgeEvaluation* edge : report.worst) {
    std::fprintf(stream, "  %-12.6g %s: error %s\n", edge->chi2,
                 edge->describe(loaded.graph).c_str(), errorText(*edge).c_str());
  }
}

ExitCode run(const EvaluateOptions& options) {
  if (options.json == "-" && options.residuals == "-") {
    throw Error(ExitCode::kUsage, "only one of --json, --residuals can be - (stdout)");
  }
  for (const std::string* path : {&options.json, &options.residuals}) {
    if (!path->empty() && *path != "-") checkWritable(*path);
  }
  EvaluationOptions how;
  how.level = parseLevel(options.level);
  const auto engine = makeEngine(options.engine);
  const LoadedGraph loaded = loadAndReport(options.input, *engine, options.engine);
  if (loaded.vertices_made) {
    throw Error(ExitCode::kNoResult, {options.input, 0, 0},
                "the file has no estimates to evaluate at; 'graft optimize' finds some");
  }
  const std::vector<EdgeEvaluation> edges = evaluateEdges(loaded.graph, loaded.values, how);
  const Linearization linear = linearize(loaded.graph, loaded.values, how);
  for (const std::string& note : linear.notes) printMessage("note", note);
  const Report report = makeReport(edges, linear, options.worst);
  if (!options.residuals.empty()) {
    writeFileAtomically(options.residuals, formatResiduals(loaded.graph, edges));
  }
  if (!options.json.empty()) writeFileAtomically(options.json, formatJson(loaded, report));
  const bool taken = options.json == "-" || options.residuals == "-";
  printSummary(loaded, report, taken ? stderr : stdout);
  return ExitCode::kSuccess;
}

}  // namespace

void addEvaluate(Program& program) {
  auto options = std::make_shared<EvaluateOptions>();
  CLI::App* command =
      program.add("evaluate", "Say how well the estimates of a file fit its edges, without solving",
                  [options] { return run(*options); });
  command->add_option("IN", options->input, "Graph file, - = stdin")->required();
  options->engine.addPluginOption(*command);
  options->engine.addLoadOptions(*command);
  command->add_option("--worst", options->worst, "List so many edges with the largest chi2")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command
      ->add_option("--level", options->level,
                   "Take the edges of this level (G2O_EDGE_LEVEL in the file), or all")
      ->capture_default_str();
  command->add_option("--json", options->json, "Write the summary as JSON here, - = stdout");
  command->add_option("--residuals", options->residuals,
                      "Write a CSV here, - = stdout: a line per edge with its error");
}

}  // namespace graft
