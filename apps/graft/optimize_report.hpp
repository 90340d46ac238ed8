// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/io/graph_loader.hpp"
#include "core/solve/summary.hpp"

namespace graft {

/// Seconds of a run, from the start of main.
struct RunTimes {
  double load = 0;
  double write = 0;
  double total = 0;
};

/// The text for people.
std::string formatSummary(const LoadedGraph& loaded, const Summary& summary, const RunTimes& times);

/// The document of --json; chi2_initial is null where the file has no vertices.
std::string formatJson(const LoadedGraph& loaded, const Summary& summary, const RunTimes& times);

}  // namespace graft
