// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft/optimize_report.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace graft {

namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

std::string seconds(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", value);
  return text;
}

const char* kindName(RobustEstimation kind) {
  return kind == RobustEstimation::kGemanMcClure ? "gm" : "tls";
}

nlohmann::ordered_json describeGraduation(const GraduationReport& report) {
  nlohmann::ordered_json document;
  document["kind"] = kindName(report.kind);
  document["candidates"] = report.candidates;
  document["noise_factor"] = report.noise_factor;
  document["passes"] = report.passes;
  document["rounds"] = report.rounds;
  document["iterations"] = report.iterations;
  document["off"] = nlohmann::ordered_json::array();
  for (const SwitchedOff& off : report.off) {
    document["off"].push_back({{"tag", off.tag},
                               {"ids", off.ids},
                               {"line", off.line},
                               {"weight", off.weight},
                               {"chi2", off.square},
                               {"threshold", off.threshold}});
  }
  return document;
}

}  // namespace

std::string formatSummary(const LoadedGraph& loaded, const Summary& summary,
                          const RunTimes& times) {
  std::string out;
  const auto row = [&out](const char* name, const std::string& text) {
    out += std::string(name);
    out.resize(out.size() + 14 - std::string(name).size(), ' ');
    out += text + '\n';
  };
  row("status", std::string(statusName(summary.status)) +
                    (summary.reason.empty() ? "" : " (" + summary.reason + ")"));
  row("vertices", std::to_string(loaded.counts.vertices));
  row("edges", std::to_string(loaded.counts.edges));
  row("iterations", std::to_string(summary.iterationCount()));
  row("chi2 initial",
      loaded.vertices_made ? "- (no estimates in the file)" : number(summary.chi2_initial));
  row("chi2 final", number(summary.chi2_final));
  if (summary.chi2_by_tag.size() > 1) {
    for (const auto& [tag, chi2] : summary.chi2_by_tag) row("", number(chi2) + "  " + tag);
  }
  if (summary.start != StartKind::kGiven) {
    const bool chordal = summary.start == StartKind::kChordal;
    row("start", std::string(chordal ? "chordal relaxation" : "spanning tree") + ", chi2 " +
                     number(summary.chi2_start));
  }
  const GraduationReport& graduation = summary.graduation;
  if (graduation.kind != RobustEstimation::kNone) {
    row("gnc", std::string(kindName(graduation.kind)) + ", " +
                   std::to_string(graduation.off.size()) + " of " +
                   std::to_string(graduation.candidates) + " edges switched off that might be, " +
                   std::to_string(graduation.rounds) + " rounds, " +
                   std::to_string(graduation.iterations) + " iterations");
  }
  row("solver",
      summary.linear_solver + (summary.ordering.empty() ? "" : ", ordering " + summary.ordering) +
          ", " + std::to_string(summary.threads) + (summary.threads == 1 ? " thread" : " threads"));
  row("seconds", seconds(times.total) + " (load " + seconds(times.load) + ", initial guess " +
                     seconds(summary.seconds_guess) + ", solve " + seconds(summary.seconds_solve) +
                     ", write " + seconds(times.write) + ")");
  return out;
}

std::string formatJson(const LoadedGraph& loaded, const Summary& summary, const RunTimes& times) {
  nlohmann::ordered_json document;
  document["status"] = statusName(summary.status);
  document["reason"] = summary.reason;
  document["iterations"] = summary.iterationCount();
  document["chi2_initial"] = nullptr;
  if (!loaded.vertices_made) document["chi2_initial"] = summary.chi2_initial;
  document["chi2_final"] = summary.chi2_final;
  document["vertices"] = loaded.counts.vertices;
  document["edges"] = loaded.counts.edges;
  document["threads"] = summary.threads;
  if (summary.graduation.kind != RobustEstimation::kNone) {
    document["gnc"] = describeGraduation(summary.graduation);
  }
  document["seconds"] = {{"load", times.load},
                         {"initial_guess", summary.seconds_guess},
                         {"solve", summary.seconds_solve},
                         {"write", times.write},
                         {"total", times.total}};
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

}  // namespace graft
