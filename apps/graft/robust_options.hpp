// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"

namespace graft {

/// Options of `optimize` about edges that may be wrong: robust kernels, levels,
/// graduated non-convexity.
class RobustOptions {
 public:
  void addTo(CLI::App& command);

  /// Understands what was given and enters it into the solve's options. Throws
  /// Error(kUsage) with the option's name.
  void resolve(Engine& engine, SolveOptions& solve);

  /// Whether applyKernels() changes anything.
  bool givesKernels() const { return !requests_.empty(); }
  /// Puts the kernels that were asked for on a graph, in place of the file's. Throws
  /// Error(kUsage) for a tag that no edge has.
  void applyKernels(Graph& graph) const;

  /// Puts the edges that were switched off on the level that --gnc-level asks for, if any.
  void markSwitchedOff(const Summary& summary, Graph& graph) const;

 private:
  struct Request {
    std::string tag;  ///< empty = all edges
    Kernel kernel;    ///< type null = none
  };
  Request parseKernel(Engine& engine, const std::string& text) const;

  std::vector<std::string> kernels_;
  double kernel_width_ = 1.0;
  std::string level_ = "0";
  std::string gnc_;
  double gnc_probability_ = 0.99;
  std::vector<std::string> gnc_trust_;
  std::string gnc_noise_ = "fitted";
  int gnc_level_ = -1;
  std::vector<Request> requests_;  ///< those for all edges first
};

/// "all" or a number from 0. Throws Error(kUsage).
std::int32_t parseLevel(const std::string& text);

/// The graph whose level 0 is what a solve minimised: the edges of its level without
/// those that were switched off.
Graph solvedGraph(const Graph& graph, std::int32_t level, const Summary& summary);

}  // namespace graft
