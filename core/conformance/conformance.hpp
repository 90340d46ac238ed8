// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "core/plugin/plugin_manager.hpp"

namespace graft {

struct ConformanceOptions {
  /// A graph file whose resources, measurements and estimates serve as further
  /// inputs; needed for types that random numbers cannot make. May be empty.
  std::string example;
  std::string only;  ///< tag or name of the one type to check; empty = all
  std::uint64_t seed = 1;
  int samples = 20;  ///< random inputs per type
  /// A check that takes longer, s, has failed.
  double check_seconds = 20;
  /// Not null: the run is given up once this is not 0.
  const std::atomic<int>* interrupt = nullptr;
  /// Files of plugins to load first.
  std::vector<std::string> required;
};

enum class Verdict { kPassed, kFailed, kSkipped };

struct CheckOutcome {
  Provided type;
  std::string check;  ///< e.g. "evaluate.overrun"
  Verdict verdict;
  std::string text;  ///< what is wrong, or why it was skipped
};

struct ConformanceReport {
  PluginFile file;
  std::vector<std::string> notes;
  std::vector<CheckOutcome> outcomes;  ///< by type, in the order of the checks
  std::size_t count(Verdict verdict) const;
};

/// Checks every type that a plugin registers, with nothing but what it
/// registers. All code of the plugin runs in child processes, one per type, so
/// that a crash or an endless loop fails one check and the rest goes on. Throws
/// Error(kPlugin) with the file where it cannot be loaded at all, Error(kUsage)
/// where it has no type `only`.
///
/// What is checked, for every callback: outputs are finite, written whole and
/// not beyond, inputs are left alone, a batch equals its items bit by bit, no
/// state between calls, none between threads, no assumption on alignment
/// beyond that of a double, nothing read beyond the inputs. And
///   vertex:   identity, plus, minus, normalize fit together
///   edge:     Jacobians against Ridders' method, propagate() makes the error
///             vanish, associate() is stable, shape() gives sizes
///   both:     written, read and written again is the same text
///   kernel:   rho(0) = 0, rho'(0) = 1, both derivatives, never falls
///   solver:   random block matrices against dense Cholesky
///   resource, loader: bad input is refused with a reason
///   all:      the metadata section lists what is registered
ConformanceReport checkPlugin(const std::string& file_or_name, const PluginOptions& plugins,
                              const ConformanceOptions& options);

}  // namespace graft
