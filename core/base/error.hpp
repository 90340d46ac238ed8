// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace graft {

/// Exit codes shared by every program of the project. An Error carries one, so
/// that the place that finds a defect also decides how the process ends.
enum class ExitCode : int {
  kSuccess = 0,
  kInternal = 1,   ///< a bug in graft
  kUsage = 2,      ///< the command line
  kInput = 3,      ///< an input file is rejected
  kNoResult = 4,   ///< numerical failure, no common grasp, nothing reachable
  kOutput = 5,     ///< an output cannot be written, or other I/O
  kResources = 6,  ///< memory or a stated limit
  kPlugin = 7,     ///< a plugin is refused or misbehaves
  kInterrupted = 130,
  kTerminated = 143,
};

/// Where in an input something was found. Line and column count from 1; 0 means
/// "not known" and is left out of messages.
struct SourceLocation {
  std::string path;
  std::int64_t line = 0;
  std::int64_t column = 0;
};

/// The one exception type of the project. `what()` is the text alone;
/// `formatted()` is `path:line:column: error: text`.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& text) : Error(code, SourceLocation{}, text) {}
  Error(ExitCode code, SourceLocation where, const std::string& text)
      : std::runtime_error(text), code_(code), where_(std::move(where)) {}

  ExitCode code() const noexcept { return code_; }
  const SourceLocation& where() const noexcept { return where_; }
  std::string formatted() const;

 private:
  ExitCode code_;
  SourceLocation where_;
};

/// Formats `path:line:column: severity: text`, leaving out what is not known.
/// Control bytes of `text` and of the path are shown as \xNN.
std::string formatMessage(const SourceLocation& where, std::string_view severity,
                          std::string_view text);

/// Shows control bytes as \xNN and cuts the token at 64 bytes, for messages.
std::string quoted(std::string_view token);

/// Collects what was found wrong or noteworthy while an input is read, so that
/// one run reports all defects. Nothing is dropped: beyond `kShown` per
/// severity only the count is kept, and printed.
class Diagnostics {
 public:
  static constexpr std::size_t kShown = 20;

  enum class Severity { kNote, kWarning, kError };
  struct Message {
    Severity severity;
    SourceLocation where;
    std::string text;
  };

  void error(SourceLocation where, const std::string& text);
  void warning(SourceLocation where, const std::string& text);
  void note(SourceLocation where, const std::string& text);

  std::size_t errorCount() const { return error_count_; }
  std::size_t warningCount() const { return warning_count_; }
  const std::vector<std::string>& lines() const { return lines_; }
  /// The same messages in parts, to pass them on; cut like lines().
  const std::vector<Message>& messages() const { return messages_; }

  /// All messages, one per line, ending with "... and N more errors" if cut.
  std::string text() const;
  /// Throws the first error (with all messages in `text()`) if there is one.
  void throwIfErrors(ExitCode code = ExitCode::kInput) const;
  void append(const Diagnostics& other);
  void clear() { *this = Diagnostics(); }

 private:
  void add(std::size_t& count, Message message);

  std::size_t error_count_ = 0;
  std::size_t warning_count_ = 0;
  std::size_t note_count_ = 0;
  std::vector<std::string> lines_;
  std::vector<Message> messages_;
};

/// Thrown by Diagnostics::throwIfErrors: `formatted()` of it is the complete,
/// already formatted list of messages.
class InputErrors : public Error {
 public:
  InputErrors(ExitCode code, const std::string& all_messages) : Error(code, all_messages) {}
};

}  // namespace graft
