// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft/optimize_report.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/base/memory.hpp"

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

/// As --initial-guess names it.
std::string startName(const Summary& summary) {
  switch (summary.start) {
    case StartKind::kGiven:
      return "file";
    case StartKind::kSpanningTree:
      return "spanning-tree";
    case StartKind::kChordal:
      return "chordal";
    case StartKind::kPlugin:
      return summary.start_name;
  }
  return "file";
}

/// A table with a line per iteration, as people who tune a problem read it.
std::string formatIterations(const Summary& summary) {
  constexpr std::size_t kHead = 15;
  constexpr std::size_t kTail = 10;
  constexpr std::size_t kStepColumns = 73;
  const auto& log = summary.iterations;
  const bool associates = summary.associations_changed > 0;
  std::string out = " iter           chi2     change  |gradient|    |step|   damping  factored";
  out += associates ? "  chosen anew" : "";
  out += "       s\n";
  for (std::size_t i = 0; i < log.size(); ++i) {
    if (log.size() > kHead + kTail + 1 && i == kHead) {
      i = log.size() - kTail;
      out += "  ... " + std::to_string(i - kHead) + " more, all are in --json ...\n";
    }
    const IterationRecord& record = log[i];
    char line[160];
    std::snprintf(line, sizeof line, "%5d %14.8g", record.iteration, record.chi2);
    std::string text = line;
    if (i == 0) {
      text.resize(kStepColumns, ' ');
    } else if (record.alternative) {
      std::snprintf(line, sizeof line, " %10.2e  another choice of an edge %14d",
                    -record.chi2_change, record.linear_solves);
      text += line;
    } else {
      char change[16] = "refused";
      if (record.accepted) std::snprintf(change, sizeof change, "%.2e", -record.chi2_change);
      std::snprintf(line, sizeof line, " %10s %11.2e %9.2e %9.2e %9d", change, record.gradient_max,
                    record.step_norm, record.damping, record.linear_solves);
      text += line;
    }
    if (associates) {
      const std::string chosen = i == 0 ? "" : std::to_string(record.associations_changed);
      text += std::string(13 - std::min<std::size_t>(13, chosen.size()), ' ') + chosen;
    }
    std::snprintf(line, sizeof line, " %7.3f\n", record.seconds);
    out += text + line;
  }
  return out;
}

nlohmann::ordered_json iterationLog(const Summary& summary) {
  nlohmann::ordered_json log = nlohmann::ordered_json::array();
  for (const IterationRecord& record : summary.iterations) {
    log.push_back({{"iteration", record.iteration},
                   {"chi2", record.chi2},
                   {"chi2_change", record.chi2_change},
                   {"accepted", record.accepted},
                   {"alternative", record.alternative},
                   {"gradient_max", record.gradient_max},
                   {"step_norm", record.step_norm},
                   {"damping", record.damping},
                   {"factorizations", record.linear_solves},
                   {"associations_changed", record.associations_changed},
                   {"seconds", record.seconds}});
  }
  return log;
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
  std::string out = summary.iterations.empty() ? "" : formatIterations(summary) + '\n';
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
    row("start", startName(summary) + ", chi2 " + number(summary.chi2_start));
  }
  const GraduationReport& graduation = summary.graduation;
  if (graduation.kind != RobustEstimation::kNone) {
    row("gnc", std::string(kindName(graduation.kind)) + ", " +
                   std::to_string(graduation.off.size()) + " of " +
                   std::to_string(graduation.candidates) + " edges switched off that might be, " +
                   std::to_string(graduation.rounds) + " rounds, " +
                   std::to_string(graduation.iterations) + " iterations");
  }
  if (summary.alternatives_tried > 0) {
    row("choices", std::to_string(summary.alternatives_tried) + " others tried, " +
                       std::to_string(summary.alternatives_taken) + " taken");
  }
  if (summary.inner_parts > 0) {
    row("inner", std::to_string(summary.inner_parts) +
                     (summary.inner_parts == 1 ? " part" : " parts") + ", solved after each step");
  }
  row("solver",
      summary.linear_solver + (summary.ordering.empty() ? "" : ", ordering " + summary.ordering) +
          (summary.factor_bytes > 0 ? ", " + formatBytes(summary.factor_bytes) : "") + ", " +
          std::to_string(summary.threads) + (summary.threads == 1 ? " thread" : " threads"));
  row("seconds", seconds(times.total) + " (load " + seconds(times.load) + ", initial guess " +
                     seconds(summary.seconds_guess) + ", solve " + seconds(summary.seconds_solve) +
                     ", write " + seconds(times.write) + ")");
  std::string phases;
  for (const auto& [phase, spent] : summary.seconds_by_phase) {
    if (spent > 0) phases += (phases.empty() ? "" : ", ") + phase + " " + seconds(spent);
  }
  if (!phases.empty()) row("of the solve", phases);
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
  document["start"] = startName(summary);
  document["chi2_start"] = summary.chi2_start;
  document["chi2_by_tag"] = summary.chi2_by_tag;
  document["linear_solver"] = summary.linear_solver;
  document["ordering"] = summary.ordering;
  document["factor_flops"] = summary.factor_flops;
  document["factor_bytes"] = summary.factor_bytes;
  document["associations_changed"] = summary.associations_changed;
  document["inner_parts"] = summary.inner_parts;
  document["alternatives"] = {{"tried", summary.alternatives_tried},
                              {"taken", summary.alternatives_taken}};
  document["notes"] = summary.notes;
  document["phases"] = summary.seconds_by_phase;
  document["log"] = iterationLog(summary);
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

}  // namespace graft
