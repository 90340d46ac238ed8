// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "core/io/graph_loader.hpp"
#include "core/plugin/engine.hpp"
#include "core/solve/optimizer.hpp"
#include "tests/bench/ceres_problem.hpp"

namespace {

constexpr int kRounds = 5;

/// The first vertex stays where it is for both, where nothing else is fixed.
std::int64_t heldVertex(const graft::Graph& graph) {
  const std::vector<graft::VertexRef> all = graph.verticesById();
  for (const graft::VertexRef v : all) {
    if (graph.isFixed(v)) return graph.id(v);
  }
  return graph.id(all.front());
}

double median(std::vector<double> list) {
  std::nth_element(list.begin(), list.begin() + kRounds / 2, list.end());
  return list[kRounds / 2];
}

void run(const std::string& path, int threads) {
  graft::Engine engine;
  graft::Diagnostics diagnostics;
  graft::LoadedGraph loaded = graft::loadGraph(path, engine.registry(), {}, diagnostics);
  const std::int64_t held = heldVertex(loaded.graph);
  loaded.graph.setFixed(loaded.graph.find(held), true);
  graft::SolveOptions options;
  options.threads = threads;
  options.iterations = 0;
  const double begin =
      graft::optimize(loaded.graph, loaded.values, engine.registry(), options).chi2_final;
  options.iterations = 200;
  options.function_tolerance = 1e-6;
  options.initial_guess = graft::InitialGuess::kFile;
  std::vector<double> ours;
  std::vector<double> theirs;
  std::vector<double> ratios;
  graft::Summary summary;
  graft::bench::PeerResult peer;
  // One after the other within a round, so that a busy moment meets both.
  for (int round = 0; round < kRounds; ++round) {
    graft::Values values = loaded.values;
    summary = graft::optimize(loaded.graph, values, engine.registry(), options);
    peer = graft::bench::solveWithCeres(loaded.graph, loaded.values, held, threads);
    ours.push_back(summary.seconds_guess + summary.seconds_solve);
    theirs.push_back(peer.seconds);
    ratios.push_back(theirs.back() / ours.back());
  }
  std::printf("%-24s %12.6g | %12.8g %4d %8.4f | %12.8g %4d %8.4f | %6.2f\n",
              path.substr(path.find_last_of('/') + 1).c_str(), begin, summary.chi2_final,
              summary.iterationCount(), median(ours), peer.chi2, peer.iterations, median(theirs),
              median(ratios));
}

}  // namespace

int main(int argc, char** argv) {
  int threads = 1;
  std::vector<std::string> paths;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--threads" && i + 1 < argc) {
      threads = std::max(1, std::atoi(argv[++i]));
    } else {
      paths.emplace_back(argv[i]);
    }
  }
  std::printf("%-24s %12s | %12s %4s %8s | %12s %4s %8s | %6s\n", "graph", "start chi2",
              "graft chi2", "it", "s", "Ceres chi2", "it", "s", "ratio");
  for (const std::string& path : paths) {
    try {
      run(path, threads);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: error: %s\n", path.c_str(), error.what());
    }
  }
  return paths.empty() ? 2 : 0;
}
