// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "apps/graft/commands.hpp"
#include "apps/graft/engine_options.hpp"
#include "apps/graft/simulated_world.hpp"
#include "core/base/file.hpp"
#include "core/graph/factor_graph.hpp"
#include "core/io/g2o_writer.hpp"

namespace graft {

namespace {

struct SimulateOptions {
  std::string world;
  std::string output;
  std::string truth;
  int size = 0;
  double sigma_t = 0.05;
  double sigma_r = 0.02;
  std::uint64_t seed = 1;
};

SimulatedWorld makeWorld(const SimulateOptions& options, NormalDeviates& random) {
  const auto size = [&options](int usual) { return options.size > 0 ? options.size : usual; };
  if (options.world == "sphere") return sphereWorld(size(50));
  if (options.world == "torus") return torusWorld(size(50));
  if (options.world == "grid") return gridWorld(size(10));
  return manhattanWorld(size(3500), random);
}

/// Upper triangle of diag(1/sigma^2), translation first.
std::vector<double> information(int translations, int rotations, double sigma_t, double sigma_r) {
  std::vector<double> upper;
  const int n = translations + rotations;
  for (int r = 0; r < n; ++r) {
    for (int c = r; c < n; ++c) {
      const double sigma = r < translations ? sigma_t : sigma_r;
      upper.push_back(r == c ? 1 / (sigma * sigma) : 0);
    }
  }
  return upper;
}

template <class P>
std::vector<double> numbersOf(const P& pose) {
  std::vector<double> numbers(P::kAmbientDim);
  pose.toArray(numbers.data());
  return numbers;
}

/// Adds vertices (true, or chained odometry) and noisy edges of one pose type.
template <class P>
void fill(const std::vector<P>& truth, const SimulatedWorld& world, const SimulateOptions& options,
          const char* vertex_tag, const char* edge_tag, double chart, NormalDeviates& random,
          FactorGraph& measured, FactorGraph* exact) {
  constexpr int kDim = P::kTangentDim;
  constexpr int kTranslations = kDim == 6 ? 3 : 2;
  // `chart`: radians per unit of the edge's rotation error.
  const std::vector<double> weights =
      information(kTranslations, kDim - kTranslations, options.sigma_t, options.sigma_r / chart);
  std::vector<P> measurements;
  std::vector<P> estimates(truth.size());
  estimates[0] = truth[0];
  for (const auto& [a, b] : world.edges) {
    Vec<double, kDim> noise;
    for (int k = 0; k < kDim; ++k) {
      noise[k] = random.next() * (k < kTranslations ? options.sigma_t : options.sigma_r);
    }
    P measurement = (truth[std::size_t(a)].inverse() * truth[std::size_t(b)]).plus(noise);
    measurement.renormalize();
    if (b == a + 1) {
      estimates[std::size_t(b)] = estimates[std::size_t(a)] * measurement;
      estimates[std::size_t(b)].renormalize();
    }
    measurements.push_back(measurement);
  }
  for (std::size_t i = 0; i < truth.size(); ++i) {
    measured.addVertex(vertex_tag, std::int64_t(i), numbersOf(estimates[i]));
    if (exact != nullptr) exact->addVertex(vertex_tag, std::int64_t(i), numbersOf(truth[i]));
  }
  for (std::size_t e = 0; e < world.edges.size(); ++e) {
    const auto& [a, b] = world.edges[e];
    measured.addEdge(edge_tag, {a, b}, numbersOf(measurements[e]), weights);
  }
}

ExitCode run(const SimulateOptions& options) {
  for (const std::string* path : {&options.output, &options.truth}) {
    if (!path->empty() && *path != "-") checkWritable(*path);
  }
  const auto engine = makeEngine({});
  NormalDeviates random(options.seed);
  const SimulatedWorld world = makeWorld(options, random);
  FactorGraph measured(engine->registry());
  FactorGraph exact(engine->registry());
  FactorGraph* truth = options.truth.empty() ? nullptr : &exact;
  if (world.planar()) {
    fill(world.plane, world, options, "VERTEX_SE2", "EDGE_SE2", 1, random, measured, truth);
  } else {
    fill(world.space, world, options, "VERTEX_SE3:QUAT", "EDGE_SE3:QUAT", 2, random, measured,
         truth);
  }
  writeFileAtomically(options.output, formatG2o(measured.graph(), measured.values()));
  if (truth != nullptr) {
    writeFileAtomically(options.truth, formatG2o(exact.graph(), exact.values()));
  }
  if (options.output != "-") {
    std::printf("%zu vertices, %zu edges\n", world.size(), world.edges.size());
  }
  return ExitCode::kSuccess;
}

}  // namespace

void addSimulate(Program& program) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App* command =
      program.add("simulate", "Write a graph of a simulated robot: truth, noise, odometry",
                  [options] { return run(*options); });
  command->add_option("WORLD", options->world, "sphere, torus, grid or manhattan")
      ->required()
      ->check(CLI::IsMember({"sphere", "torus", "grid", "manhattan"}));
  command->add_option("-o,--output", options->output, "Graph file, - = stdout")->required();
  command
      ->add_option("--size", options->size,
                   "Rings and poses a ring (sphere, torus: 50), poses a side (grid: 10), steps "
                   "(manhattan: 3500)")
      ->check(CLI::Range(2, 1000000));
  command->add_option("--sigma-t", options->sigma_t, "Noise of translations, m")
      ->check(CLI::Range(1e-9, 1e9))
      ->capture_default_str();
  command->add_option("--sigma-r", options->sigma_r, "Noise of rotations, rad")
      ->check(CLI::Range(1e-9, 1e9))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Seed of the noise")->capture_default_str();
  command->add_option("--truth", options->truth, "Write the true poses here");
}

}  // namespace graft
