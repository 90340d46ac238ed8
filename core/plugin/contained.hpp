// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

namespace graft {

/// What a contained run may use.
struct ContainedLimits {
  /// Wall time, s, between two steps (and to the first, and after the last).
  double step_seconds = 5;
  /// Address space beyond that of this process, bytes; 0 = no limit. Not used
  /// where a sanitizer, which reserves terabytes, is built in.
  std::size_t memory = std::size_t{1} << 31;
  /// Not null: a run is given up once this is not 0.
  const std::atomic<int>* interrupt = nullptr;
};

/// The child's line to its parent.
class ContainedChannel {
 public:
  explicit ContainedChannel(int fd) : fd_(fd) {}
  /// Says what is done next, and restarts the clock.
  void step(const std::string& what) { send('s', what); }
  /// Hands a text to the parent.
  void message(const std::string& text) { send('m', text); }

 private:
  friend class ContainedChild;
  void send(char kind, const std::string& text);
  int fd_;
};

/// How a contained run ended.
struct ContainedResult {
  bool finished = false;  ///< the body returned
  /// Otherwise why: "signal 11 (Segmentation fault)", "no answer within 5 s",
  /// "it ended the process (exit status 0)", or the text of its exception.
  std::string failure;
  bool threw = false;  ///< `failure` is an exception's text
  std::string last_step;
  std::vector<std::string> messages;
  std::string said;  ///< first line that it wrote to its standard streams
};

/// Runs `body` in a child process: a crash, an endless loop, an exit or greed
/// for memory ends the child alone. Its standard input is empty, its standard
/// output and error are caught. Throws Error(kResources) where no process can
/// be made, and Error(kInterrupted) on an interrupt.
ContainedResult runContained(const ContainedLimits& limits,
                             const std::function<void(ContainedChannel&)>& body);

}  // namespace graft
