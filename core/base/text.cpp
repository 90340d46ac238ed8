// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/text.hpp"

#include <charconv>
#include <cmath>
#include <cstdlib>

#include "core/base/error.hpp"

namespace graft {

namespace {

bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

/// from_chars reports underflow and overflow alike and leaves the value alone;
/// the decimal exponent of the token tells which of the two it was.
bool isUnderflow(std::string_view token) {
  const std::size_t e = token.find_first_of("eE");
  if (e == std::string_view::npos) {
    return token.find_first_of("123456789") > token.find('.');
  }
  return e + 1 < token.size() && token[e + 1] == '-';
}

}  // namespace

NumberStatus parseDouble(std::string_view token, double& value) {
  if (token.empty()) return NumberStatus::kEmpty;
  std::string_view digits = token;
  if (digits.front() == '+') {
    digits.remove_prefix(1);
    if (digits.empty() || digits.front() == '-' || digits.front() == '+') {
      return NumberStatus::kNotANumber;
    }
  }
  double parsed = 0;
  const char* end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, parsed);
  if (error == std::errc::invalid_argument) return NumberStatus::kNotANumber;
  if (stop != end) {
    return *stop == ',' ? NumberStatus::kDecimalComma : NumberStatus::kNotANumber;
  }
  if (error == std::errc::result_out_of_range) {
    if (!isUnderflow(digits)) return NumberStatus::kOutOfRange;
    value = digits.front() == '-' ? -0.0 : 0.0;
    return NumberStatus::kOk;
  }
  if (!std::isfinite(parsed)) return NumberStatus::kNotFinite;
  value = parsed;
  return NumberStatus::kOk;
}

NumberStatus parseInteger(std::string_view token, std::int64_t& value) {
  if (token.empty()) return NumberStatus::kEmpty;
  std::string_view digits = token;
  if (digits.front() == '+') digits.remove_prefix(1);
  std::int64_t parsed = 0;
  const char* end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, parsed);
  if (error == std::errc::invalid_argument) return NumberStatus::kNotANumber;
  if (stop != end) return NumberStatus::kNotANumber;
  if (error == std::errc::result_out_of_range) return NumberStatus::kOutOfRange;
  value = parsed;
  return NumberStatus::kOk;
}

std::string describe(NumberStatus status, std::string_view token) {
  switch (status) {
    case NumberStatus::kOk:
      return quoted(token) + " is a number";
    case NumberStatus::kEmpty:
      return "expected a number, the line ends";
    case NumberStatus::kNotANumber:
      return quoted(token) + " is not a number";
    case NumberStatus::kNotFinite:
      return quoted(token) + " is not a finite number";
    case NumberStatus::kOutOfRange:
      return quoted(token) + " is out of range";
    case NumberStatus::kDecimalComma:
      return quoted(token) + " is not a number (decimal comma? use '.')";
  }
  return quoted(token) + " is not a number";
}

void appendDouble(std::string& out, double value) {
  char buffer[32];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
  if (error == std::errc()) out.append(buffer, end);
}

std::string formatDouble(double value) {
  std::string out;
  appendDouble(out, value);
  return out;
}

void LineTokens::skipBlanks() {
  while (position_ < line_.size() && isBlank(line_[position_])) ++position_;
  if (position_ < line_.size() && line_[position_] == '#') position_ = line_.size();
}

std::string_view LineTokens::next() {
  skipBlanks();
  column_ = static_cast<std::int64_t>(position_) + 1;
  const std::size_t begin = position_;
  while (position_ < line_.size() && !isBlank(line_[position_])) ++position_;
  return line_.substr(begin, position_ - begin);
}

bool LineTokens::atEnd() {
  skipBlanks();
  return position_ >= line_.size();
}

LineReader::LineReader(std::string_view text) : rest_(text) {
  constexpr std::string_view kBom = "\xef\xbb\xbf";
  if (rest_.substr(0, kBom.size()) == kBom) rest_.remove_prefix(kBom.size());
}

bool LineReader::next(std::string_view& line) {
  if (rest_.empty()) return false;
  const std::size_t end = rest_.find('\n');
  line = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  ++line_number_;
  return true;
}

}  // namespace graft
