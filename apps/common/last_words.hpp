// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

namespace graft {

/// Makes a plugin that brings the process down say its name: a crash (SIGSEGV, SIGBUS,
/// SIGFPE, SIGILL, SIGABRT) and exit() inside a function of a plugin end the program
/// with `path: error: TYPE: function() ...` and exit code 7. Outputs are written at the
/// end and as a whole, so that earlier ones stay as they were. Crashes elsewhere, and
/// those of builds with a sanitizer, end as usual. Also, a lack of memory that no
/// exception can report any more ends with exit code 6 (from before main() on).
void installLastWords();

/// Ends the program, as above, where a function of a plugin never returns.
/// - Once `limit` seconds have passed: a call that handles a few hundred items and has lasted
///   for kPatience seconds or more (or for as long as the limit, if that is more).
/// - Any call, those of loaders, resources and initial guesses as well, that shows no sign of
///   life for `patience` seconds: a loader that calls back to the graph is alive.
/// Linear solvers are left alone: one call factors a whole system. 0 = not watched. Where the
/// system has no thread to give, nothing is.
class Watchdog {
 public:
  static constexpr double kPatience = 5;

  Watchdog(double limit, double patience);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

/// Where a thread is in a plugin, for a handler that ends the process: "path: error:
/// TYPE: function() <what>"; nothing if none is. Safe in a signal handler.
void sayActivity(const char* what);

}  // namespace graft
