// SPDX-License-Identifier: BSD-3-Clause
#include "apps/common/interrupt.hpp"

#include <signal.h>
#include <time.h>
#include <unistd.h>

#include "apps/common/last_words.hpp"

namespace graft {

namespace {

std::atomic<int> received{0};
static_assert(std::atomic<int>::is_always_lock_free, "used in a signal handler");

std::atomic<long> first_time{0};  // ms
static_assert(std::atomic<long>::is_always_lock_free, "used in a signal handler");

// Programs like timeout(1) signal a process and then its group, at once: only a later
// signal is a second wish.
constexpr long kApart = 500;  // ms

void handle(int signal) {
  timespec now = {};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  const long milliseconds = now.tv_sec * 1000 + now.tv_nsec / 1000000;
  int none = 0;
  if (received.compare_exchange_strong(none, signal)) {
    first_time = milliseconds;
  } else if (milliseconds - first_time >= kApart) {
    sayActivity("was running when a second signal ended the program");
    ::_exit(128 + signal);
  }
}

}  // namespace

void installInterruptHandlers() {
  struct sigaction action = {};
  action.sa_handler = &handle;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction old = {};
    // What the caller chose to ignore (nohup) stays ignored.
    if (::sigaction(signal, nullptr, &old) == 0 && old.sa_handler == SIG_IGN) continue;
    ::sigaction(signal, &action, nullptr);
  }
  struct sigaction ignore = {};
  ignore.sa_handler = SIG_IGN;
  ::sigaction(SIGPIPE, &ignore, nullptr);
  ::sigaction(SIGXFSZ, &ignore, nullptr);
}

const std::atomic<int>& interruptFlag() { return received; }

ExitCode interruptExitCode() {
  return received == SIGINT ? ExitCode::kInterrupted : ExitCode::kTerminated;
}

}  // namespace graft
