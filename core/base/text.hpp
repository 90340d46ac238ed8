// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace graft {

/// Why a token is not the number asked for; kOk means it is.
enum class NumberStatus { kOk, kEmpty, kNotANumber, kNotFinite, kOutOfRange, kDecimalComma };

/// Reads one whole token as a finite double, independent of the locale.
/// A leading '+' is accepted; values too small for a double become 0 or the
/// nearest denormal; hexadecimal and partial tokens are refused.
NumberStatus parseDouble(std::string_view token, double& value);

/// Reads one whole token as a decimal integer. "2.7" and "1e3" are refused.
NumberStatus parseInteger(std::string_view token, std::int64_t& value);

/// Text for a message, e.g. "'nan' is not a finite number".
std::string describe(NumberStatus status, std::string_view token);

/// Appends the shortest decimal text that reads back as exactly `value`.
void appendDouble(std::string& out, double value);
std::string formatDouble(double value);

/// Splits one line into tokens at blanks and tabs and knows the column of each.
class LineTokens {
 public:
  explicit LineTokens(std::string_view line) : line_(line) {}

  /// Next token, empty at the end of the line. A token that starts with '#'
  /// ends the line (comment).
  std::string_view next();
  /// True if a further token exists; does not consume it.
  bool atEnd();
  /// Column (from 1) of the token that next() returned last, or where the line
  /// ended if there was none.
  std::int64_t column() const { return column_; }

 private:
  void skipBlanks();

  std::string_view line_;
  std::size_t position_ = 0;
  std::int64_t column_ = 1;
};

/// Iterates over the lines of a text held in memory; accepts LF and CRLF, and
/// skips an UTF-8 byte order mark. Line numbers count from 1.
class LineReader {
 public:
  explicit LineReader(std::string_view text);

  /// Moves to the next line; false at the end of the text.
  bool next(std::string_view& line);
  std::int64_t lineNumber() const { return line_number_; }

 private:
  std::string_view rest_;
  std::int64_t line_number_ = 0;
};

}  // namespace graft
