// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/options.hpp"

#include <cmath>

#include "core/base/text.hpp"
#include "core/solve/summary.hpp"

namespace graft {

std::string SolveOptions::validate() const {
  const auto number = [](const char* name, double value, double low, const char* rule) {
    if (std::isfinite(value) && value >= low) return std::string();
    return std::string(name) + " is " + formatDouble(value) + ", but must be " + rule;
  };
  const std::string checks[] = {
      number("iterations", iterations, 0, "0 or more"),
      number("threads", threads, 0, "0 or more"),
      number("alternatives", alternatives, 0, "0 or more"),
      number("inner_iterations", inner_iterations, 0, "0 or more"),
      number("time_limit", time_limit, 0, "0 or more"),
      number("function_tolerance", function_tolerance, 0, "0 or more"),
      number("association_tolerance", association_tolerance, 0, "0 or more"),
      number("step_tolerance", step_tolerance, 0, "0 or more"),
      number("gradient_tolerance", gradient_tolerance, 0, "0 or more"),
      number("initial_damping", initial_damping, 1e-20, "1e-20 or more")};
  for (const std::string& check : checks) {
    if (!check.empty()) return check;
  }
  if ((initial_guess == InitialGuess::kPlugin) == guess_name.empty()) {
    return guess_name.empty()
               ? "guess_name is empty, but the initial guess is a plugin's"
               : "guess_name is " + guess_name + ", but the initial guess is not a plugin's";
  }
  if (level < kAllLevels) {
    return "level is " + std::to_string(level) + ", but must be 0 or more, or -1 for all";
  }
  const double probability = graduation.inlier_probability;
  if (!(probability > 0 && probability < 1)) {
    return "inlier_probability is " + formatDouble(probability) + ", but must be between 0 and 1";
  }
  if (threads > 1024) return "threads is " + std::to_string(threads) + ", but must be at most 1024";
  return {};
}

const char* statusName(Status status) {
  switch (status) {
    case Status::kConverged:
      return "converged";
    case Status::kIterationLimit:
      return "iteration_limit";
    case Status::kTimeLimit:
      return "time_limit";
    case Status::kInterrupted:
      return "interrupted";
    case Status::kFailed:
      return "failed";
  }
  return "failed";
}

}  // namespace graft
