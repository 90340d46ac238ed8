// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/error.hpp"

namespace graft::fuzz {

/// Bytes as a file that readers open by its name. The name is the same for every
/// File of a process; only one may live at a time.
class File {
 public:
  explicit File(std::string_view bytes);
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// A finding: says why and ends the process.
[[noreturn]] void fail(const std::string& why);
inline void require(bool holds, const std::string& what) {
  if (!holds) fail(what);
}

/// Ends the process unless this error blames the input: no reader may call a bug
/// of graft, the command line, an output or a plugin what foreign bytes brought about.
void requireBlamesInput(const Error& error);

/// Counts readings for the line "taken N of M" at the end of the process: a target whose
/// inputs are all refused tests little.
void count(bool taken);

/// Whether `read(diagnostics)` takes its input: it threw no Error and reported none.
/// Exceptions of other types leave, and are findings.
template <class Read>
bool accepts(Read&& read) {
  Diagnostics diagnostics;
  try {
    read(diagnostics);
  } catch (const Error& error) {
    requireBlamesInput(error);
    count(false);
    return false;
  }
  const bool taken = diagnostics.errorCount() == 0;
  count(taken);
  return taken;
}

/// What every target defines: gives the bytes to a reader, and checks what comes back.
void fuzzOne(std::string_view bytes);

}  // namespace graft::fuzz
