// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft/robust_options.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/graft/engine_options.hpp"
#include "core/base/error.hpp"
#include "core/base/text.hpp"

namespace graft {

namespace {

[[noreturn]] void refuse(const std::string& text) { throw Error(ExitCode::kUsage, text); }

bool isWidth(double width) { return std::isfinite(width) && width > 0; }

}  // namespace

std::int32_t parseLevel(const std::string& text) {
  if (text == "all") return kAllLevels;
  std::int64_t level = 0;
  if (parseInteger(text, level) != NumberStatus::kOk || level < 0 ||
      level > std::numeric_limits<std::int32_t>::max()) {
    refuse("--level: expected 'all' or a number from 0, got " + graft::quoted(text));
  }
  return std::int32_t(level);
}

void RobustOptions::addTo(CLI::App& command) {
  CLI::Option* kernel = command.add_option(
      "--robust-kernel", kernels_,
      "Put a robust kernel on all edges, or on those of one tag, in place of the file's: NAME, "
      "NAME:WIDTH, TAG=NAME or TAG=NAME:WIDTH, e.g. Huber or EDGE_SE2=Cauchy:2 (repeatable); "
      "see 'graft plugins'; the name none takes kernels off");
  kernel->type_name("KERNEL")->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option("--kernel-width", kernel_width_,
                  "The width of kernels given without one (Huber: errors beyond it count linearly)")
      ->needs(kernel)
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      .add_option("--level", level_,
                  "Take the edges of this level (G2O_EDGE_LEVEL in the file), or all")
      ->type_name("N|all")
      ->capture_default_str();
  CLI::Option* gnc = command.add_option(
      "--gnc", gnc_,
      "Find edges that contradict the others and switch them off, by graduated non-convexity: "
      "tls (truncated least squares) or gm (Geman-McClure). Fast where the edges that are trusted "
      "determine every vertex");
  gnc->type_name("tls|gm")->check(CLI::IsMember({"tls", "gm"}).description(""))->excludes(kernel);
  command
      .add_option("--gnc-inlier-probability", gnc_probability_,
                  "An edge is off where noise as its information matrix says would be smaller "
                  "with this probability (chi-square quantile)")
      ->needs(gnc)
      ->capture_default_str();
  command
      .add_option("--gnc-trust", gnc_trust_,
                  "Edges that are never switched off: consecutive (default: those on one vertex, "
                  "and those of two vertices with successive ids), the edges of a TAG (both "
                  "repeatable), or none")
      ->type_name("consecutive|none|TAG")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->needs(gnc);
  command
      .add_option("--gnc-noise", gnc_noise_,
                  "fitted: thresholds are lowered where the edges that are kept show less noise "
                  "than their information matrices say, to thrice the deviation that they show; "
                  "given: they are not")
      ->type_name("fitted|given")
      ->check(CLI::IsMember({"fitted", "given"}).description(""))
      ->needs(gnc)
      ->capture_default_str();
  command
      .add_option("--gnc-level", gnc_level_,
                  "Write the edges that were switched off with this level into the output, so "
                  "that it is a graph without them")
      ->check(CLI::Range(1, std::numeric_limits<std::int32_t>::max()))
      ->needs(gnc);
}

RobustOptions::Request RobustOptions::parseKernel(Engine& engine, const std::string& text) const {
  Request request;
  std::string name = text;
  const std::size_t equals = name.find('=');
  if (equals != std::string::npos) {
    request.tag = name.substr(0, equals);
    name.erase(0, equals + 1);
    if (request.tag.empty()) refuse("--robust-kernel: no tag before '=' in " + graft::quoted(text));
  }
  request.kernel.width = kernel_width_;
  const std::size_t colon = name.rfind(':');
  if (colon != std::string::npos) {
    const std::string width = name.substr(colon + 1);
    name.erase(colon);
    if (parseDouble(width, request.kernel.width) != NumberStatus::kOk ||
        !isWidth(request.kernel.width)) {
      refuse("--robust-kernel: expected a positive number as width, got " + graft::quoted(width));
    }
  }
  if (name == "none") return request;
  request.kernel.type = engine.registry().kernel(name);
  if (request.kernel.type == nullptr) {
    refuse("unknown robust kernel " + graft::quoted(name) + knownNames(engine, Kind::kKernel));
  }
  return request;
}

void RobustOptions::resolve(Engine& engine, SolveOptions& solve) {
  if (!isWidth(kernel_width_)) refuse("--kernel-width: expected a positive number");
  for (const std::string& text : kernels_) {
    const Request request = parseKernel(engine, text);
    for (const Request& other : requests_) {
      if (other.tag != request.tag) continue;
      refuse("--robust-kernel: two kernels for " +
             (request.tag.empty() ? "all edges" : "the edges " + request.tag));
    }
    requests_.push_back(request);
  }
  std::stable_sort(requests_.begin(), requests_.end(), [](const Request& a, const Request& b) {
    return a.tag.empty() && !b.tag.empty();
  });
  solve.level = parseLevel(level_);
  if (gnc_.empty()) return;
  Graduation& graduation = solve.graduation;
  graduation.kind =
      gnc_ == "gm" ? RobustEstimation::kGemanMcClure : RobustEstimation::kTruncatedLeastSquares;
  graduation.inlier_probability = gnc_probability_;
  if (!(gnc_probability_ > 0 && gnc_probability_ < 1)) {
    refuse("--gnc-inlier-probability: expected a number between 0 and 1");
  }
  graduation.fit_noise = gnc_noise_ == "fitted";
  if (gnc_trust_.empty()) return;
  graduation.trust_consecutive = false;
  bool none = false;
  for (const std::string& text : gnc_trust_) {
    if (text == "consecutive") {
      graduation.trust_consecutive = true;
    } else if (text == "none") {
      none = true;
    } else {
      graduation.trusted_tags.push_back(text);
    }
  }
  if (none && gnc_trust_.size() > 1) refuse("--gnc-trust: none cannot be combined");
}

void RobustOptions::applyKernels(Graph& graph) const {
  for (const Request& request : requests_) {
    const auto has_tag = [&](const EdgeBlock& block) { return request.tag == block.type->tag; };
    if (!request.tag.empty() &&
        std::none_of(graph.edgeBlocks().begin(), graph.edgeBlocks().end(), has_tag)) {
      refuse("--robust-kernel: no edge has the tag " + graft::quoted(request.tag));
    }
    if (request.kernel.type == nullptr) {
      graph.clearKernels(request.tag);
    } else {
      graph.setKernel(request.kernel, request.tag);
    }
  }
}

void RobustOptions::markSwitchedOff(const Summary& summary, Graph& graph) const {
  if (gnc_level_ < 0) return;
  for (const SwitchedOff& off : summary.graduation.off) {
    graph.setLevel(off.block, off.edge, gnc_level_);
  }
}

Graph solvedGraph(const Graph& graph, std::int32_t level, const Summary& summary) {
  Graph solved = graph;
  for (std::size_t b = 0; b < graph.edgeBlocks().size(); ++b) {
    const EdgeBlock& block = graph.edgeBlocks()[b];
    for (std::size_t e = 0; e < block.size(); ++e) {
      solved.setLevel(b, e, level == kAllLevels || block.levels[e] == level ? 0 : 1);
    }
  }
  for (const SwitchedOff& off : summary.graduation.off) solved.setLevel(off.block, off.edge, 1);
  return solved;
}

}  // namespace graft
