// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include "apps/graft/commands.hpp"
#include "apps/graft/simulated_graph.hpp"
#include "core/base/file.hpp"

namespace graft {

void addSimulate(Program& program) {
  struct Options {
    SimulationOptions simulation;
    std::string output = "-";
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      program.add("simulate", "Make a pose graph with noise, of any size", [options] {
        if (options->output != "-") checkWritable(options->output);
        writeFileAtomically(options->output, simulateGraph(options->simulation));
        return ExitCode::kSuccess;
      });
  command->add_option("SHAPE", options->simulation.kind, "sphere, torus, grid or manhattan")
      ->required();
  command->add_option("-o,--output", options->output, "Graph file to write, - = stdout")
      ->capture_default_str();
  command
      ->add_option("--size", options->simulation.size,
                   "Poses along a ring or side; hundreds of steps of a manhattan walk")
      ->check(CLI::Range(2, 10000))
      ->capture_default_str();
  command->add_option("--seed", options->simulation.seed, "Seed of the noise")
      ->capture_default_str();
  command->add_option("--sigma-t", options->simulation.sigma_t, "Noise of translation, m")
      ->capture_default_str();
  command->add_option("--sigma-r", options->simulation.sigma_r, "Noise of rotation, rad")
      ->capture_default_str();
  command->add_flag("--truth", options->simulation.truth,
                    "Vertices at the true poses instead of dead reckoning");
}

}  // namespace graft
